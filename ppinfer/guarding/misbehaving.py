"""A reader that does what a damaged file can make a reader do: to see for oneself that the guard holds."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ppinfer.errors import LogError
from ppinfer.guarding.limits import Limits


def misbehave(path: str, *, limits: Limits, progress: Callable[[int, int], None]) -> Any:
    """Read what to do from a file, and do it: hang, spin, allocate, crash, exit, recurse, write, refuse or answer.

    Only `ppinfer.guarding` calls it, where a test asks for it by name.

    Examples
    --------
    >>> from ppinfer import guarding
    >>> _ = Path("bad.txt").write_text("crash")
    >>> guarding.asked("misbehave", "bad.txt")
    Traceback (most recent call last):
        ...
    ppinfer.errors.LogError: bad.txt: cannot be read: it crashed the library that reads it (SIGSEGV): ...
    """
    what = Path(path).read_text(encoding="utf-8").strip()
    progress(1, 2)
    if what == "hang":
        time.sleep(3600)
    while what == "spin":
        pass
    if what == "allocate":
        return len(bytearray(4 * limits.memory))
    if what == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if what == "exit":
        os._exit(3)
    if what == "recurse":
        return misbehave(path, limits=limits, progress=progress)
    if what == "write":
        Path(path + ".written").write_text("x")
    if what == "refuse":
        raise LogError(f"{path}: line 1: says 'refuse'")
    if what == "stumble":
        raise KeyError("a bug of the reader")
    if what == "missing":
        return Path(path + ".none").read_text(encoding="utf-8")
    return {"said": what, "memory": limits.memory}
