"""A reader, the valid files that mutations of what it reads begin with, and how to hold it to the law."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Case:
    """A reader, and how to hold it to the law."""

    name: str
    files: Mapping[str, bytes]
    read: Callable[[Path], Any]
    target: str | None = None
    options: Mapping[str, Any] = field(default_factory=dict)


def contents(folder: Path) -> dict[str, bytes]:
    """Return the content of every file below a folder, by relative name."""
    return {
        item.relative_to(folder).as_posix(): item.read_bytes()
        for item in sorted(folder.rglob("*"))
        if item.is_file()
    }


def made(make: Callable[[Path], Any]) -> dict[str, bytes]:
    """Return what a function writes into a folder."""
    with tempfile.TemporaryDirectory() as folder:
        make(Path(folder))
        return contents(Path(folder))


def converted(read: Callable[[Path], Any]) -> Callable[[Path], Any]:
    """Return a reader that refuses, as ``ppinfer convert`` does, what is no sound log."""
    from ppinfer.studies import validate_log

    def checked(path: Path) -> Any:
        log = read(path)
        replace(validate_log(log), source=str(path)).raise_if_faulty()
        return log

    return checked


def same_log_of_a_table(one: Any, other: Any) -> bool:
    """Return whether two logs say the same, but for the digest of their sources."""
    from ppinfer.testing.reader_laws import same_content

    # a folder is called as its input is numbered
    return same_content(one.assign_attrs(source=""), other.assign_attrs(source=""))
