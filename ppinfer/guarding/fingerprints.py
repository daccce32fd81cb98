"""Which files were read to their end, or written by this process: known by what the file system says of them."""

from __future__ import annotations

import hashlib
import os
from collections import OrderedDict
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ppinfer.errors import LogError, PPInferError

MOST_ENTRIES = 2_000_000
_MOST_REMEMBERED = 4096


@dataclass(frozen=True)
class Fingerprint:
    """What tells one state of a file or folder from another, and how many bytes it has."""

    size: int
    state: tuple[int, ...] | str


def fingerprint(path: Path, error: type[PPInferError] = LogError) -> Fingerprint:
    """Return the fingerprint of a file, or of a folder with all that is below it.

    Raises
    ------
    OSError
        If it is not there.
    PPInferError
        Of the class ``error``, if a folder holds more than two million entries.

    Examples
    --------
    >>> _ = Path("a.txt").write_text("abc")
    >>> fingerprint(Path("a.txt")).size
    3
    """
    told = os.stat(path)
    if not path.is_dir():
        return Fingerprint(told.st_size, _state(told))
    size, entries, folders = 0, 0, [str(path)]
    digest = hashlib.sha256()
    while folders:
        folder = folders.pop()
        with os.scandir(folder) as found:
            for entry in sorted(found, key=lambda one: one.name):
                entries += 1
                if entries > MOST_ENTRIES:
                    raise error(
                        f"{path}: holds more than {MOST_ENTRIES} files and folders, which are not looked through"
                    )
                told = entry.stat(follow_symlinks=False)
                # a link is not followed: what it leads to is none of the folder's
                if entry.is_dir(follow_symlinks=False):
                    folders.append(entry.path)
                elif entry.is_symlink():
                    with suppress(OSError):
                        told = entry.stat()
                size += told.st_size if not entry.is_dir(follow_symlinks=False) else 0
                digest.update(f"{entry.name!r}{_state(told)}".encode("utf-8", "surrogatepass"))
    return Fingerprint(size, digest.hexdigest())


class Remembered:
    """Files in a state that is known to be sound, the latest few thousand; what is known of each is kept with it.

    Examples
    --------
    >>> known = Remembered()
    >>> _ = Path("b.txt").write_text("abc")
    >>> known.remember("log", Path("b.txt"), fingerprint(Path("b.txt")), {"digest": "12"})
    >>> known.recall("log", Path("b.txt"), fingerprint(Path("b.txt")))
    {'digest': '12'}
    """

    def __init__(self) -> None:
        self._known: OrderedDict[tuple[str, str], tuple[Fingerprint, Any]] = OrderedDict()

    def remember(self, kind: str, path: Path, state: Fingerprint, told: Any) -> None:
        """Keep what is known of a file in a state."""
        self._known[kind, os.path.abspath(path)] = (state, told)
        if len(self._known) > _MOST_REMEMBERED:
            self._known.popitem(last=False)

    def recall(self, kind: str, path: Path, state: Fingerprint) -> Any | None:
        """Return what is known of a file, or None if it has another state now."""
        found = self._known.get((kind, os.path.abspath(path)))
        return found[1] if found is not None and found[0] == state else None


REMEMBERED = Remembered()
_WRITTEN = "written here"


def remember_written(path: Path) -> None:
    """Take note that this process has just written a file or folder whole: it need not be guarded against.

    Examples
    --------
    >>> _ = Path("c.txt").write_text("abc")
    >>> remember_written(Path("c.txt"))
    >>> was_written(Path("c.txt"), fingerprint(Path("c.txt")))
    True
    """
    try:
        state = fingerprint(path)
    except (OSError, PPInferError):
        # it is gone again: whoever opens it will say so
        return
    REMEMBERED.remember(_WRITTEN, path, state, True)


def was_written(path: Path, state: Fingerprint) -> bool:
    """Return whether this process wrote the file, and it is still as it was then."""
    return REMEMBERED.recall(_WRITTEN, path, state) is not None


def _state(told: os.stat_result) -> tuple[int, ...]:
    # the time of the last change of the inode cannot be set back by hand
    return (told.st_dev, told.st_ino, told.st_size, told.st_mtime_ns, told.st_ctime_ns)
