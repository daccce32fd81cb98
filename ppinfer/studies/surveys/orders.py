"""The order in which each participant met the conditions: from a table, from a survey's positions, or from a log."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from ppinfer.errors import LogError
from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.readers.mapping import closest
from ppinfer.studies.readers.tables import Table
from ppinfer.studies.statistics.reading import raise_with_hint
from ppinfer.studies.surveys.instrument import Instrument
from ppinfer.studies.surveys.reading import labelled, read_named_table
from ppinfer.studies.surveys.survey import Survey

ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")


def read_orders(
    path: str | os.PathLike[str], instrument: Instrument, conditions: Sequence[str]
) -> dict[str, tuple[str, ...]]:
    r"""Read a table of orders: one row a participant, one column a position, conditions in the cells.

    The columns are those that the instrument names under ``[orders]``, else its subject column and ``first``,
    ``second``, ``third`` ..., as many as there are conditions. An empty cell is a condition that was not met.

    Parameters
    ----------
    path : path
        A CSV or Parquet table.
    instrument : Instrument
        Names the columns.
    conditions : sequence of str
        All conditions; anything else in a cell is a fault.

    Returns
    -------
    dict of str to tuple of str
        The conditions of each participant, in order, as `check_orders` takes them.

    Raises
    ------
    FaultyLogError
        With every fault and its line: columns that are not there, unknown conditions, rows without participant,
        participants or conditions that come twice.

    Examples
    --------
    >>> _ = Path("orders.csv").write_text("user,first,second\nann,a,b\nbob,b,a\n")
    >>> instrument = Instrument.parse('''
    ...     columns = {subject = "user", condition = "robot"}
    ...     anchors = {1 = "no", 5 = "yes"}
    ...     items.easy = {}
    ... ''')
    >>> read_orders("orders.csv", instrument, ["a", "b"])
    {'ann': ('a', 'b'), 'bob': ('b', 'a')}
    """
    where = Path(path)
    faults = Faults()
    named = instrument.orders
    subject = (named and named.subject) or instrument.columns.subject
    positions = list(named.positions) if named else list(ORDINALS[: len(conditions)])
    if not named and len(positions) < len(conditions):
        raise LogError(
            f"{where}: name the columns of {len(conditions)} positions under [orders] in the instrument"
        )
    entry = "orders.positions" if named else "[orders], by default"
    wanted = [(subject, "columns.subject"), *((name, entry) for name in positions)]
    table = read_named_table(where, wanted, instrument.file, faults)
    orders: dict[str, tuple[str, ...]] = {}
    if table is not None:
        orders = _orders(table, subject, positions, conditions, faults)
    raise_with_hint(where, instrument.file, faults)
    return orders


def orders_of_survey(survey: Survey, by: Sequence[str] | None = None) -> dict[str, tuple[str, ...]]:
    r"""Return the order of each participant of a survey whose instrument has a column of positions.

    Raises
    ------
    LogError
        If the instrument has no such column, or two conditions of a participant have one position.

    Examples
    --------
    >>> from ppinfer.studies.surveys.reading import read_survey
    >>> _ = Path("answers.csv").write_text("user,robot,place,easy\nann,a,2,5\nann,b,1,2\n")
    >>> instrument = Instrument.parse('''
    ...     columns = {subject = "user", condition = "robot", position = "place"}
    ...     anchors = {1 = "no", 5 = "yes"}
    ...     items.easy = {}
    ... ''')
    >>> orders_of_survey(read_survey("answers.csv", instrument))
    {'P01': ('b', 'a')}
    """
    if survey.instrument.columns.position is None:
        raise LogError("the instrument names no column of positions; name it under [columns] position")
    labels = survey.labels(by)
    met: dict[str, dict[int, set[str]]] = {who: {} for who in survey.participants}
    for row, (who, position) in enumerate(
        zip(survey.participant.tolist(), survey.position.tolist(), strict=True)
    ):
        if position:
            met[survey.participants[who]].setdefault(position, set()).add(labels[row])
    faults = Faults()
    for who, found in met.items():
        for position, names in found.items():
            if len(names) > 1:
                conditions = ", ".join(map(repr, sorted(names)))
                told = f"participant {who!r} has several conditions at position {position}: {conditions}"
                faults.add(Fault("position", told, column=survey.instrument.columns.position))
    faults.raise_if_any(survey.source)
    return {
        who: tuple(dict.fromkeys(name for position in sorted(found) for name in found[position]))
        for who, found in met.items()
    }


def orders_of_log(
    log: xr.Dataset, *, by: str = "condition", order: str | None = None
) -> dict[str, tuple[str, ...]]:
    """Return the order in which each participant of a study log first met each condition.

    Parameters
    ----------
    log : xarray.Dataset
        A study log.
    by : str
        The variable of a trial that is the condition.
    order : str, optional
        A variable of a trial that sorts a participant's trials; by default they were played as they stand in the log,
        which a log that was converted from files need not keep.

    Raises
    ------
    LogError
        If the log has no such variable of a trial.

    Examples
    --------
    >>> log = xr.Dataset(
    ...     {"participant": ("trial", ["p", "p", "q", "q"]), "condition": ("trial", ["a", "b", "b", "a"])}
    ... )
    >>> orders_of_log(log)
    {'p': ('a', 'b'), 'q': ('b', 'a')}
    """
    per_trial = [str(name) for name in log.variables if log[name].dims == ("trial",)]
    for name in (by, *([] if order is None else [order])):
        if name not in per_trial:
            raise LogError(f"the log has no variable {name!r} of a trial; {closest(name, per_trial)}")
    participant = [str(who) for who in log["participant"].values]
    condition = [str(name) for name in log[by].values]
    trials = np.arange(len(participant)) if order is None else np.argsort(log[order].values, kind="stable")
    met: dict[str, dict[str, None]] = {who: {} for who in participant}
    for trial in trials.tolist():
        if condition[trial]:
            met[participant[trial]].setdefault(condition[trial])
    return {who: tuple(names) for who, names in met.items()}


def _orders(
    table: Table, subject: str, positions: list[str], conditions: Sequence[str], faults: Faults
) -> dict[str, tuple[str, ...]]:
    who = labelled(table, subject, "participant", faults)
    met: list[list[str]] = [[] for _ in range(table.n_rows)]
    for column in positions:
        labels = table.text(column)
        for row, code in enumerate(labels.codes.tolist()):
            if code < 0:
                continue
            name = labels.labels[code]
            if name not in conditions:
                told = f"no condition {name[:40]!r}"
                faults.add(table.fault("unknown-condition", told, row, column, closest(name, conditions)))
            elif name in met[row]:
                faults.add(table.fault("order", f"condition {name!r} twice in one order", row, column))
            met[row].append(name)
    first: dict[int, int] = {}
    for row, code in enumerate(who.codes.tolist()):
        if code >= 0 and first.setdefault(code, row) != row:
            told = f"this participant has an order in line {int(table.lines[first[code]])} already"
            faults.add(table.fault("repeated-order", told, row, subject, "keep one"))
    return {who.labels[code]: tuple(met[row]) for code, row in first.items()}
