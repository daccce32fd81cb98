"""One trial in memory, and many of them laid end to end as a study log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Float, Shaped

from ppinfer.errors import LogError
from ppinfer.studies.assembling import build_log
from ppinfer.studies.replans import Replan, ReplanTable


@dataclass(frozen=True)
class Segment:
    """A stretch of one agent's motion towards one goal: samples [start, stop) of its trial.

    ``true_goal`` is the goal's label, empty where it is not known.
    """

    agent: str
    start: int
    stop: int
    true_goal: str = ""


@dataclass(frozen=True, eq=False)
class Trial:
    """One trial as it was recorded.

    Parameters
    ----------
    trial_id, participant, condition, round, seed, outcome
        As in the log; ``round`` and ``seed`` may be unknown.
    time
        Seconds, strictly increasing.
    position
        Where each agent is; NaN where it was not seen.
    observed
        1 = seen, 0 = dropout; by default an agent is unseen where its whole position is NaN.
    velocity, control
        As logged; NaN for an agent whose velocity or control was not.
    goal_position, goal_present
        Per trial, (goal, space) and (goal), or per sample.
    controller, instruction
        By agent.
    segments
        Stretches with known (or unknown) goals.
    variables
        Further variables: name to (dimensions without ``trial``, values) or (dimensions, values, attributes);
        those without ``sample`` are one value of the trial. Here go also ``held`` (sample), ``end_effector``
        (sample, agent, table), ``finish_time`` (agent), and ``stops``, ``stop_episodes``, ``scene``, ``plan_sets``
        and ``live_model`` without dimensions.
    replans
        In a world where agents plan: every replan, in order.
    """

    trial_id: str
    participant: str
    time: Float[np.ndarray, " sample"]
    position: Float[np.ndarray, "sample agent space"]
    observed: Shaped[np.ndarray, "sample agent"] | None = None
    velocity: Float[np.ndarray, "sample agent space"] | None = None
    control: Float[np.ndarray, "sample agent space"] | None = None
    goal_position: Float[np.ndarray, "... goal space"] | None = None
    goal_present: Shaped[np.ndarray, "... goal"] | None = None
    condition: str = ""
    round: int | None = None
    seed: int | None = None
    outcome: str = ""
    controller: Mapping[str, str] = field(default_factory=dict)
    instruction: Mapping[str, str] = field(default_factory=dict)
    segments: Sequence[Segment] = ()
    variables: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    replans: Sequence[Replan] | ReplanTable = ()

    def replan_table(self, *, agents: Sequence[str], theta: Sequence[str] = ()) -> ReplanTable:
        """Return the trial's replans as flat arrays; agents and labels of theta are those of the log.

        Raises
        ------
        LogError
            If a replan does not fit the log.
        """
        if isinstance(self.replans, ReplanTable):
            return self.replans
        try:
            return ReplanTable.of(self.replans, agents=agents, space=np.shape(self.position)[-1], theta=theta)
        except LogError as error:
            raise LogError(f"trial {self.trial_id!r}: {error}") from error


def log_of_trials(
    trials: Sequence[Trial],
    *,
    agents: Sequence[str],
    goals: Sequence[str] = (),
    space: Sequence[str] = ("x", "y"),
    theta: Sequence[str] = (),
    has_velocity: Sequence[bool] | None = None,
    has_control: Sequence[bool] | None = None,
    **described: Any,
) -> xr.Dataset:
    """Lay trials end to end as a study log.

    Parameters
    ----------
    trials
        At least one; all with the same optional arrays and variables.
    agents, goals, space, theta, has_velocity, has_control
        As in `build_log`; ``theta`` is needed where replans hold a live posterior.
    **described
        ``title``, ``source``, ``configuration``, ``control_quantity``, ``position_units`` and ``attrs`` of
        `build_log`.

    Returns
    -------
    xarray.Dataset
        The log. Goals are per sample as soon as one trial's are.

    Raises
    ------
    LogError
        If there is no trial, or one lacks what the others have.

    Examples
    --------
    >>> one = Trial("a", "p1", time=np.array([0.0, 0.1]), position=np.zeros((2, 1, 2)))
    >>> log_of_trials([one], agents=["human"]).row_size.values.tolist()
    [2]
    """
    if not trials:
        raise LogError("a log has at least one trial; there is none")
    sizes = [len(trial.time) for trial in trials]
    segments = [(index, segment) for index, trial in enumerate(trials) for segment in trial.segments]
    observed = None
    if any(trial.observed is not None for trial in trials):
        observed = np.concatenate(
            [~np.isnan(one.position).all(axis=-1) if one.observed is None else one.observed for one in trials]
        )
    goal_position, goal_present = _goals(trials, sizes)
    tables = [trial.replan_table(agents=agents, theta=theta) for trial in trials]
    replan_row_size = [table.sizes["replan"] for table in tables]
    planned = any(replan_row_size)
    return build_log(
        agents=agents,
        goals=goals,
        space=space,
        row_size=sizes,
        replan_row_size=replan_row_size if planned else None,
        replans=ReplanTable.end_to_end(tables) if planned else None,
        theta=theta,
        trial_id=[trial.trial_id for trial in trials],
        participant=[trial.participant for trial in trials],
        time=np.concatenate([trial.time for trial in trials]),
        position=_end_to_end("position", [trial.position for trial in trials], trials),
        observed=observed,
        velocity=_end_to_end("velocity", [trial.velocity for trial in trials], trials),
        control=_end_to_end("control", [trial.control for trial in trials], trials),
        has_velocity=has_velocity,
        has_control=has_control,
        goal_position=goal_position,
        goal_present=goal_present,
        condition=_unless_unknown([trial.condition for trial in trials], ""),
        round=_unless_unknown([trial.round for trial in trials], None),
        seed=_unless_unknown([trial.seed for trial in trials], None),
        outcome=_unless_unknown([trial.outcome for trial in trials], ""),
        controller=_unless_unknown(
            [[one.controller.get(agent, "") for agent in agents] for one in trials], ""
        ),
        instruction=_unless_unknown(
            [[one.instruction.get(agent, "") for agent in agents] for one in trials], ""
        ),
        segment_trial=[index for index, _ in segments],
        segment_agent=[segment.agent for _, segment in segments],
        segment_start=[segment.start for _, segment in segments],
        segment_stop=[segment.stop for _, segment in segments],
        true_goal=[segment.true_goal for _, segment in segments],
        variables=_study_variables(trials),
        **described,
    )


def _end_to_end(name: str, arrays: Sequence[Any], trials: Sequence[Trial]) -> Any:
    lacking = [trial.trial_id for trial, array in zip(trials, arrays, strict=True) if array is None]
    if len(lacking) == len(trials):
        return None
    if lacking:
        raise LogError(
            f"trial {lacking[0]!r} has no {name}, but other trials have; give NaN where it is not known"
        )
    try:
        return np.concatenate(arrays)
    except ValueError as error:
        shapes = sorted({np.shape(array)[1:] for array in arrays})
        raise LogError(f"{name}: trials have different shapes per sample: {shapes}") from error


def _goals(trials: Sequence[Trial], sizes: Sequence[int]) -> tuple[Any, Any]:
    placed = [trial.goal_position for trial in trials]
    if all(one is None for one in placed):
        return None, None
    lacking = [trial.trial_id for trial in trials if trial.goal_position is None]
    if lacking:
        raise LogError(f"trial {lacking[0]!r} has no goal_position, but other trials have")
    positions = [np.asarray(one, np.float64) for one in placed]
    present = [
        ~np.isnan(place).any(axis=-1) if one.goal_present is None else np.asarray(one.goal_present)
        for one, place in zip(trials, positions, strict=True)
    ]
    moving = any(one.ndim == 3 for one in positions) or any(one.ndim == 2 for one in present)
    if not moving:
        return np.stack(positions), np.stack(present)
    spread = [
        (np.broadcast_to(place, (size, *place.shape[-2:])), np.broadcast_to(here, (size, here.shape[-1])))
        for place, here, size in zip(positions, present, sizes, strict=True)
    ]
    return np.concatenate([place for place, _ in spread]), np.concatenate([here for _, here in spread])


def _unless_unknown(values: list[Any], unknown: Any) -> list[Any] | None:
    if all(value == unknown or (isinstance(value, list) and not any(value)) for value in values):
        return None
    # a number that only some trials have: -1 says that the others' is not known
    return [-1 if value is None else value for value in values]


def _study_variables(trials: Sequence[Trial]) -> dict[str, tuple[Any, ...]]:
    gathered: dict[str, tuple[Any, ...]] = {}
    for name, (dims, _, *described) in trials[0].variables.items():
        lacking = [trial.trial_id for trial in trials if name not in trial.variables]
        if lacking:
            raise LogError(f"trial {lacking[0]!r} has no variable {name!r}, but other trials have")
        arrays = [np.asarray(trial.variables[name][1]) for trial in trials]
        if tuple(dims)[:1] == ("sample",):
            gathered[name] = (dims, _end_to_end(name, arrays, trials), *described)
        else:
            gathered[name] = (("trial", *dims), np.stack(arrays), *described)
    return gathered
