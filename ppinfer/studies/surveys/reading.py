"""Reading the answers to a survey from a table; every wrong cell is told with its line, and nobody is named."""

from __future__ import annotations

import difflib
import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.readers.mapping import FileOptions, closest
from ppinfer.studies.readers.tables import Labels, Table, read_table
from ppinfer.studies.statistics.reading import raise_with_hint
from ppinfer.studies.surveys.instrument import Instrument
from ppinfer.studies.surveys.instrument_checks import folded
from ppinfer.studies.surveys.survey import Survey

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)
_SHOWN = 40


def read_survey(
    path: str | os.PathLike[str], instrument: Instrument, *, keep_ids: bool = False, seed: int = 0
) -> Survey:
    r"""Read the answers to a survey.

    Only the columns that the instrument names are read. Participants get pseudonyms, unless ``keep_ids``.

    Parameters
    ----------
    path : path
        A CSV or Parquet table with one row a response.
    instrument : Instrument
        Which column is what.
    keep_ids : bool
        Keep the participants' names as they are in the table.
    seed : int
        Of the pseudonyms (`ppinfer.studies.surveys.pseudonyms.pseudonyms`).

    Returns
    -------
    Survey
        With NaN where there is no answer.

    Raises
    ------
    FaultyLogError
        With every fault: columns that are not there, answers off the scale or that are no answers, responses without
        participant or condition, two responses of one participant under one condition.

    Examples
    --------
    >>> _ = Path("answers.csv").write_text("user,robot,easy\nann,a,5\nann,b,Strongly Disagree\nbob,a,4\nbob,b,2\n")
    >>> instrument = Instrument.parse('''
    ...     columns = {subject = "user", condition = "robot"}
    ...     anchors = {1 = "Strongly Disagree", 5 = "Strongly Agree"}
    ...     items.easy.text = "The robot was easy to work with."
    ... ''')
    >>> survey = read_survey("answers.csv", instrument)
    >>> survey.values.ravel().tolist(), survey.participants
    ([4.0, 2.0, 5.0, 1.0], ('P01', 'P02'))
    """
    where = Path(path)
    faults = Faults()
    survey = _read(where, instrument, faults)
    raise_with_hint(where, instrument.file, faults)
    assert survey is not None
    return survey if keep_ids else survey.pseudonymised(seed)


def read_named_table(
    path: Path, wanted: list[tuple[str, str]], options: FileOptions, faults: Faults
) -> Table | None:
    """Read the columns that an instrument names; what is missing is told in terms of the instrument."""
    found = Faults(limit=len(wanted) + 1)
    table = read_table(path, wanted, options, found)
    entries = dict(wanted)
    for fault in found.listed:
        if fault.kind == "missing-column":
            told = f"there is no such column (the instrument's {entries[fault.column or '']!r})"
            fault = replace(fault, message=told)
        faults.add(fault)
    if found.listed and table is not None:
        return None
    return table


def _read(path: Path, instrument: Instrument, faults: Faults) -> Survey | None:
    columns = instrument.columns
    wanted = [(columns.subject, "columns.subject")]
    wanted += [(name, "columns.condition") for name in instrument.factors]
    wanted += [] if columns.position is None else [(columns.position, "columns.position")]
    wanted += [(instrument.column(name), f"items.{name}") for name in instrument.items]
    table = read_named_table(path, wanted, instrument.file, faults)
    if table is None:
        return None
    subject = labelled(table, columns.subject, "participant", faults)
    factors = [labelled(table, name, "condition", faults) for name in instrument.factors]
    for name, labels in zip(instrument.factors, factors, strict=True):
        if name in instrument.conditions:
            _only_known(table, name, labels, list(instrument.conditions[name]), faults)
    values = np.column_stack([_answers(table, instrument, name, faults) for name in instrument.items])
    position = np.zeros(table.n_rows, np.int64)
    if columns.position is not None:
        position = positions(table, columns.position, faults)
    _no_repetition(table, instrument, subject, factors, faults)
    if faults:
        return None
    return Survey(
        instrument,
        values,
        subject.codes,
        tuple(subject.labels),
        tuple(zip(*([labels.labels[code] for code in labels.codes] for labels in factors), strict=True))
        or ((),) * table.n_rows,
        position,
        np.asarray(table.lines, np.int64),
        path.name,
    )


def labelled(table: Table, column: str, meaning: str, faults: Faults) -> Labels:
    """Return a column of labels; a row without one is a fault."""
    labels = table.text(column)

    def describe(row: int) -> Fault:
        cell = str(table.columns[column][row].as_py() or "").strip()
        if not cell:
            return table.fault(f"no-{meaning}", f"no {meaning}", row, column, "fill it in")
        told = f"no {meaning}: {cell!r} stands for no value"
        remedy = "call it something else, or say under [file] missing which texts stand for no value"
        return table.fault(f"no-{meaning}", told, row, column, remedy)

    faults.add_each(f"no-{meaning}", np.flatnonzero(labels.codes < 0).tolist(), describe)
    return labels


