"""How much time and memory the reading of a file may take, and how to allow more."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace

from ppinfer.errors import PPInferError

SECONDS, BYTES_PER_SECOND = 30.0, 2_000_000
MEMORY, MEMORY_PER_BYTE = 1 << 30, 20
_UNITS = {"K": 1 << 10, "M": 1 << 20, "G": 1 << 30, "T": 1 << 40}


@dataclass(frozen=True)
class Limits:
    """What the reading of one file may take.

    Parameters
    ----------
    seconds
        Of the clock, and of the processor.
    memory
        Bytes, beyond what the helper process takes before it reads anything; also the most that a file may unpack to.

    Examples
    --------
    >>> Limits(seconds=2, memory=1 << 20).seconds
    2
    """

    seconds: float
    memory: int


@dataclass(frozen=True)
class _Settings:
    trusting: bool = False
    seconds: float | None = None
    memory: int | None = None
    set_by_parent: bool = False


_NONE = _Settings()
_SETTINGS: ContextVar[_Settings] = ContextVar("ppinfer_guard", default=_NONE)


def limits_for(size: int) -> Limits:
    """Return the limits for a file of some bytes: 30 s and 1 s for 2 MB, 1 GiB and 20 times its size.

    Raises
    ------
    PPInferError
        Where ``PPINFER_GUARD_SECONDS`` or ``PPINFER_GUARD_MEMORY`` is no positive number.

    Examples
    --------
    >>> limits_for(20_000_000).seconds
    40.0

    A file that is trusted has none:

    >>> with trusting():
    ...     limits_for(20_000_000).seconds
    inf
    """
    told = _SETTINGS.get()
    if told.set_by_parent:
        assert told.seconds is not None
        assert told.memory is not None
        return Limits(told.seconds, told.memory)
    if not is_guarding():
        return Limits(math.inf, sys.maxsize)
    seconds = told.seconds if told.seconds is not None else _from_environment("SECONDS")
    memory = told.memory if told.memory is not None else _from_environment("MEMORY")
    return Limits(
        SECONDS + size / BYTES_PER_SECOND if seconds is None else seconds,
        MEMORY + MEMORY_PER_BYTE * size if memory is None else int(memory),
    )


def is_guarding() -> bool:
    """Return whether files are guarded here and now.

    Examples
    --------
    >>> with trusting():
    ...     is_guarding()
    False
    """
    if _SETTINGS.get().trusting:
        return False
    told = os.environ.get("PPINFER_GUARD", "on").strip().lower()
    if told not in ("on", "off", ""):
        raise PPInferError(f"PPINFER_GUARD is {told!r}; 'on' or 'off' is expected")
    return told != "off"


@contextmanager
def trusting() -> Iterator[None]:
    """Open files here without the helper process: for files that are surely sound, e.g. one's own.

    Examples
    --------
    >>> from ppinfer.studies import open_log
    >>> with trusting():
    ...     open_log("nowhere.nc")
    Traceback (most recent call last):
        ...
    ppinfer.errors.LogError: nowhere.nc: there is no such file
    """
    before = _SETTINGS.set(replace(_SETTINGS.get(), trusting=True))
    try:
        yield
    finally:
        _SETTINGS.reset(before)


@contextmanager
def limited(*, seconds: float | None = None, memory: int | None = None) -> Iterator[None]:
    """Set the limits of the files that are opened within the block, in this thread.

    Parameters
    ----------
    seconds, memory
        As in `Limits`; None leaves a limit as it is.

    Examples
    --------
    >>> with limited(seconds=300):
    ...     limits_for(0).seconds
    300
    """
    if any(limit is not None and not limit > 0 for limit in (seconds, memory)):
        raise PPInferError(f"limits are positive numbers; got seconds={seconds}, memory={memory}")
    told = _SETTINGS.get()
    before = _SETTINGS.set(
        replace(
            told,
            seconds=told.seconds if seconds is None else seconds,
            memory=told.memory if memory is None else memory,
        )
    )
    try:
        yield
    finally:
        _SETTINGS.reset(before)


def obey(limits: Limits) -> None:
    """In the helper process: these limits hold from now on, and nothing is guarded a second time.

    Examples
    --------
    >>> import contextvars
    >>> contextvars.copy_context().run(lambda: (obey(Limits(2.0, 100)), limits_for(0))[1])
    Limits(seconds=2.0, memory=100)
    """
    _SETTINGS.set(_Settings(trusting=True, seconds=limits.seconds, memory=limits.memory, set_by_parent=True))


def how_to_allow_more(name: str, value: str) -> str:
    """Return the words that a message ends with."""
    return (
        f"it is damaged, or made to do harm; if you trust it, allow more with PPINFER_GUARD_{name}={value} or read it "
        "unguarded with PPINFER_GUARD=off"
    )


def told_bytes(count: float) -> str:
    """Return a number of bytes as people write it.

    Examples
    --------
    >>> told_bytes(3 << 30)
    '3 GiB'
    """
    for unit in ("bytes", "KiB", "MiB", "GiB", "TiB", "PiB"):
        if count < 1024 or unit == "PiB":
            break
        count /= 1024
    return f"{count:.3g} {unit}"


def _from_environment(name: str) -> float | None:
    told = os.environ.get(f"PPINFER_GUARD_{name}", "").strip()
    if not told:
        return None
    text, unit = told, 1
    if name == "MEMORY":
        text = told.upper().removesuffix("B").removesuffix("I")
        unit = _UNITS.get(text[-1:], 1)
        text = text.rstrip("KMGT")
    try:
        value = float(text) * unit
    except ValueError:
        value = math.nan
    if not (value > 0 and math.isfinite(value)):
        example = "'120'" if name == "SECONDS" else "'8G' or a number of bytes"
        raise PPInferError(f"PPINFER_GUARD_{name} is {told!r}; expected a positive number such as {example}")
    return value
