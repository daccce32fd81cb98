"""From a study log to the evidence of the goal models: one agent's motion, in rows of constant goals."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float, Int, Shaped

from ppinfer.distributions.ragged import row_starts
from ppinfer.errors import LogError
from ppinfer.goals import GoalEvidence
from ppinfer.goals.partners import PartnerMotion

Restart = Literal["goals", "segments"]
CONTROL_ORDER = {"velocity": 1, "acceleration": 2, "other": None}


def goal_evidence(
    log: xr.Dataset,
    agent: str,
    *,
    restart: Restart = "goals",
    carry: bool = False,
    time_step: float | None = None,
    partner: str | None = None,
) -> GoalEvidence:
    """Return the evidence about one agent's goals that a log holds.

    Parameters
    ----------
    log : xarray.Dataset
        A study log, or a block of one.
    agent : str
        Whose goals.
    restart : {"goals", "segments"}
        Where the belief starts anew within a trial: wherever the goals change (the default), or there and at the
        bounds of the agent's segments (of use only where these are known as they happen, as picks are).
    carry : bool
        Begin such a row with the last belief, goal by goal, in place of the prior.
    time_step : float, optional
        Nominal seconds between samples; default: the median of this log.
    partner : str, optional
        The other agent whose motion comes along; default: all other agents of the log.

    Returns
    -------
    GoalEvidence
        Rows in the order of the samples; errors name trials by their ``trial_id``.

    Raises
    ------
    LogError
        Where the agent or the partner is unknown or the log holds no goals.

    Examples
    --------
    >>> from ppinfer.studies import build_log
    >>> log = build_log(
    ...     agents=["human"], goals=["cup", "pan"], row_size=[2], time=[0.0, 0.1], position=np.zeros((2, 1, 2)),
    ...     goal_position=np.array([[1.0, 0.0], [0.0, 1.0]]), trial_id=["a"],
    ... )
    >>> evidence = goal_evidence(log, "human")
    >>> evidence.row_name(0), evidence.goal_labels
    ("trial 'a'", ('cup', 'pan'))
    """
    index = agent_index(log, agent)
    if "goal_position" not in log:
        raise LogError(
            "the log holds no goals (goal_position), so there is nothing to infer; add them when converting"
        )
    row_size = log["row_size"].values
    trial_start = row_starts(row_size)
    samples = int(row_size.sum())
    goals, present = _goals_and_presence(log)
    begins = np.zeros(samples, dtype=bool)
    moving = "sample" in log["goal_position"].dims
    if moving:
        begins[1:] = (goals[1:] != goals[:-1]).any(axis=(1, 2)) | (present[1:] != present[:-1]).any(axis=1)
    if restart == "segments":
        for bound in ("segment_start", "segment_stop"):
            at = _segment_bounds(log, agent, bound, trial_start)
            begins[at[at < samples]] = True
    begins[trial_start] = True
    start = np.flatnonzero(begins)
    trial_of_row = np.searchsorted(trial_start, start, side="right") - 1
    which = start if moving else trial_of_row
    continues = ~np.isin(start, trial_start) if carry else None
    names = log["trial_id"].values
    return GoalEvidence(
        time=log["time"].values.astype(np.float64, copy=False),
        position=np.ascontiguousarray(log["position"].values[:, index]),
        goals=goals[which],
        present=None if present.all() else present[which],
        row_size=np.diff(np.append(start, samples)),
        goal_labels=tuple(str(label) for label in log["goal"].values),
        observed=_observed(log, index),
        velocity=_logged(log, "velocity", index),
        control=_logged(log, "control", index),
        control_order=_control_order(log),
        continues=continues,
        name_row=_row_namer(names, trial_of_row, start - trial_start[trial_of_row]),
        time_step=time_step,
        partners=tuple(_partner(log, name) for name in partner_names(log, agent, partner)),
        agent=agent,
    )


def partner_names(log: xr.Dataset, agent: str, partner: str | None = None) -> list[str]:
    """Return the agents beside `agent` whose motion counts: the one asked for, or all.

    Raises
    ------
    LogError
        Where the partner is not in the log, or is the agent itself.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> partner_names(example_log(participants=1, trials=1), "human")
    []
    """
    if partner is None:
        return [name for name in log["agent"].values.astype(str).tolist() if name != agent]
    agent_index(log, partner)
    if partner == agent:
        raise LogError(f"agent {agent!r} cannot be its own partner; name another agent of the log")
    return [partner]


def agent_index(log: xr.Dataset, agent: str) -> int:
    """Return the place of an agent in the log.

    Raises
    ------
    LogError
        Where there is no such agent; the message lists those there are.
    """
    agents = [str(label) for label in log["agent"].values]
    if agent not in agents:
        raise LogError(f"the log has no agent {agent!r}; it has {', '.join(repr(label) for label in agents)}")
    return agents.index(agent)


def _goals_and_presence(
    log: xr.Dataset,
) -> tuple[Float[np.ndarray, "where goal space"], Bool[np.ndarray, "where goal"]]:
    goals = log["goal_position"].values
    if "goal_present" in log:
        present = log["goal_present"].values == 1
        return np.where(present[..., None], goals, 0.0), present
    return goals, np.ones(goals.shape[:2], dtype=bool)


def _segment_bounds(
    log: xr.Dataset, agent: str, bound: str, trial_start: Int[np.ndarray, " trial"]
) -> Int[np.ndarray, " bound"]:
    if "segment_trial" not in log or log.sizes.get("segment", 0) == 0:
        return np.zeros(0, dtype=np.int64)
    mine = log["segment_agent"].values.astype(str) == agent
    at: np.ndarray = trial_start[log["segment_trial"].values[mine]] + log[bound].values[mine]
    return at


def _partner(log: xr.Dataset, name: str) -> PartnerMotion:
    index = agent_index(log, name)
    return PartnerMotion(
        name,
        np.ascontiguousarray(log["position"].values[:, index]),
        _observed(log, index),
        _logged(log, "velocity", index),
        _logged(log, "control", index),
        _control_order(log),
    )


def _control_order(log: xr.Dataset) -> int | None:
    return CONTROL_ORDER[log["control"].attrs["quantity"]] if "control" in log else None


def _observed(log: xr.Dataset, index: int) -> Bool[np.ndarray, " sample"] | None:
    if "observed" not in log:
        return None
    seen = log["observed"].values[:, index] == 1
    return None if seen.all() else seen


def _logged(log: xr.Dataset, name: str, index: int) -> Float[np.ndarray, "sample space"] | None:
    flag = f"has_{name}"
    if name not in log or (flag in log and log[flag].values[index] != 1):
        return None
    return np.ascontiguousarray(log[name].values[:, index])


def _row_namer(
    trial_ids: Shaped[np.ndarray, " trial"], trial: Int[np.ndarray, " row"], offset: Int[np.ndarray, " row"]
) -> Callable[[int], str]:
    def name(row: int) -> str:
        within = f" from its sample {offset[row]}" if offset[row] else ""
        return f"trial {str(trial_ids[trial[row]])!r}{within}"

    return name
