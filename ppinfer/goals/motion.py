"""States and controls from what was logged, derived causally: never from a later sample."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.errors import LogError, ModelError
from ppinfer.goals.dynamics import Dynamics
from ppinfer.goals.evidence import GoalEvidence

LOGGED = "logged"
DIFFERENCES = "backward differences of positions"


@dataclass(frozen=True, eq=False)
class Motion:
    """The state acted from and the control taken, as known at each sample.

    Where the control is logged, sample t tells of (x_t, u_t). Where it is not, the step that ended at sample t tells
    of (x_s, u_s), s being the last sample seen before t in the same row: the evidence of a step arrives when the step
    is over.

    Parameters
    ----------
    state : (sample, n) float64
        Zero where not informative.
    control : (sample, m) float64
        Zero where not informative.
    informative : (sample,) bool
        False at dropouts and before a row has shown enough samples.
    velocity_source, control_source : str
        How each came about, for the result's attributes.
    """

    state: Float[np.ndarray, "sample n"]
    control: Float[np.ndarray, "sample m"]
    informative: Bool[np.ndarray, " sample"]
    velocity_source: str
    control_source: str


def causal_motion(evidence: GoalEvidence, dynamics: Dynamics) -> Motion:
    """Return states and controls of `dynamics` at every sample, from logged values or backward differences.

    Parameters
    ----------
    evidence : GoalEvidence
        Positions, and velocities and controls where they were logged.
    dynamics : Dynamics
        Decides which of them the state holds.

    Raises
    ------
    ModelError
        Where the dynamics have another number of space dimensions or controls than the log.
    LogError
        Where a logged velocity or control is not finite at a sample that was observed.

    Examples
    --------
    >>> evidence = GoalEvidence(
    ...     time=np.arange(3) * 0.5, position=np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]]),
    ...     goals=np.zeros((1, 1, 2)), row_size=np.array([3]), goal_labels=("cup",),
    ... )
    >>> motion = causal_motion(evidence, Dynamics.single_integrator(0.5))
    >>> motion.control[:, 0], motion.informative
    (array([0., 2., 4.]), array([False,  True,  True]))
    """
    space = evidence.position.shape[1]
    if len(dynamics.position_index) != space:
        raise ModelError(
            f"the dynamics move in {len(dynamics.position_index)} dimensions, the log in {space}"
        )
    _require_complete_state(dynamics)
    whole = _logged_motion(evidence, dynamics) or _difference_motion(evidence, dynamics)
    if whole is not None:
        return whole
    kept = np.flatnonzero(evidence.seen)
    row = evidence.row_of_sample[kept]
    # how many samples of its row were seen before this one
    rank = np.arange(len(kept)) - np.searchsorted(row, row, side="left")
    # the first sample of a row has no step behind it; 1 s stands in, and nothing is read off it
    elapsed = np.where(rank > 0, np.diff(evidence.time[kept], prepend=np.nan), 1.0)
    position = evidence.position[kept]

    state = np.zeros((len(kept), dynamics.states))
    state[:, list(dynamics.position_index)] = position
    velocity_source, needed = "not needed", 0
    if dynamics.velocity_index:
        if evidence.velocity is not None:
            velocity, velocity_source = _finite(evidence, "velocity", kept), LOGGED
        else:
            velocity, velocity_source, needed = (
                _backward_difference(position, elapsed, rank > 0),
                DIFFERENCES,
                1,
            )
        state[:, list(dynamics.velocity_index)] = velocity

    if evidence.control is not None and evidence.control_order == dynamics.order:
        control, informative = _finite(evidence, "control", kept), rank >= needed
        acted_from, control_source = state, LOGGED
    else:
        informative = rank >= needed + 1
        acted_from = np.roll(state, 1, axis=0)
        control = dynamics.control_between(acted_from, state, elapsed)
        informative &= dynamics.usable_step(elapsed)
        control_source = "differences of logged velocities" if velocity_source == LOGGED else DIFFERENCES
    return Motion(
        state=_scatter(acted_from, kept, informative, evidence.samples),
        control=_scatter(control, kept, informative, evidence.samples),
        informative=_scatter(informative[:, None], kept, informative, evidence.samples)[:, 0],
        velocity_source=velocity_source,
        control_source=control_source,
    )


def _logged_motion(evidence: GoalEvidence, dynamics: Dynamics) -> Motion | None:
    """Return the motion without a copy of any sample, where states and controls were logged throughout."""
    if evidence.control is None or evidence.control_order != dynamics.order:
        return None
    if evidence.control.shape[1] != dynamics.controls:
        raise ModelError(
            f"the log's control has {evidence.control.shape[1]} entries, the dynamics take {dynamics.controls}"
        )
    needs_velocity = bool(dynamics.velocity_index)
    if (needs_velocity and evidence.velocity is None) or not evidence.seen.all():
        return None
    state = evidence.position
    if needs_velocity or dynamics.position_index != tuple(range(dynamics.states)):
        state = np.empty((evidence.samples, dynamics.states))
        # column by column: many times as fast as an indexed copy of all
        for column, entry in enumerate(dynamics.position_index):
            state[:, entry] = evidence.position[:, column]
        if needs_velocity:
            velocity = _finite(evidence, "velocity")
            for column, entry in enumerate(dynamics.velocity_index):
                state[:, entry] = velocity[:, column]
    return Motion(
        state=state,
        control=_finite(evidence, "control"),
        informative=np.ones(evidence.samples, dtype=bool),
        velocity_source=LOGGED if needs_velocity else "not needed",
        control_source=LOGGED,
    )


def _difference_motion(evidence: GoalEvidence, dynamics: Dynamics) -> Motion | None:
    """Return the motion of an integrator whose control was not logged, in one pass."""
    second = bool(dynamics.velocity_index)
    if dynamics.order != (2 if second else 1) or dynamics.controls != evidence.position.shape[1]:
        return None
    if evidence.control is not None and evidence.control_order == dynamics.order:
        return None
    from ppinfer.goals.scans import difference_motion

    logged = second and evidence.velocity is not None
    velocity = evidence.position
    if logged:
        kept = None if evidence.seen.all() else np.flatnonzero(evidence.seen)
        _finite(evidence, "velocity", kept)
        assert evidence.velocity is not None
        velocity = evidence.velocity
    state = np.zeros((evidence.samples, dynamics.states))
    control = np.empty((evidence.samples, dynamics.controls))
    informative = np.empty(evidence.samples, dtype=bool)
    difference_motion(
        evidence.time,
        evidence.position,
        velocity,
        logged,
        evidence.seen,
        evidence.row_size,
        np.array(dynamics.position_index),
        np.array(dynamics.velocity_index, dtype=np.int64),
        state,
        control,
        informative,
    )
    return Motion(
        state=state,
        control=control,
        informative=informative,
        velocity_source=LOGGED if logged else DIFFERENCES if second else "not needed",
        control_source="differences of logged velocities" if logged else DIFFERENCES,
    )


def previous_seen(evidence: GoalEvidence) -> Int[np.ndarray, " sample"]:
    """Return, for each sample, the last sample of its row seen before it; -1 where there is none.

    Examples
    --------
    >>> evidence = GoalEvidence(
    ...     time=np.arange(3.0), position=np.array([[0.0], [np.nan], [3.0]]), goals=np.zeros((1, 1, 1)),
    ...     row_size=np.array([3]), goal_labels=("cup",), observed=np.array([True, False, True]),
    ... )
    >>> previous_seen(evidence)
    array([-1,  0,  0])
    """
    index = np.where(evidence.seen, np.arange(evidence.samples), -1)
    last = np.concatenate([[-1], np.maximum.accumulate(index)[:-1]])
    return np.where(last >= evidence.row_start[evidence.row_of_sample], last, -1)


def _finite(
    evidence: GoalEvidence, name: str, kept: Int[np.ndarray, " kept"] | None = None
) -> Float[np.ndarray, "some m"]:
    """Return logged values at some samples (by default all), which must be finite."""
    values: np.ndarray = getattr(evidence, name)
    if kept is not None:
        values = values[kept]
    # a finite sum means finite terms, at a quarter of the cost of looking at each
    if not np.isfinite(values.sum()):
        wrong = ~np.isfinite(values).all(axis=1)
        if wrong.any():
            first = int(np.argmax(wrong))
            where = evidence.describe_sample(first if kept is None else int(kept[first]))
            raise LogError(f"{where}: {name} is logged but not finite there")
    return values


def _backward_difference(
    values: Float[np.ndarray, "kept space"],
    elapsed: Float[np.ndarray, " kept"],
    known: Bool[np.ndarray, " kept"],
) -> Float[np.ndarray, "kept space"]:
    difference = np.zeros_like(values)
    difference[1:] = np.diff(values, axis=0) / elapsed[1:, None]
    difference[~known] = 0.0
    return difference


def _require_complete_state(dynamics: Dynamics) -> None:
    known = len(dynamics.position_index) + len(dynamics.velocity_index)
    if dynamics.states != known:
        raise ModelError(
            f"the state has {dynamics.states} entries but only {known} are positions or velocities; a log tells no more"
        )


def _scatter(
    values: np.ndarray, kept: Int[np.ndarray, " kept"], informative: Bool[np.ndarray, " kept"], samples: int
) -> np.ndarray:
    if len(kept) == samples and informative.all():
        return values
    everywhere = np.zeros((samples, values.shape[1]), dtype=values.dtype)
    everywhere[kept[informative]] = values[informative]
    return everywhere
