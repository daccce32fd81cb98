"""What the cells of a column say: numbers, whole numbers, times, flags or text."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Shaped

from ppinfer.studies.faults import Faults
from ppinfer.studies.readers.tables import Table
from ppinfer.studies.readers.tidy_samples import scaled
from ppinfer.studies.readers.variable_names import CellKind

_NUMBER = r"^[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?$"
_WHOLE = r"^(0|-?[1-9][0-9]{0,14})$"
# as numbers these would lose zeros, or digits
_IDENTIFIER = r"^[+-]?(0[0-9]+|[0-9]{16,})$"
_FLAGS = {"1": 1, "1.0": 1, "true": 1, "0": 0, "0.0": 0, "false": 0}
# float64 holds every whole number up to here
_LARGEST = 2**53


def kind_of_cells(table: Table, columns: Sequence[str], faults: Faults) -> CellKind | None:
    """Return what the cells of some columns say, None where some are numbers and some text: that is a fault.

    1. ``flag`` where all are true or false;
    2. ``integer`` where all are whole numbers and none is missing, ``number`` where all are numbers;
    3. else ``text``: also what has leading zeros or more than 15 digits, for that is a name.
    """
    import pyarrow as pa

    typed = [table.columns[column].type for column in columns]
    if all(pa.types.is_boolean(kind) for kind in typed):
        return "flag"
    if any(pa.types.is_floating(kind) for kind in typed):
        return "number"
    cells = [table.text(column) for column in columns]
    labels = [label for one in cells for label in one.labels]
    missing = any((one.codes < 0).any() for one in cells)
    if not labels:
        return "text"
    if all(label.casefold() in ("true", "false") for label in labels):
        return "flag"
    plain = _plain(labels, table.options.decimal)
    numeric = _match(plain, _NUMBER)
    if not numeric.any() or (_match(plain, _IDENTIFIER).any() and numeric.all()):
        return "text"
    if numeric.all():
        return "integer" if _match(plain, _WHOLE).all() and not missing else "number"
    decimal = table.options.decimal
    rows = [np.append(_match(_plain(one.labels, decimal), _NUMBER), False)[one.codes] for one in cells]
    filled = [one.codes >= 0 for one in cells]
    # what is rarer is what is wrong, more likely
    numbers_are_rare = 2 * sum(map(np.count_nonzero, rows)) < sum(map(np.count_nonzero, filled))
    what = "a number, and others are text" if numbers_are_rare else "text, and others are numbers"
    for column, is_number, is_filled in zip(columns, rows, filled, strict=True):
        table.report(
            faults,
            "mixed-kinds",
            np.flatnonzero(is_filled & (is_number == numbers_are_rare)),
            column,
            f"is {what}",
            'mend it, or say kind = "text" in [variables]',
        )
    return None


def cell_values(
    table: Table, column: str, kind: CellKind, time_unit: str | float, faults: Faults
) -> Shaped[np.ndarray, " row"]:
    """Return the values of a column: float64 (NaN where there is none), int64, int8, or text (empty where none)."""
    if kind == "text":
        text = table.text(column)
        names: np.ndarray = np.array([*text.labels, ""], dtype=object)[text.codes]
        return names
    if kind == "flag":
        flags = table.text(column)
        said = np.array([_FLAGS.get(label.casefold(), -1) for label in flags.labels] + [-1], np.int8)[
            flags.codes
        ]
        table.report(
            faults,
            "not-a-flag",
            np.flatnonzero((said < 0) & (flags.codes >= 0)),
            column,
            "expected 1 or 0, true or false",
        )
        _report_missing(table, column, flags.codes < 0, "write 0 or 1", faults)
        return np.asarray(np.maximum(said, 0), np.int8)
    numbers = table.numbers(column, faults)
    if kind == "time":
        return scaled(numbers, "time", time_unit)
    if kind == "number":
        return numbers
    _report_missing(
        table, column, np.isnan(numbers), 'fill it in, or say kind = "number" in [variables]', faults
    )
    whole = np.nan_to_num(numbers)
    wrong = (whole != np.trunc(whole)) | (np.abs(whole) > _LARGEST)
    table.report(faults, "not-a-number", np.flatnonzero(wrong), column, "expected a whole number")
    return np.where(wrong, 0, whole).astype(np.int64)


def _report_missing(
    table: Table, column: str, missing: Bool[np.ndarray, " row"], remedy: str, faults: Faults
) -> None:
    table.report(faults, "missing-value", np.flatnonzero(missing), column, "there is no value", remedy)


def _plain(labels: list[str], decimal: str) -> list[str]:
    return [label.replace(",", ".") for label in labels] if decimal == "," else labels


def _match(labels: Sequence[str], pattern: str) -> Bool[np.ndarray, " label"]:
    import pyarrow as pa
    import pyarrow.compute as pc

    found: np.ndarray = pc.match_substring_regex(pa.array(labels, pa.string()), pattern).to_numpy(
        zero_copy_only=False
    )
    return found.astype(bool)