def positions(table: Table, column: str, faults: Faults) -> Int[np.ndarray, " row"]:
    """Return a column of positions in an order, from 1; 0 where there is none."""
    numbers = table.numbers(column, faults)
    bad = np.flatnonzero(
        ~np.isnan(numbers) & ((numbers < 1) | (numbers != np.floor(numbers)) | (numbers > 1e6))
    )
    # what is no number has been told, and is 0
    bad = bad[numbers[bad] != 0] if faults.counts.get("not-a-number") else bad
    table.report(faults, "position", bad, column, "a position is a whole number from 1")
    return np.where(np.isnan(numbers), 0, np.clip(np.nan_to_num(numbers), 0, 1e6)).astype(np.int64)


def answer(cell: str, points: range, texts: dict[int, str], decimal: str = ".") -> float | None:
    """Return the number that a cell means, or None if it is none of those that can be answered.

    Examples
    --------
    >>> anchors = {1: "Strongly Disagree", 5: "Strongly Agree"}
    >>> [answer(cell, range(1, 6), anchors) for cell in ("4", "4.0", "strongly agree", "2.5", "6")]
    [4.0, 4.0, 5.0, None, None]
    """
    meant = folded(cell)
    for number, text in texts.items():
        if meant == folded(text):
            return float(number)
    plain = cell.strip().replace(",", ".") if decimal == "," else cell.strip()
    if not _NUMBER.fullmatch(plain):
        return None
    value = float(plain)
    return value if value.is_integer() and int(value) in points else None


def _answers(table: Table, instrument: Instrument, item: str, faults: Faults) -> Float[np.ndarray, " row"]:
    column, points, texts = instrument.column(item), instrument.points(item), instrument.texts(item)
    labels = table.text(column)
    meant = [answer(label, points, texts, instrument.file.decimal) for label in labels.labels]
    numbers = np.array([np.nan if number is None else number for number in meant] + [np.nan])
    wrong = np.array([number is None for number in meant] + [False])[labels.codes]
    named = ", ".join(repr(text) for text in texts.values() if text.strip())
    expected = f"a whole number from {points[0]} to {points[-1]}" + (f" or one of {named}" if named else "")
    faults.add_each(
        "answer",
        np.flatnonzero(wrong).tolist(),
        lambda row: table.fault(
            "answer",
            f"expected {expected}, got {_shown(labels.labels[labels.codes[row]], texts)}",
            row,
            column,
        ),
    )
    return np.asarray(numbers[labels.codes], np.float64)


def _shown(cell: str, texts: dict[int, str]) -> str:
    """Return a wrong cell as a message shows it: another text than a misspelt anchor may be somebody's name."""
    if re.fullmatch(r"[\d\s.,:;+\-/%]+", cell):
        return repr(_short(cell))
    near = difflib.get_close_matches(
        folded(cell), [folded(text) for text in texts.values() if text], n=1, cutoff=0.8
    )
    return repr(_short(cell)) if near else f"another text (of {len(cell)} letters)"


def _short(text: str) -> str:
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}…"


def _only_known(table: Table, column: str, labels: Labels, known: list[str], faults: Faults) -> None:
    for code, label in enumerate(labels.labels):
        if label not in known:
            table.report(
                faults,
                "unknown-condition",
                np.flatnonzero(labels.codes == code),
                column,
                f"the instrument names no condition {_short(label)!r}",
                closest(label, known),
            )


def _no_repetition(
    table: Table, instrument: Instrument, subject: Labels, factors: list[Labels], faults: Faults
) -> None:
    keys = np.column_stack([subject.codes, *(labels.codes for labels in factors)])
    known = np.flatnonzero((keys >= 0).all(axis=1))
    _, first, same = np.unique(keys[known], axis=0, return_index=True, return_inverse=True)
    same = same.reshape(-1)
    again = np.flatnonzero(first[same] != np.arange(len(known)))
    under = " under this condition" if factors else ""
    before = dict(zip(known[again].tolist(), known[first[same[again]]].tolist(), strict=True))
    faults.add_each(
        "repeated-response",
        known[again].tolist(),
        lambda row: Fault(
            "repeated-response",
            f"this participant has answered{under} in line {int(table.lines[before[row]])} already",
            "keep one; or name the column that tells the responses apart under [columns] condition",
            file=table.path.name,
            line=int(table.lines[row]),
            column=instrument.columns.subject,
        ),
    )
