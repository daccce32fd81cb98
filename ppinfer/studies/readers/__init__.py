"""Readers of other formats, by the name that ``ppinfer convert --from`` takes.

A new reader is one file with one function, and one line in `READERS`.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import xarray as xr

from ppinfer import guarding
from ppinfer.errors import LogError
from ppinfer.studies.progress import ProgressCallback, silent


@dataclass(frozen=True)
class Reader:
    """Where a reader is, what it reads, whether it takes a mapping of columns and tells its progress."""

    module: str
    function: str
    reads: str
    needs_mapping: bool = False
    tells_progress: bool = False

    def load(self) -> Callable[..., xr.Dataset]:
        """Import the reader's function (by name, since readers import from this package)."""
        function: Callable[..., xr.Dataset] = getattr(importlib.import_module(self.module), self.function)
        return function


READERS: dict[str, Reader] = {
    "reaching-study": Reader(
        "ppinfer.studies.readers.reaching_study",
        "read_reaching_study",
        "the folder of the 2023 reaching study",
        tells_progress=True,
    ),
    "eth": Reader(
        "ppinfer.studies.readers.eth", "read_eth", "an ETH/BIWI folder with obsmat.txt and destinations.txt"
    ),
    "tidy": Reader(
        "ppinfer.studies.readers.tidy",
        "read_tidy",
        "a CSV or Parquet table, and a mapping of its columns",
        True,
    ),
    "recording": Reader("ppinfer.studies.recording", "read_recording", "a JSON-lines recording of a study"),
}


def read_study(
    source: str | os.PathLike[str],
    reader: str,
    *,
    mapping: str | os.PathLike[str] | None = None,
    progress: ProgressCallback = silent,
) -> xr.Dataset:
    """Read a study with the reader of that name.

    Another process reads it first, under limits of time and memory (see `ppinfer.guarding`).

    Parameters
    ----------
    source
        The file or folder to read.
    reader
        One of `READERS`.
    mapping
        What the columns of a table are, for the reader that needs it.
    progress
        Told how many files are read, of how many, by readers of many files.

    Raises
    ------
    LogError
        If there is no such reader, a mapping is missing or not wanted, or the source is faulty.

    Examples
    --------
    >>> read_study("nowhere.csv", "fortran")
    Traceback (most recent call last):
        ...
    ppinfer.errors.LogError: there is no reader 'fortran'; choose one of reaching-study, eth, tidy, recording
    """
    if reader not in READERS:
        raise LogError(f"there is no reader {reader!r}; choose one of {', '.join(READERS)}")
    known = READERS[reader]
    if known.needs_mapping != (mapping is not None):
        told = (
            "needs a mapping of its columns (--mapping M.toml)"
            if known.needs_mapping
            else "takes no --mapping"
        )
        raise LogError(f"{source}: reader {reader!r} {told}")
    if not Path(source).exists():
        raise LogError(f"{source}: there is no such file or folder")
    arguments = [source] if mapping is None else [source, mapping]
    named = None if mapping is None else str(mapping)
    with guarding.admitted("study", source, beside=_beside(named), reader=reader, mapping=named):
        return known.load()(*arguments, **({"progress": progress} if known.tells_progress else {}))


def _beside(mapping: str | None) -> tuple[Path, ...]:
    """Return the other tables that a mapping names; whoever reads the mapping says what is wrong with it."""
    if mapping is None:
        return ()
    try:
        told = guarding.read_toml(mapping)
    except (OSError, ValueError):
        return ()
    others = [told.get(name) for name in ("goals_file", "segments_file")]
    names = [other.get("path") for other in others if isinstance(other, dict)]
    return tuple(Path(mapping).parent / name for name in names if isinstance(name, str))
