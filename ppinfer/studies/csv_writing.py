"""CSV tables that appear whole or not at all, and in which whatever came from a log or a survey is text."""

from __future__ import annotations

import csv
import math
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ppinfer.errors import LogError
from ppinfer.studies.replacing import replacing

# what makes spreadsheets compute a cell instead of showing it, also in the wide forms of East Asian keyboards
_RUNS = tuple("=+-@＝＋－＠")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# control characters, separators of lines, marks that turn the direction of what follows, halves of characters
_UNSEEN = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ufeff\ud800-\udfff]")
_ESCAPED = re.compile(r"\\(\\|x[0-9a-f]{2}|u[0-9a-f]{4})")


def write_csv(path: str | os.PathLike[str], columns: Mapping[str, Sequence[Any] | np.ndarray]) -> None:
    """Write columns of equal length as a CSV file (UTF-8, quoted as RFC 4180 has it, lines that end in a newline).

    Numbers are written so that they read back exactly; NaN and None are empty cells, True and False 1 and 0. A text
    that a spreadsheet would run as a formula is written as text (`cell_of_text`), in the header too.

    Parameters
    ----------
    path : path
        The file. It takes the place of an older one only once it is complete.
    columns : mapping of str to sequence
        Texts and numbers (Python's or NumPy's) of each column, all of one length.

    Raises
    ------
    LogError
        If there are no columns, their lengths differ, or a value is neither text nor number.

    Examples
    --------
    >>> write_csv("scores.csv", {"participant": ["P01", "=cmd()"], "fluency": [3.5, float("nan")]})
    >>> print(Path("scores.csv").read_text())
    participant,fluency
    P01,3.5
    '=cmd(),
    <BLANKLINE>
    """
    target = Path(path)
    lengths = {name: len(values) for name, values in columns.items()}
    if len(set(lengths.values())) != 1:
        told = ", ".join(f"{name!r} has {length}" for name, length in lengths.items())
        raise LogError(
            f"{target}: the columns of a table have one length, but {told}"
            if told
            else f"{target}: a table without columns"
        )
    cells = [
        [_cell(value, name, row, target) for row, value in enumerate(_plain(values), start=1)]
        for name, values in columns.items()
    ]
    with replacing(target) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([cell_of_text(name) for name in columns])
        writer.writerows(zip(*cells, strict=True))


def cell_of_text(text: str) -> str:
    r"""Return a text as it stands in a cell, where no spreadsheet computes it and nothing in it is invisible.

    1. A backslash is doubled, and characters that cannot be seen (control characters, line ends and tabs among
       them, marks that turn the direction of writing) become ``\x0a`` or ``\u202e``.
    2. A text that begins with ``=``, ``+``, ``-`` or ``@``, or with apostrophes and one of these, gets an apostrophe
       before it, unless it is a plain number.

    Different texts stay different; `text_of_cell` is the way back.

    Examples
    --------
    >>> cell_of_text("=1+1"), cell_of_text("-3.5"), cell_of_text("a\tb"), cell_of_text("Ann")
    ("'=1+1", '-3.5', 'a\\x09b', 'Ann')
    """
    seen = _UNSEEN.sub(_visible, text.replace("\\", "\\\\"))
    begins = seen.strip().lstrip("'").lstrip()
    runs = begins.startswith(_RUNS) and not _NUMBER.fullmatch(seen)
    return f"'{seen}" if runs else seen


def text_of_cell(cell: str) -> str:
    r"""Return the text that `cell_of_text` made a cell of.

    Examples
    --------
    >>> text_of_cell("'=1+1"), text_of_cell("a\\x09b")
    ('=1+1', 'a\tb')
    """
    runs = cell.startswith("'") and cell_of_text(_shown(cell[1:])) == cell
    return _shown(cell[1:] if runs else cell)


def _shown(cell: str) -> str:
    return _ESCAPED.sub(
        lambda found: "\\" if found[1] == "\\" else chr(int(found[1][1:], 16)),
        cell,
    )


def _visible(found: re.Match[str]) -> str:
    code = ord(found[0])
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"


def _plain(values: Sequence[Any] | np.ndarray) -> list[Any]:
    return values.tolist() if isinstance(values, np.ndarray) else list(values)


def _cell(value: Any, column: str, row: int, target: Path) -> str:
    if isinstance(value, np.generic):
        value = value.item()
    if value is None:
        return ""
    if isinstance(value, str):
        return cell_of_text(value)
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, int):
        return repr(value)
    if isinstance(value, float):
        return "" if math.isnan(value) else repr(value)
    raise LogError(
        f"{target}: column {column!r}, row {row}: a cell holds text or a number, got {type(value).__name__}"
    )
