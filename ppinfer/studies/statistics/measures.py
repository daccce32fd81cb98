"""Repeated measures: one number for every subject and every cell of a within-subject design."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float, Int

from ppinfer.errors import LogError
from ppinfer.studies.faults import Fault, Faults

Repeated = Literal["refuse", "mean"]
Missing = Literal["refuse", "drop-subjects", "drop-levels"]
_NAMED = 8


@dataclass(frozen=True, eq=False)
class RepeatedMeasures:
    """A dependent variable measured on every subject in every cell of a within-subject design.

    Parameters
    ----------
    dv
        The name of the dependent variable.
    values
        Shape (subject, level of factor 1, level of factor 2, ...), in the variable's own units; NaN = missing.
    subjects
        A name for each subject (participant).
    factors
        The names of the within-subject factors, one an axis of ``values`` after the first.
    levels
        The names of each factor's levels.
    source
        Where the numbers come from (a file's name); errors begin with it.
    notes
        What was done to the rows on the way here: averaged, dropped.

    Raises
    ------
    LogError
        If shapes and names do not fit each other, a name occurs twice, or a value is infinite.

    Examples
    --------
    >>> scores = RepeatedMeasures(
    ...     "score", np.array([[3.0, 4.0], [2.0, 4.0]]), ("ann", "bob"), ("robot",), (("naive", "reactive"),)
    ... )
    >>> scores.complete().values.mean(axis=0)
    array([2.5, 4. ])
    """

    dv: str
    values: Float[np.ndarray, "subject *level"]
    subjects: tuple[str, ...]
    factors: tuple[str, ...]
    levels: tuple[tuple[str, ...], ...]
    source: str = ""
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        expected = (len(self.subjects), *map(len, self.levels))
        if self.values.shape != expected or len(self.factors) != len(self.levels) or not self.factors:
            raise LogError(
                f"{self.dv!r} has values of shape {self.values.shape}, but there are {len(self.subjects)} subjects "
                f"and levels of {len(self.levels)} factors (expected shape {expected}, a name for each factor)"
            )
        for kind, names in (("subject", self.subjects), ("factor", self.factors)):
            _refuse_twice(kind, names)
        for factor, names in zip(self.factors, self.levels, strict=True):
            _refuse_twice(f"level of {factor!r}", names)
        if np.isinf(self.values).any():
            where = tuple(int(index[0]) for index in np.nonzero(np.isinf(self.values)))
            raise LogError(f"{self.dv!r}: {self.cell_name(where)} is infinite; expected a finite number")

    @classmethod
    def from_columns(
        cls,
        dv: str,
        values: Float[np.ndarray, " row"],
        subjects: Sequence[str],
        factors: Mapping[str, Sequence[str]],
        *,
        repeated: Repeated = "refuse",
        source: str = "",
        lines: Sequence[int] | None = None,
    ) -> RepeatedMeasures:
        """Arrange a long table, one row a measurement, as subjects by cells.

        Parameters
        ----------
        dv
            The name of the dependent variable.
        values
            A number a row; NaN = no value.
        subjects
            The subject of each row.
        factors
            For each within-subject factor the level of each row. Subjects and levels keep the order in which they
            first appear.
        repeated
            What to do with several rows of one subject and cell: ``"refuse"`` names them all, ``"mean"`` averages
            the values that there are (and says so in ``notes``).
        source, lines
            The file, and the line of each row, for messages; without them rows are counted from 1.

        Raises
        ------
        FaultyLogError
            If a subject has several rows in a cell and ``repeated`` is ``"refuse"``.
        LogError
            If a value is infinite.

        Examples
        --------
        >>> RepeatedMeasures.from_columns(
        ...     "score", np.array([3.0, 4.0, 2.0]), ["ann", "ann", "bob"], {"robot": ["naive", "new", "naive"]}
        ... ).values
        array([[ 3.,  4.],
               [ 2., nan]])
        """
        check_choice("repeated", repeated, get_args(Repeated))
        names, rows_of_subject = _codes(subjects)
        coded = [_codes(column) for column in factors.values()]
        levels = tuple(labels for labels, _ in coded)
        shape = (len(names), *map(len, levels))
        cells = np.ravel_multi_index([rows_of_subject, *(codes for _, codes in coded)], shape)
        counts = np.bincount(cells, minlength=int(np.prod(shape)))
        notes: tuple[str, ...] = ()
        if (counts > 1).any():
            blank = np.full(shape, np.nan)
            empty = cls(dv, blank, names, tuple(factors), levels, source)
            if repeated == "refuse":
                empty._refuse_repeated(cells, np.flatnonzero(counts > 1), lines)
            several = int((counts > 1).sum())
            notes = (f"{dv!r}: mean of several rows taken in {several} cells (up to {counts.max()} rows)",)
        there = np.isfinite(values)
        number = np.bincount(cells[there], minlength=len(counts))
        total = np.bincount(cells[there], weights=values[there], minlength=len(counts))
        arranged = np.divide(total, number, out=np.full(len(counts), np.nan), where=number > 0)
        # an infinite value is no missing one: it is refused below
        arranged[cells[np.isinf(values)]] = np.inf
        return cls(dv, arranged.reshape(shape), names, tuple(factors), levels, source, notes)

    def complete(self, missing: Missing = "refuse") -> RepeatedMeasures:
        """Return a design without missing cells and with enough of everything, or say what it lacks.

        Parameters
        ----------
        missing
            ``"refuse"`` names every missing cell; ``"drop-subjects"`` leaves out each subject that has one;
            ``"drop-levels"`` (one factor only) leaves out each level that has one. What was dropped is in ``notes``.

        Raises
        ------
        FaultyLogError
            If cells are missing and ``missing`` is ``"refuse"``.
        LogError
            If fewer than 2 subjects, or fewer than 2 levels of a factor, are there or left; or if a factor is one
            between subjects.

        Examples
        --------
        >>> scores = RepeatedMeasures(
        ...     "score",
        ...     np.array([[3.0, 4.0], [2.0, np.nan], [1.0, 2.0]]),
        ...     ("ann", "bob", "cy"),
        ...     ("robot",),
        ...     (("naive", "new"),),
        ... )
        >>> scores.complete("drop-subjects").notes
        ("'score': 1 of 3 subjects dropped for missing cells: 'bob'",)
        """
        from ppinfer.studies.statistics.missing_cells import completed

        return completed(self, missing)

    def _refuse_repeated(
        self, cells: Int[np.ndarray, " row"], repeated: Int[np.ndarray, " cell"], lines: Sequence[int] | None
    ) -> None:
        counted = "row" if lines is None or self.source.endswith((".parquet", ".pq")) else "line"
        numbers = np.arange(1, len(cells) + 1) if lines is None else np.asarray(lines)
        faults = Faults()

        def describe(cell: int) -> Fault:
            where = tuple(map(int, np.unravel_index(cell, self.values.shape)))
            found = ", ".join(map(str, numbers[cells == cell][:_NAMED]))
            more = "" if (cells == cell).sum() <= _NAMED else ", ..."
            return Fault(
                "repeated-cell",
                f"{self.cell_name(where)} is there more than once ({counted}s {found}{more})",
                "remove what is wrong, or have the mean taken",
                file=self.source or None,
            )

        faults.add_each("repeated-cell", repeated.tolist(), describe)
        faults.raise_if_any(self.source or repr(self.dv))

    def cell_name(self, where: tuple[int, ...]) -> str:
        """Say which cell an index into ``values`` is: whose, and at which levels.

        Examples
        --------
        >>> RepeatedMeasures("y", np.zeros((1, 1)), ("ann",), ("robot",), (("new",),)).cell_name((0, 0))
        "subject 'ann' at robot 'new'"
        """
        at = ", ".join(
            f"{factor} {levels[index]!r}"
            for factor, levels, index in zip(self.factors, self.levels, where[1:], strict=True)
        )
        return f"subject {self.subjects[where[0]]!r} at {at}"


def check_choice(name: str, value: str, choices: Sequence[str]) -> None:
    """Refuse a choice that there is not, which would else be taken for another.

    Raises
    ------
    LogError
        Naming the choices that there are.

    Examples
    --------
    >>> check_choice("missing", "refuse", ["refuse", "drop-subjects"])
    """
    if value not in choices:
        raise LogError(f"{name} is {value!r}; expected one of {listed(choices)}")


def _codes(labels: Sequence[str]) -> tuple[tuple[str, ...], Int[np.ndarray, " row"]]:
    index = {label: code for code, label in enumerate(dict.fromkeys(labels))}
    return tuple(index), np.array([index[label] for label in labels], np.int64)


def listed(names: Sequence[str]) -> str:
    """Return names between quotation marks, the first twenty of them.

    Examples
    --------
    >>> listed(["ann", "bob"])
    "'ann', 'bob'"
    """
    shown = ", ".join(map(repr, names[:20]))
    return shown if len(names) <= 20 else f"{shown} and {len(names) - 20} more"


def _refuse_twice(kind: str, names: Sequence[str]) -> None:
    for name, count in Counter(names).most_common(1):
        if count > 1:
            raise LogError(f"{kind} {name!r} is named {count} times; names are unique")
