"""Files and folders that appear whole or not at all: written beside their place, then renamed."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ppinfer.guarding import remember_written


@contextmanager
def temporary_beside(target: Path) -> Iterator[Path]:
    """Yield a free name in the folder of ``target``; a file or folder that is still there at the end vanishes.

    Examples
    --------
    >>> with temporary_beside(Path("log.nc")) as temporary:
    ...     _ = temporary.write_text("half")
    >>> temporary.exists()
    False
    """
    temporary = target.with_name(f".{target.name}.{secrets.token_hex(6)}.part")
    try:
        yield temporary
    finally:
        if temporary.is_dir():
            shutil.rmtree(temporary)
        else:
            temporary.unlink(missing_ok=True)


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
        aside = target.with_name(f".{target.name}.{secrets.token_hex(6)}.old")
        target.rename(aside)
        try:
            temporary.replace(target)
        except BaseException:
            aside.rename(target)
            raise
        remember_written(target)
        shutil.rmtree(aside)
