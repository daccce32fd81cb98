"""Where the goals of a tidy table are: constant, in a table of their own, or in columns of each row."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from jaxtyping import Float

from ppinfer.studies.faults import Faults
from ppinfer.studies.readers.mapping import GoalsFile, Mapping
from ppinfer.studies.readers.tables import Table, read_table
from ppinfer.studies.readers.tidy_samples import Samples, scaled


def read_goals(
    table: Table, mapping: Mapping, samples: Samples, folder: Path, faults: Faults
) -> tuple[list[str] | None, Float[np.ndarray, "... goal space"] | None]:
    """Return the goals' labels and positions in SI units, (goal, space), (trial, goal, space) or per sample.

    The labels are None where the goals could not be read.
    """
    if mapping.goals:
        placed = np.array(list(mapping.goals.values()), np.float64)
        return list(mapping.goals), scaled(placed, "position", mapping.units.position)
    if mapping.goal_columns:
        labels, placed = _from_columns(table, mapping, samples, faults)
        return labels, per_trial_if_still(placed, samples)
    if mapping.goals_file is not None:
        return _from_file(mapping.goals_file, mapping, samples, folder, faults)
    return [], None


def per_trial_if_still(
    placed: Float[np.ndarray, "sample goal space"], samples: Samples
) -> Float[np.ndarray, "... goal space"]:
    """Return goals that never move within a trial as one position a trial."""
    first = placed[samples.offsets]
    spread = first[samples.sample_trial]
    return first if np.array_equal(spread, placed, equal_nan=True) else placed


def _from_columns(
    table: Table, mapping: Mapping, samples: Samples, faults: Faults
) -> tuple[list[str], Float[np.ndarray, "sample goal space"]]:
    space = mapping.space()
    placed = np.full((samples.time.size, len(mapping.goal_columns), len(space)), np.nan)
    for index, told in enumerate(mapping.goal_columns.values()):
        cells = np.stack([table.numbers(getattr(told, name), faults) for name in space], axis=1)
        missing = np.isnan(cells)
        half = np.flatnonzero(missing.any(axis=1) & ~missing.all(axis=1))
        table.report(faults, "missing-value", half, told.x, "a goal has all of its coordinates or none")
        placed[samples.row_sample, index] = scaled(cells, "position", mapping.units.position)
    return list(mapping.goal_columns), placed


def _from_file(
    told: GoalsFile, mapping: Mapping, samples: Samples, folder: Path, faults: Faults
) -> tuple[list[str] | None, Float[np.ndarray, "... goal space"] | None]:
    space = mapping.space()
    names = ["goal", *space, *(name for name in ("trial", "from_time") if getattr(told, name) is not None)]
    wanted = [(getattr(told, name), f"goals_file.{name}") for name in names]
    goals = read_table(folder / told.path, wanted, mapping.file, faults)
    if goals is None:
        return None, None
    before = faults.total
    which = goals.text(told.goal)
    goals.report(faults, "missing-value", np.flatnonzero(which.codes < 0), told.goal, "there is no value")
    places = np.stack([goals.numbers(getattr(told, name), faults) for name in space], axis=1)
    places = scaled(places, "position", mapping.units.position)
    start = np.full(goals.n_rows, -np.inf)
    if told.from_time is not None:
        start = scaled(goals.numbers(told.from_time, faults), "time", mapping.units.time)
        goals.report(
            faults, "missing-value", np.flatnonzero(np.isnan(start)), told.from_time, "there is no time"
        )
    n_trials = len(samples.trial_ids)
    trial = np.zeros(goals.n_rows, np.int64)
    if told.trial is not None:
        ids = goals.text(told.trial)
        known = {name: index for index, name in enumerate(samples.trial_ids)}
        index_of = np.array([known.get(name, -1) for name in ids.labels] + [-1])
        trial = index_of[ids.codes]
        goals.report(
            faults, "unknown-trial", np.flatnonzero(trial < 0), told.trial, "the table has no such trial"
        )
    order = np.lexsort((start, trial, which.codes))
    same = (
        (np.diff(which.codes[order]) == 0)
        & (np.diff(trial[order]) == 0)
        & (start[order][1:] == start[order][:-1])
    )
    goals.report(
        faults,
        "duplicate-row",
        np.sort(order[1:][same]),
        told.goal,
        "is given twice",
        "remove one of the two rows",
    )
    if faults.total > before:
        return which.labels, None
    if told.from_time is None:
        placed = np.full((n_trials, len(which.labels), len(space)), np.nan)
        rows = slice(None) if told.trial is None else trial
        if told.trial is None:
            placed[:, which.codes] = places
        else:
            placed[rows, which.codes] = places
        return which.labels, placed
    return which.labels, per_trial_if_still(
        _over_time(which.codes, trial, start, places, samples, told), samples
    )


def _over_time(
    goal: np.ndarray,
    trial: np.ndarray,
    start: np.ndarray,
    places: Float[np.ndarray, "row space"],
    samples: Samples,
    told: GoalsFile,
) -> Float[np.ndarray, "sample goal space"]:
    placed = np.full((samples.time.size, int(goal.max()) + 1, places.shape[1]), np.nan)
    sample_trial = samples.sample_trial if told.trial is not None else np.zeros_like(samples.sample_trial)
    # complex numbers sort by trial, then by time: the last row at or before each sample, in one search
    at = sample_trial + 1j * samples.time
    for index in range(placed.shape[1]):
        rows = np.flatnonzero(goal == index)
        rows = rows[np.lexsort((start[rows], trial[rows]))]
        latest = np.searchsorted(trial[rows] + 1j * start[rows], at, side="right") - 1
        found = (latest >= 0) & (trial[rows][latest] == sample_trial)
        placed[found, index] = places[rows[latest[found]]]
    return placed
