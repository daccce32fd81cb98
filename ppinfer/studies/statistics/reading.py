"""Reading repeated measures from a long table: one row a measurement, CSV or Parquet."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ppinfer.errors import LogError
from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.statistics.measures import Repeated, RepeatedMeasures

if TYPE_CHECKING:
    from ppinfer.studies.readers.mapping import FileOptions
    from ppinfer.studies.readers.tables import Table

_WIDE = "every subject has one row: is this a wide table, with a column for each level?"
_MAKE_LONG = "make it long, with a row for each subject and level (docs/statistics.md, Wide tables)"


def read_measures(
    path: str | Path,
    dvs: Sequence[str],
    *,
    within: Sequence[str],
    subject: str,
    repeated: Repeated = "refuse",
    options: FileOptions | None = None,
) -> list[RepeatedMeasures]:
    r"""Read dependent variables, each a column of numbers, of a table with a row for each subject and cell.

    Subjects and levels are text, whatever they look like (``007`` and ``7`` are two subjects), and keep the order in
    which they first appear.

    Parameters
    ----------
    path
        The table: ``.parquet`` or ``.pq``, or else CSV.
    dvs
        The columns of the dependent variables.
    within
        The columns of the within-subject factors.
    subject
        The column that names the subject (participant).
    repeated
        What to do with several rows of one subject and cell: refuse, or take the mean.
    options
        How a CSV file is written (delimiter, decimal mark, what an empty cell looks like).

    Raises
    ------
    FaultyLogError
        If the file cannot be read, columns are missing, cells are not finite numbers, subjects or levels are
        empty, or rows repeat a cell; all of one kind at once, with their lines.
    LogError
        If a column is asked for in two roles.

    Examples
    --------
    >>> _ = Path("scores.csv").write_text("who,robot,score\n1,naive,3\n1,new,4\n2,naive,2\n2,new,4\n")
    >>> scores, = read_measures("scores.csv", ["score"], within=["robot"], subject="who")
    >>> scores.values
    array([[3., 4.],
           [2., 4.]])
    """
    from ppinfer.studies.readers.mapping import FileOptions
    from ppinfer.studies.readers.tables import read_table

    path = Path(path)
    _check_roles(dvs, within, subject)
    options = options or FileOptions.model_validate({})
    faults = Faults()
    table = read_table(path, [(name, "") for name in (subject, *within, *dvs)], options, faults)
    if table is None:
        if faults.counts["missing-column"]:
            _tell_wide(path, subject, options, faults)
        raise_with_hint(path, options, faults)
        raise AssertionError("a table that was not read has a fault")
    subjects = _names(table, subject, faults)
    factors = {factor: _names(table, factor, faults) for factor in within}
    columns = {dv: table.numbers(dv, faults) for dv in dvs}
    faults.raise_if_any(path.name)
    # lines take another look at the file, so they are only asked for where a message will name them
    several = len(set(zip(subjects, *factors.values(), strict=True))) < len(subjects)
    lines = table.lines.tolist() if several else None
    return [
        RepeatedMeasures.from_columns(
            dv, values, subjects, factors, repeated=repeated, source=path.name, lines=lines
        )
        for dv, values in columns.items()
    ]


def raise_with_hint(path: Path, options: FileOptions, faults: Faults) -> None:
    """Raise the faults of a table, with a hint where it seems to be written with another delimiter.

    Raises
    ------
    FaultyLogError
        If there are faults.

    Examples
    --------
    >>> from ppinfer.studies.readers.mapping import FileOptions
    >>> raise_with_hint(Path("scores.csv"), FileOptions.model_validate({}), Faults())
    """
    if faults.counts["missing-column"] and path.suffix.lower() not in (".parquet", ".pq"):
        with path.open(encoding="utf-8-sig", errors="replace") as file:
            header = file.readline(100_000)
        found = max(",;\t|", key=header.count)
        if header.count(found) and options.delimiter not in header:
            shown = {"\t": "tabs"}.get(found, repr(found))
            told = f"cells seem to be separated by {shown}, not by {options.delimiter!r}"
            # that its columns are missing only follows from this
            faults = Faults([Fault("delimiter", told, "say how the file is written", file=path.name)])
    faults.raise_if_any(path.name or str(path))


def _check_roles(dvs: Sequence[str], within: Sequence[str], subject: str) -> None:
    if not dvs or not within:
        raise LogError("name at least one dependent variable and at least one within factor")
    columns = [*dvs, *within, subject]
    twice = [name for name in dict.fromkeys(columns) if columns.count(name) > 1]
    if twice:
        raise LogError(
            f"column {twice[0]!r} is asked for {columns.count(twice[0])} times; each column is one dependent "
            "variable, one within factor, or the subject"
        )


def _tell_wide(path: Path, subject: str, options: FileOptions, faults: Faults) -> None:
    """Add to columns that are not there that the table seems to have a row a subject."""
    from ppinfer.studies.readers.tables import read_table

    table = read_table(path, [(subject, "")], options, Faults())
    if table is not None and table.n_rows > 1:
        codes = table.text(subject).codes
        if (codes >= 0).all() and len(np.unique(codes)) == len(codes):
            faults.add(Fault("wide-table", _WIDE, _MAKE_LONG, file=path.name))


def _names(table: Table, column: str, faults: Faults) -> list[str]:
    found = table.text(column)

    def describe(row: int) -> Fault:
        cell = str(table.columns[column][row].as_py() or "").strip()
        if not cell:
            return table.fault("no-label", "is empty; expected a name", row, column)
        told = f"{cell!r} stands for no value, and a name is expected"
        return table.fault("no-label", told, row, column, "call it something else")

    faults.add_each("no-label", np.flatnonzero(found.codes < 0).tolist(), describe)
    return [found.labels[code] if code >= 0 else "" for code in found.codes]
