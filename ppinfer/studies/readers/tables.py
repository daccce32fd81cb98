"""CSV and Parquet tables as columns of text or numbers; every wrong cell is reported with its line."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer import guarding
from ppinfer.errors import LogError
from ppinfer.guarding.limits import how_to_allow_more, told_bytes
from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.readers.mapping import FileOptions, closest
from ppinfer.studies.readers.text_shape import MOST_COLUMNS, check_lines

_SPREADSHEETS = (".xlsx", ".xls", ".xlsm", ".ods", ".numbers")
_NUMBER = r"^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$"


@dataclass(frozen=True)
class Labels:
    """A column of text: for each row the index of its label; -1 = no value."""

    codes: Int[np.ndarray, " row"]
    labels: list[str]


@dataclass(frozen=True)
class Table:
    """Some columns of a file.

    Parameters
    ----------
    path, options
        The file, and how it is written.
    columns
        A ``pyarrow.ChunkedArray`` a column.
    n_rows
        How many rows there are.
    """

    path: Path
    options: FileOptions
    columns: dict[str, Any]
    n_rows: int

    @cached_property
    def lines(self) -> Int[np.ndarray, " row"]:
        """The line on which each row begins (CSV), or the row's number from 1 (Parquet)."""
        if not _is_csv(self.path):
            return np.arange(1, self.n_rows + 1)
        # only wanted once there is a fault to report, so the plain loop over the file does not matter
        return np.array([line for line, row in _csv_rows(self.path, self.options) if row][1:])

    def fault(self, kind: str, message: str, row: int, column: str | None, remedy: str = "") -> Fault:
        """Return a fault at a row."""
        return Fault(kind, message, remedy, file=self.path.name, line=int(self.lines[row]), column=column)

    def report(
        self,
        faults: Faults,
        kind: str,
        rows: Int[np.ndarray, " fault"],
        column: str,
        message: str,
        remedy: str = "",
    ) -> None:
        """Count a fault at each row."""
        faults.add_each(kind, rows.tolist(), lambda row: self.fault(kind, message, row, column, remedy))

    def text(self, column: str) -> Labels:
        """Return a column as labels, in order of their first appearance."""
        import pyarrow as pa

        cells, missing = self._cells(column)
        encoded = cells.combine_chunks().dictionary_encode()
        if isinstance(encoded, pa.ChunkedArray):
            encoded = encoded.combine_chunks()
        codes = encoded.indices.fill_null(-1).to_numpy(zero_copy_only=False).astype(np.int64)
        codes[missing] = -1
        return Labels(codes, encoded.dictionary.to_pylist())

    def numbers(self, column: str, faults: Faults) -> Float[np.ndarray, " row"]:
        """Return a column as numbers, NaN where there is no value; other cells are faults."""
        import pyarrow as pa
        import pyarrow.compute as pc

        kind = self.columns[column].type
        if pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind):
            # whole numbers beyond 2^53 are rounded, as they are where a CSV file says them
            values = self.columns[column].cast(pa.float64(), safe=False).to_numpy()
            bad = np.isinf(values)
            cells = self.columns[column]
        else:
            cells, _ = self._cells(column)
            if self.options.decimal == ",":
                cells = pc.replace_substring(cells, ",", ".")
            try:
                values = cells.cast(pa.float64()).to_numpy()
                bad = ~np.isfinite(values) & cells.is_valid().to_numpy()
            except pa.ArrowInvalid:
                fine = pc.match_substring_regex(cells, _NUMBER).fill_null(True)
                bad = ~fine.to_numpy(zero_copy_only=False)
                kept = pc.if_else(fine, pc.replace_substring_regex(cells, r"^\+", ""), None)
                values = kept.cast(pa.float64()).to_numpy()
                bad |= np.isinf(values)
        values = values.copy()
        # any number will do where a fault has been told: NaN would be told again, as a missing value
        values[bad] = 0.0
        faults.add_each(
            "not-a-number",
            np.flatnonzero(bad).tolist(),
            lambda row: self.fault(
                "not-a-number", f"expected a finite number, got {cells[row].as_py()!r}", row, column
            ),
        )
        return np.asarray(values, np.float64)

    def _cells(self, column: str) -> tuple[Any, Bool[np.ndarray, " row"]]:
        import pyarrow as pa
        import pyarrow.compute as pc

        cells = pc.utf8_trim_whitespace(self.columns[column].cast(pa.string()))
        empty = pc.is_in(cells, value_set=pa.array(self.options.missing, pa.string()))
        cells = pc.if_else(empty, pa.scalar(None, pa.string()), cells)
        if isinstance(cells, pa.Array):
            cells = pa.chunked_array([cells])
        return cells, cells.is_null().to_numpy()


