"""The study log as a table: every variable that ppinfer knows, its dimensions, type and meaning.

Storage, validation and the documentation all read this one table. A log may hold other variables besides (on
any of its dimensions); they are kept as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

FORMAT = "study-log"
FORMAT_VERSION = 1
DIGEST_ATTR = "content_sha256"
# what a logged control may be: the attribute `quantity` of `control`
CONTROL_QUANTITIES = ("velocity", "acceleration", "other")

DIMS = (
    "trial", "sample", "agent", "space", "goal", "segment", "replan", "plan", "waypoint", "profile", "theta", "table",
)  # fmt: skip

Kind = Literal["str", "float64", "int64", "int8"]


@dataclass(frozen=True)
class VariableSpec:
    """One variable of the log.

    Parameters
    ----------
    name, kind, meaning
        What it is called, its type (``str`` is text of any length) and what it says.
    dims
        The dimensions it may have: the first are the usual ones, further ones are alternatives.
    required
        Whether a log without it is faulty.
    units
        Units when they do not depend on the study.
    as_variable
        Whether `build_log` and `Trial` take it among ``variables``, instead of as an argument of its own.
    """

    name: str
    dims: tuple[tuple[str, ...], ...]
    kind: Kind
    meaning: str
    required: bool = False
    units: str = ""
    as_variable: bool = False


_PER_SAMPLE = (("sample", "agent", "space"),)
_PER_TRIAL = (("trial",),)
_PER_TRIAL_AGENT = (("trial", "agent"),)
_PER_SEGMENT = (("segment",),)
_PER_REPLAN = (("replan",),)
_PER_REPLAN_AGENT = (("replan", "agent"),)

VARIABLES: dict[str, VariableSpec] = {
    spec.name: spec
    for spec in (
        VariableSpec("agent", (("agent",),), "str", "labels of the agents", required=True),
        VariableSpec("space", (("space",),), "str", "labels of the coordinates: x, y", required=True),
        VariableSpec("goal", (("goal",),), "str", "labels of the goals"),
        VariableSpec("trial_id", _PER_TRIAL, "str", "unique name of the trial", required=True),
        VariableSpec("row_size", _PER_TRIAL, "int64", "number of samples of the trial, >= 1", required=True),
        VariableSpec("participant", _PER_TRIAL, "str", "who took part", required=True),
        VariableSpec("condition", _PER_TRIAL, "str", "the experimental condition"),
        VariableSpec("round", _PER_TRIAL, "int64", "which repetition, from 0"),
        VariableSpec("seed", _PER_TRIAL, "int64", "seed of a simulated trial"),
        VariableSpec("outcome", _PER_TRIAL, "str", "how the trial ended; empty = unknown"),
        VariableSpec("controller", _PER_TRIAL_AGENT, "str", "the policy or person that moved the agent"),
        VariableSpec("instruction", _PER_TRIAL_AGENT, "str", "what the agent was asked to be"),
        VariableSpec("time", (("sample",),), "float64", "strictly increasing within a trial", True, "s"),
        VariableSpec("position", _PER_SAMPLE, "float64", "NaN exactly where observed is 0", required=True),
        VariableSpec("observed", (("sample", "agent"),), "int8", "1 = seen, 0 = dropout", required=True),
        VariableSpec("velocity", _PER_SAMPLE, "float64", "as logged; NaN where has_velocity is 0"),
        VariableSpec("control", _PER_SAMPLE, "float64", "as logged; NaN where has_control is 0"),
        VariableSpec("has_velocity", (("agent",),), "int8", "1 = the agent's velocity was logged"),
        VariableSpec("has_control", (("agent",),), "int8", "1 = the agent's control was logged"),
        VariableSpec(
            "goal_position",
            (("trial", "goal", "space"), ("sample", "goal", "space")),
            "float64",
            "where the goals are; NaN exactly where goal_present is 0",
        ),
        VariableSpec(
            "goal_present", (("trial", "goal"), ("sample", "goal")), "int8", "1 = the goal exists, 0 = absent"
        ),
        VariableSpec("segment_trial", _PER_SEGMENT, "int64", "index of the segment's trial"),
        VariableSpec("segment_agent", _PER_SEGMENT, "str", "label of the agent that moves"),
        VariableSpec("segment_start", _PER_SEGMENT, "int64", "first sample, counted within the trial"),
        VariableSpec("segment_stop", _PER_SEGMENT, "int64", "one past the last sample, within the trial"),
        VariableSpec("true_goal", _PER_SEGMENT, "str", "label of the goal it led to; empty = unknown"),
        VariableSpec("replan_row_size", _PER_TRIAL, "int64", "number of replans of the trial, >= 0"),
        VariableSpec("replan_time", _PER_REPLAN, "float64", "time of the sample it was made at", units="s"),
        VariableSpec("replan_sample", _PER_REPLAN, "int64", "that sample, counted within the trial"),
        VariableSpec(
            "replan_agent", _PER_REPLAN, "str", "label of the agent that replanned: whose view it is"
        ),
        VariableSpec("replan_seed", _PER_REPLAN, "int64", "seed of its plans"),
        VariableSpec("plan_row_size", _PER_REPLAN_AGENT, "int64", "number of plans; 0 = the agent has left"),
        VariableSpec("static_plan", _PER_REPLAN_AGENT, "int64", "the plan that does not move; -1 = none"),
        VariableSpec(
            "committed_plan", _PER_REPLAN_AGENT, "int64", "the rest of the plan under execution; -1 = none"
        ),
        VariableSpec("waypoint_row_size", (("plan",),), "int64", "number of waypoints of the plan, >= 1"),
        VariableSpec("waypoint_time", (("waypoint",),), "float64", "since the replan; 0 at first", units="s"),
        VariableSpec("waypoint_position", (("waypoint", "space"),), "float64", "where the plan is then"),
        VariableSpec(
            "cost",
            (("profile", "agent"),),
            "float64",
            "of each profile; inf = collision, NaN = the agent has left",
            units="s",
        ),
        VariableSpec(
            "contact_time", (("profile",),), "float64", "until agents first touch; inf = never", units="s"
        ),
        VariableSpec(
            "decision", _PER_REPLAN_AGENT, "int64", "plan of each agent in the chosen profile; -1 = none"
        ),
        VariableSpec("theta", (("theta",),), "str", "whom an agent's equilibria favour: labels"),
        VariableSpec(
            "live_log_posterior",
            (("replan", "theta"),),
            "float64",
            "log p(theta) held then; NaN = none was held",
        ),
        VariableSpec(
            "live_model", _PER_TRIAL, "str", "JSON of the model that held it; empty = none", as_variable=True
        ),
        VariableSpec(
            "held", (("sample",),), "int8", "1 = a safety stop held the step to it", as_variable=True
        ),
        VariableSpec(
            "end_effector",
            (("sample", "agent", "table"),),
            "float64",
            "where the hand is; NaN = not there",
            units="m",
            as_variable=True,
        ),
        VariableSpec("table", (("table",),), "str", "labels of its coordinates: x, y"),
        VariableSpec(
            "finish_time",
            _PER_TRIAL_AGENT,
            "float64",
            "when the agent was done; NaN = never",
            False,
            "s",
            True,
        ),
        VariableSpec("stops", _PER_TRIAL, "int64", "number of safety stops", as_variable=True),
        VariableSpec(
            "stop_episodes", _PER_TRIAL, "int64", "number of runs of safety stops", as_variable=True
        ),
        VariableSpec("scene", _PER_TRIAL, "int64", "number of the scene", as_variable=True),
        VariableSpec(
            "plan_sets", _PER_TRIAL, "str", "shared or independent: who sampled the plans", as_variable=True
        ),
    )
}

REPLAN_VARIABLES = (
    "replan_row_size", "replan_time", "replan_sample", "replan_agent", "replan_seed", "plan_row_size", "static_plan",
    "committed_plan", "waypoint_row_size", "waypoint_time", "waypoint_position", "cost", "contact_time", "decision",
)  # fmt: skip

GROUPS: tuple[tuple[str, ...], ...] = (
    ("goal", "goal_position", "goal_present"),
    ("segment_trial", "segment_agent", "segment_start", "segment_stop", "true_goal"),
    ("velocity", "has_velocity"),
    ("control", "has_control"),
    REPLAN_VARIABLES,
    ("theta", "live_log_posterior"),
)
"""Variables that come together or not at all."""

COORDINATES = ("agent", "space", "goal", "theta", "table")
"""Variables that label their own dimension."""

RAGGED = ("sample", "replan", "plan", "waypoint", "profile")
"""Dimensions along which trials lie end to end."""

PLAN_SETS = ("shared", "independent", "")


def schema_table() -> str:
    """Return the table of variables as Markdown; ``docs/log-format.md`` holds exactly this.

    Examples
    --------
    >>> print(schema_table().splitlines()[0])
    | variable | dimensions | type | required | meaning |
    """
    rows = ["| variable | dimensions | type | required | meaning |", "| --- | --- | --- | --- | --- |"]
    for spec in VARIABLES.values():
        dims = " or ".join(f"({', '.join(dims)})" for dims in spec.dims)
        meaning = f"{spec.meaning} ({spec.units})" if spec.units else spec.meaning
        rows.append(
            f"| `{spec.name}` | {dims} | {spec.kind} | {'yes' if spec.required else ''} | {meaning} |"
        )
    return "\n".join(rows)
