"""Files and folders that appear whole or not at all: written beside their place, then renamed.

A process that is killed leaves what it was writing under a hidden name, ``.LOG.nc.<machine>-<process>-<number>.part``.
It is never read, and the next writing of the same name removes it, unless the process that it names still runs.
"""

from __future__ import annotations

import os
import platform
import re
import secrets
import shutil
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ppinfer.guarding import remember_written


@contextmanager
def temporary_beside(target: Path) -> Iterator[Path]:
    """Yield a free name in the folder of ``target``; a file or folder that is still there at the end vanishes.

    So does what processes that are no more left there on their way to the same target.

    Examples
    --------
    >>> with temporary_beside(Path("log.nc")) as temporary:
    ...     _ = temporary.write_text("half")
    >>> temporary.exists()
    False
    """
    _remove_leftovers(target)
    temporary = _hidden_name(target, "part")
    try:
        yield temporary
    finally:
        _remove(temporary)


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Yield a temporary name beside ``target`` that takes its place on success and vanishes on failure.

    Examples
    --------
    >>> with replacing(Path("log.txt")) as temporary:
    ...     _ = temporary.write_text("whole")
    >>> Path("log.txt").read_text()
    'whole'
    """
    with temporary_beside(target) as temporary:
        yield temporary
        if not target.is_dir():
            os.replace(temporary, target)
            remember_written(target)
            return
        # a folder cannot be replaced in one step: the old one steps aside and comes back if that fails
        aside = _hidden_name(target, "old")
        target.rename(aside)
        try:
            temporary.replace(target)
        except BaseException:
            aside.rename(target)
            raise
        remember_written(target)
        shutil.rmtree(aside)


def _hidden_name(target: Path, kind: str) -> Path:
    return target.with_name(f".{target.name}.{_machine()}-{os.getpid()}-{secrets.token_hex(6)}.{kind}")


def _machine() -> str:
    return f"{zlib.crc32(platform.node().encode()):08x}"


def _remove_leftovers(target: Path) -> None:
    if os.name != "posix" or not target.parent.is_dir():
        return
    named = re.compile(rf"\.{re.escape(target.name)}\.{_machine()}-(\d+)-[0-9a-f]{{12}}\.(part|old)")
    for item in list(target.parent.iterdir()):
        match = named.fullmatch(item.name)
        # what stepped aside for a folder that never came is the only one there is
        if match and not _runs(int(match[1])) and (match[2] == "part" or target.exists()):
            _remove(item)


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _remove(place: Path) -> None:
    if place.is_dir() and not place.is_symlink():
        shutil.rmtree(place)
    else:
        place.unlink(missing_ok=True)
