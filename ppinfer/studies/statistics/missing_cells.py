"""Cells without a value: named and refused, or subjects or levels left out where the caller chooses so."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import get_args

import numpy as np

from ppinfer.errors import LogError
from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.statistics.measures import Missing, RepeatedMeasures, check_choice, listed


def missing_cells(measures: RepeatedMeasures) -> list[Fault]:
    """Return a fault for every cell without a value.

    Examples
    --------
    >>> scores = RepeatedMeasures("y", np.array([[1.0, np.nan]]), ("ann",), ("robot",), (("old", "new"),))
    >>> [str(fault) for fault in missing_cells(scores)]
    ["column 'y': subject 'ann' at robot 'new' has no value"]
    """
    return [
        Fault(
            "missing-cell",
            f"{measures.cell_name(tuple(map(int, where)))} has no value",
            file=measures.source or None,
            column=measures.dv,
        )
        for where in np.argwhere(np.isnan(measures.values))
    ]


def refuse_missing(several: Sequence[RepeatedMeasures]) -> None:
    """Refuse variables that have missing cells, naming all of them at once.

    Raises
    ------
    LogError
        If no subject has values at more than one level of a factor: it is a factor between subjects.
    FaultyLogError
        If cells are missing.

    Examples
    --------
    >>> refuse_missing([RepeatedMeasures("y", np.ones((1, 2)), ("ann",), ("robot",), (("old", "new"),))])
    """
    for measures in several:
        _refuse_between(measures)
    gaps = [fault for measures in several for fault in missing_cells(measures)]
    if gaps:
        Faults(gaps).raise_if_any(several[0].source or "the measures")


def completed(measures: RepeatedMeasures, missing: Missing) -> RepeatedMeasures:
    """Return a design without missing cells and with enough of everything (see `RepeatedMeasures.complete`).

    Examples
    --------
    >>> scores = RepeatedMeasures("y", np.ones((2, 2)), ("ann", "bob"), ("robot",), (("old", "new"),))
    >>> completed(scores, "refuse") is scores
    True
    """
    check_choice("missing", missing, get_args(Missing))
    if missing == "refuse":
        refuse_missing([measures])
    if not np.isnan(measures.values).any():
        return _large_enough(measures, "")
    _refuse_between(measures)
    return _without_subjects(measures) if missing == "drop-subjects" else _without_levels(measures)


def _without_subjects(measures: RepeatedMeasures) -> RepeatedMeasures:
    gaps = np.isnan(measures.values)
    kept = ~gaps.reshape(len(gaps), -1).any(axis=1)
    dropped = list(itertools.compress(measures.subjects, ~kept))
    note = f"{measures.dv!r}: {len(dropped)} of {len(kept)} subjects dropped for missing cells: {listed(dropped)}"
    left = replace(
        measures,
        values=measures.values[kept],
        subjects=tuple(itertools.compress(measures.subjects, kept)),
        notes=(*measures.notes, note),
    )
    return _large_enough(left, note)


def _without_levels(measures: RepeatedMeasures) -> RepeatedMeasures:
    if len(measures.factors) > 1:
        raise LogError(
            f"{_where(measures)}: with several within factors there is more than one way to drop levels; "
            "drop subjects, or leave levels out of the table"
        )
    kept = ~np.isnan(measures.values).any(axis=0)
    names = measures.levels[0]
    dropped = list(itertools.compress(names, ~kept))
    note = (
        f"{measures.dv!r}: {len(dropped)} of {len(names)} levels of {measures.factors[0]!r} dropped for missing "
        f"cells: {listed(dropped)}"
    )
    left = replace(
        measures,
        values=measures.values[:, kept],
        levels=(tuple(itertools.compress(names, kept)),),
        notes=(*measures.notes, note),
    )
    return _large_enough(left, note)


def _refuse_between(measures: RepeatedMeasures) -> None:
    there = ~np.isnan(measures.values)
    for number, factor in enumerate(measures.factors):
        others = tuple(axis for axis in range(1, there.ndim) if axis != number + 1)
        at_level = there.any(axis=others)
        if len(there) > 1 and at_level.shape[1] > 1 and at_level.any() and (at_level.sum(axis=1) <= 1).all():
            wide = there.reshape(len(there), -1).sum(axis=1).max() == 1
            or_wide = (
                "; every subject has one row, so if each level has a column of its own, make the table long, with a "
                "row for each subject and level (docs/statistics.md, Wide tables)"
            )
            raise LogError(
                f"{_where(measures)}: no subject has values at more than one level of {factor!r}, so it is a factor "
                "between subjects (or the subject column names something else); this analysis is within "
                f"subjects{or_wide if wide else ''}"
            )


def _large_enough(measures: RepeatedMeasures, note: str) -> RepeatedMeasures:
    why = f" ({note})" if note else ""
    if len(measures.subjects) < 2:
        raise LogError(
            f"{_where(measures)}: the number of subjects is {len(measures.subjects)}, expected at least 2{why}; "
            "what is within subjects is judged by how they differ"
        )
    for factor, levels in zip(measures.factors, measures.levels, strict=True):
        if len(levels) < 2:
            named = f" ({listed(levels)})" if levels else ""
            raise LogError(
                f"{_where(measures)}: factor {factor!r} has too few levels: {len(levels)}{named}, "
                f"expected at least 2{why}"
            )
    return measures


def _where(measures: RepeatedMeasures) -> str:
    return f"{measures.source}: {measures.dv!r}" if measures.source else repr(measures.dv)