def read_table(
    path: Path, wanted: Sequence[tuple[str, str]], options: FileOptions, faults: Faults
) -> Table | None:
    """Read some columns of a CSV or Parquet file.

    Parameters
    ----------
    path
        The file; ``.parquet`` or ``.pq`` is Parquet, anything else CSV.
    wanted
        The columns, each with the mapping's entry that names it (empty where there is no mapping).
    options
        How a CSV file is written.
    faults
        Where everything wrong is reported.

    Returns
    -------
    Table or None
        None if the file cannot be read, lacks columns, or has rows of different lengths.

    Raises
    ------
    LogError
        If reading it takes more time or memory than a file may, or crashes what reads it (see `ppinfer.guarding`).
    """
    with guarding.admitted("table", path, wanted=list(wanted), options=options.model_dump()) as known:
        if known.get("faults"):
            # found by the process that reads files under limits: this one need not look at the file
            faults.extend(Faults.from_json(known["faults"]))
            return None
        return _told(path, wanted, options, faults)


def _told(
    path: Path, wanted: Sequence[tuple[str, str]], options: FileOptions, faults: Faults
) -> Table | None:
    import pyarrow as pa

    try:
        if not path.exists():
            faults.add(Fault("unreadable", "there is no such file", file=str(path)))
            return None
        return _read(path, wanted, options, faults)
    except (LogError, MemoryError):
        raise
    except (pa.ArrowException, OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        reason = " ".join(str(error).split())[:200]
        told, remedy = (
            f"cannot be read: {reason}",
            "it is damaged, or not the CSV or Parquet file it claims to be",
        )
        if isinstance(error, UnicodeDecodeError):
            told, remedy = "is not UTF-8 text", "save it as UTF-8"
            if path.suffix.lower() in _SPREADSHEETS:
                told, remedy = "is a spreadsheet", "save its sheet as CSV in UTF-8"
        faults.add(Fault("unreadable", told, remedy, file=path.name))
        return None


def _read(
    path: Path, wanted: Sequence[tuple[str, str]], options: FileOptions, faults: Faults
) -> Table | None:
    if path.is_dir():
        faults.add(Fault("unreadable", "is a folder; give one CSV or Parquet file", file=str(path)))
        return None
    if not _is_csv(path):
        import pyarrow.parquet as pq

        with pq.ParquetFile(path) as file:
            if not _has_columns(file.schema_arrow.names, wanted, path, faults):
                return None
            _refuse_large(path, file.metadata, len(wanted))
            table = _plain_columns(file.read(columns=sorted({column for column, _ in wanted})), path, faults)
            if table is None:
                return None
    elif not check_lines(path, faults):
        return None
    else:
        header = next((row for _, row in _csv_rows(path, options) if row), None)
        if header is None:
            faults.add(Fault("empty", "the file is empty", file=path.name))
            return None
        if len(header) > MOST_COLUMNS:
            told = f"has {len(header)} columns, more than the {MOST_COLUMNS} that are read"
            faults.add(Fault("many-columns", told, file=path.name, line=1))
            return None
        if not _has_columns(header, wanted, path, faults):
            return None
        table = _read_csv(path, header, sorted({column for column, _ in wanted}), options, faults)
        if table is None:
            return None
    if table.num_rows == 0:
        faults.add(Fault("empty", "there are no rows", file=path.name))
        return None
    return Table(path, options, {name: table.column(name) for name in table.column_names}, table.num_rows)


def _refuse_large(path: Path, metadata: Any, columns: int) -> None:
    """Refuse a few bytes that claim to be rows without end."""
    size = path.stat().st_size
    packed = sum(metadata.row_group(index).total_byte_size for index in range(metadata.num_row_groups))
    claimed, most = max(packed, 8 * columns * metadata.num_rows), guarding.limits_for(size).memory
    if claimed > most or packed < 0 or metadata.num_rows < 0:
        raise LogError(
            f"{path}: claims {told_bytes(claimed)} in {metadata.num_rows} rows, more than the {told_bytes(most)} that "
            "a file of its size may unpack to: " + how_to_allow_more("MEMORY", f"{(4 * claimed >> 30) + 1}G")
        )


def _plain_columns(table: Any, path: Path, faults: Faults) -> Any:
    """Return a Parquet table with all columns as numbers or text; report those that hold anything else."""
    import pyarrow as pa

    before = faults.total
    for index, name in enumerate(table.column_names):
        kind = table.column(index).type
        if pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind):
            continue
        try:
            if pa.types.is_binary(kind) or pa.types.is_large_binary(kind):
                raise pa.ArrowInvalid("bytes are no text")
            table = table.set_column(index, name, table.column(index).cast(pa.string()))
        except MemoryError:
            raise
        except pa.ArrowException:
            told = f"holds values of type {kind}"
            faults.add(Fault("wrong-type", told, "write numbers or text", file=path.name, column=name))
    return table if faults.total == before else None


