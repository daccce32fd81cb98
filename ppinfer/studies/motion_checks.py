"""Do the numbers of a block of samples make sense? Time, positions, velocities, goals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from ppinfer.studies.faults import Fault, Faults

JUMP_FACTOR = 20.0
"""A step is implausible when it is this many times faster than the agent's median step that moves."""


@dataclass(frozen=True)
class Rows:
    """Which trial and sample each row of a block is.

    Parameters
    ----------
    offsets
        Where each trial of the whole log begins, and where the last ends.
    names
        The trials' ids.
    start
        The block's first row in the whole log.
    first_of_trial
        Whether each row of the block begins a trial.
    """

    offsets: Int[np.ndarray, " edge"]
    names: list[str]
    start: int
    first_of_trial: Bool[np.ndarray, " sample"]

    def place(self, row: int) -> tuple[str, int]:
        """Return the trial's id and the sample within it of a row of the block."""
        at = self.start + row
        trial = int(np.searchsorted(self.offsets, at, side="right")) - 1
        return self.names[trial], at - int(self.offsets[trial])

    def report(
        self, faults: Faults, kind: str, column: str, rows: np.ndarray, say: object, remedy: str
    ) -> None:
        """Count a fault at each row; ``say`` is a text, or a function from the row to one."""

        def describe(row: int) -> Fault:
            trial, sample = self.place(row)
            message = say(row) if callable(say) else str(say)
            return Fault(kind, message, remedy, trial=trial, sample=sample, column=column)

        faults.add_each(kind, rows.tolist(), describe)


def check_time(time: Float[np.ndarray, " sample"], rows: Rows, faults: Faults) -> None:
    """Report times that are not finite or do not increase within their trial."""
    finite = np.isfinite(time)
    rows.report(
        faults,
        "not-finite",
        "time",
        np.flatnonzero(~finite),
        lambda row: f"is {time[row]}",
        "every sample has a time in seconds",
    )
    step = np.diff(time, prepend=-np.inf)
    late = ~rows.first_of_trial & (step <= 0)
    late[1:] &= finite[1:] & finite[:-1]
    rows.report(
        faults,
        "time-not-increasing",
        "time",
        np.flatnonzero(late),
        lambda row: f"is {time[row]} after {time[row - 1]}",
        "times increase strictly within a trial: sort the samples or remove the repeated ones",
    )


def check_marks(column: str, marks: Shaped[np.ndarray, "sample ..."], rows: Rows, faults: Faults) -> None:
    """Report marks, of observation for example, that are neither 0 nor 1."""
    wrong = ((marks != 0) & (marks != 1)).any(axis=tuple(range(1, marks.ndim)))
    rows.report(
        faults,
        "wrong-value",
        column,
        np.flatnonzero(wrong),
        lambda row: f"is {marks[row].tolist()}",
        "0 or 1",
    )


def check_positions(
    position: Float[np.ndarray, "sample agent space"],
    observed: Shaped[np.ndarray, "sample agent"],
    agents: list[str],
    rows: Rows,
    faults: Faults,
) -> None:
    """Report positions that are not finite where observed, or not NaN where not observed."""
    for index, agent in enumerate(agents):
        seen = observed[:, index] == 1
        bad = seen & ~np.isfinite(position[:, index].sum(axis=-1))
        rows.report(
            faults,
            "not-finite",
            "position",
            np.flatnonzero(bad),
            lambda row, index=index, agent=agent: (
                f"of {agent!r} is {position[row, index].tolist()} where observed is 1"
            ),
            "mark it as a dropout (observed 0, position NaN) or correct it",
        )
        told = ~seen & ~np.isnan(position[:, index]).all(axis=-1)
        rows.report(
            faults,
            "dropout-with-position",
            "position",
            np.flatnonzero(told),
            lambda row, index=index, agent=agent: (
                f"of {agent!r} is {position[row, index].tolist()} where observed is 0"
            ),
            "a dropout has no position: write NaN, or set observed to 1",
        )


def check_logged(
    name: str,
    values: Float[np.ndarray, "sample agent space"],
    has: Shaped[np.ndarray, " agent"],
    observed: Shaped[np.ndarray, "sample agent"],
    agents: list[str],
    rows: Rows,
    faults: Faults,
) -> None:
    """Report velocities or controls that are missing where they were logged, or given where they were not."""
    for index, agent in enumerate(agents):
        total = values[:, index].sum(axis=-1)
        if has[index] == 1:
            bad = np.isinf(total) | (np.isnan(total) & (observed[:, index] == 1))
            say, remedy = f"of {agent!r} is not finite", f"correct it, or set has_{name} of {agent!r} to 0"
        else:
            bad = ~np.isnan(values[:, index]).all(axis=-1)
            say, remedy = f"of {agent!r} is given, but has_{name} is 0", f"write NaN, or set has_{name} to 1"
        rows.report(
            faults, "not-finite" if has[index] == 1 else "not-logged", name, np.flatnonzero(bad), say, remedy
        )


def goal_faults(
    placed: Float[np.ndarray, "row goal space"], present: Shaped[np.ndarray, "row goal"]
) -> list[tuple[str, str, Bool[np.ndarray, " row"], str, str]]:
    """Return the kinds of fault of goals: (kind, column, rows, message, remedy)."""
    here = present == 1
    finite = np.isfinite(placed).all(axis=-1)
    return [
        ("wrong-value", "goal_present", ((present != 0) & ~here).any(axis=1), "is neither 0 nor 1", ""),
        (
            "not-finite",
            "goal_position",
            (here & ~finite).any(axis=1),
            "is not finite where goal_present is 1",
            "correct it, or mark the goal as absent",
        ),
        (
            "absent-with-position",
            "goal_position",
            (~here & ~np.isnan(placed).all(axis=-1)).any(axis=1),
            "is given where goal_present is 0",
            "write NaN, or mark the goal as present",
        ),
        (
            "goals-missing",
            "goal_present",
            ~here.any(axis=1),
            "no goal is present",
            "at least one goal is there at every sample",
        ),
    ]


def step_speeds(
    time: Float[np.ndarray, " sample"],
    position: Float[np.ndarray, "sample agent space"],
    first_of_trial: Bool[np.ndarray, " sample"],
) -> Float[np.ndarray, "sample agent"]:
    """Return how fast each agent moved since the sample before (float32; NaN where it was not seen)."""
    speeds = np.full(position.shape[:2], np.nan, np.float32)
    if time.size > 1:
        with np.errstate(all="ignore"):
            distance = np.sqrt((np.diff(position, axis=0) ** 2).sum(axis=-1))
            speeds[1:] = distance / np.diff(time)[:, None]
    speeds[first_of_trial] = np.nan
    return speeds


def jump_threshold(speeds: Float[np.ndarray, " sample"]) -> float:
    """Return the speed above which a step is implausible (inf where nothing moved).

    The median holds while fewer than half the steps are wrong; a displaced sample makes two wrong steps.
    """
    moving = speeds[np.isfinite(speeds) & (speeds > 0)]
    return JUMP_FACTOR * float(np.median(moving)) if moving.size else np.inf
