"""Whether a file has the shape of text in lines, before anything takes it apart: UTF-8, no NUL, no endless line."""

from __future__ import annotations

import codecs
from pathlib import Path

from ppinfer.guarding.limits import told_bytes
from ppinfer.studies.faults import Fault, Faults

MOST_LINE = 1 << 20
"""Bytes of the longest line that is read; the CSV reader takes no longer ones."""
MOST_COLUMNS = 10_000
_BLOCK = 1 << 22


def check_lines(path: Path, faults: Faults) -> bool:
    r"""Report a file with NUL bytes or a line of more than 1 MiB; return whether there is neither.

    Raises
    ------
    OSError
        If it cannot be read.
    UnicodeDecodeError
        If it is not UTF-8.

    Examples
    --------
    >>> _ = Path("endless.csv").write_bytes(b"a,b\n" + b"1" * 2_000_000)
    >>> faults = Faults()
    >>> check_lines(Path("endless.csv"), faults)
    False
    >>> print(faults.listed[0])
    endless.csv: line 2: is longer than 1 MiB; ...
    """
    line, length = 1, 0
    decoder = codecs.getincrementaldecoder("utf-8")()
    with path.open("rb") as file:
        while block := file.read(_BLOCK):
            decoder.decode(block)
            if (at := block.find(b"\0")) >= 0:
                line += block.count(b"\n", 0, at)
                told, remedy = "holds a NUL byte, so it is no text", "save it as UTF-8 text"
                faults.add(Fault("no-text", told, remedy, file=path.name, line=line))
                return False
            # a block of lines is longer than a line may be: only where two ends lie far apart, look closer
            parts = block.split(b"\n") if _has_long_line(block, length) else None
            if parts is not None:
                for index, part in enumerate(parts):
                    if len(part) + (length if index == 0 else 0) > MOST_LINE:
                        told = f"is longer than {told_bytes(MOST_LINE)}"
                        remedy = "is it a table, with a row on each line?"
                        faults.add(Fault("long-line", told, remedy, file=path.name, line=line + index))
                        return False
            line += block.count(b"\n")
            last = block.rfind(b"\n")
            length = len(block) - last - 1 if last >= 0 else length + len(block)
    decoder.decode(b"", final=True)
    return True


def _has_long_line(block: bytes, before: int) -> bool:
    """Return whether some line may be too long: an end of line is looked for in each half of what a line may have."""
    half = MOST_LINE // 2
    if before + len(block) <= MOST_LINE:
        return False
    start = 0
    while start < len(block):
        if block.find(b"\n", start, start + half) < 0:
            return True
        start += half
    return False