def _read_csv(path: Path, header: list[str], columns: list[str], options: FileOptions, faults: Faults) -> Any:
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    ragged = []

    def skip(row: Any) -> str:
        if row.text.strip():
            ragged.append(row)
        return "skip"

    table = arrow_csv.read_csv(
        path,
        parse_options=arrow_csv.ParseOptions(
            delimiter=options.delimiter,
            newlines_in_values=True,
            invalid_row_handler=skip,
            ignore_empty_lines=True,
        ),
        convert_options=arrow_csv.ConvertOptions(
            include_columns=columns,
            column_types=dict.fromkeys(columns, pa.string()),
            strings_can_be_null=False,
        ),
    )
    if ragged:
        for line, row in _csv_rows(path, options):
            if row and len(row) != len(header):
                told = f"has {len(row)} cells, the header has {len(header)}"
                faults.add(Fault("wrong-length", told, "a cell was lost or split", file=path.name, line=line))
        return None
    return table


def _has_columns(
    header: Sequence[str], wanted: Sequence[tuple[str, str]], path: Path, faults: Faults
) -> bool:
    before = faults.total
    for column, entry in wanted:
        if column not in header:
            told = (
                f"there is no such column (the mapping's {entry!r})" if entry else "there is no such column"
            )
            faults.add(Fault("missing-column", told, closest(column, header), file=path.name, column=column))
        elif list(header).count(column) > 1:
            told = f"there are {list(header).count(column)} columns of this name"
            faults.add(Fault("duplicate-column", told, "rename them", file=path.name, column=column))
    return faults.total == before


def _csv_rows(path: Path, options: FileOptions) -> Iterator[tuple[int, list[str]]]:
    """Yield the line on which each row begins, and the row; blank lines are empty rows."""
    with path.open(newline="", encoding="utf-8-sig") as file:
        reader = csv.reader(file, delimiter=options.delimiter)
        line = 1
        for row in reader:
            yield line, row
            line = reader.line_num + 1


def _is_csv(path: Path) -> bool:
    return path.suffix.lower() not in (".parquet", ".pq")
