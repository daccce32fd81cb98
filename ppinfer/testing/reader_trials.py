"""Attempts that may hang, eat the memory or crash: made in a child process with limits, and counted."""

from __future__ import annotations

import faulthandler
import gc
import json
import math
import os
import select
import signal
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from ppinfer.guarding.limits import Limits, limited, obey

_PATIENCE = 6
"""A child that waits instead of working is given up after so many times the CPU seconds it may take."""


@dataclass(frozen=True)
class Bounds:
    """What one attempt may take: CPU seconds, and bytes beyond what the process has."""

    seconds: int
    memory: int


@dataclass(frozen=True)
class Outcome:
    """What came of one attempt: what it was, whether it was refused, how it broke the law (empty if not), its cost.

    `ended` says that the process did not live through it.
    """

    index: int
    name: str
    refused: bool
    broken: str
    seconds: float
    memory: int
    ended: bool = False


def attempts(
    attempt: Callable[[int], tuple[str, bool, str]],
    prepare: Callable[[], None],
    indices: Sequence[int],
    bounds: Bounds,
) -> Generator[Outcome, None, None]:
    """Make attempts one after another in a child process; one that ends it is made again as `ppinfer.guarding` has it.

    Libraries hang and crash on some damaged files, whoever calls them: what matters is that the guard then refuses.

    Parameters
    ----------
    attempt
        From its index: what it was, whether it was refused, and how the law was broken (empty if not).
    prepare
        What each child does first.
    indices
        Which attempts.
    bounds
        What one may take.

    Raises
    ------
    AssertionError
        Where not even `prepare` succeeds.

    Examples
    --------
    >>> [one.name for one in attempts(lambda index: (str(index), False, ""), lambda: None, [3], Bounds(5, 1 << 28))]
    ['3']
    """
    left = list(indices)
    while left:
        begun = False
        for outcome in _one_child(attempt, prepare, left, bounds):
            begun = True
            left = left[left.index(outcome.index) + 1 :]
            if outcome.ended:
                again = _one_child(attempt, prepare, [outcome.index], bounds, guarded=True)
                outcome = replace(next(again, outcome), ended=True)
                again.close()
            yield outcome
        assert begun or not left, "the child process ended before its first attempt"


def _one_child(
    attempt: Callable[[int], tuple[str, bool, str]],
    prepare: Callable[[], None],
    indices: Sequence[int],
    bounds: Bounds,
    *,
    guarded: bool = False,
) -> Generator[Outcome, None, None]:
    reading, writing = os.pipe()
    with warnings.catch_warnings():
        # Python warns that other threads' locks stay locked in the child: those of ours are made anew there
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        try:
            os.close(reading)
            _work(attempt, prepare, indices, bounds, writing, guarded)
        finally:
            os._exit(0)
    os.close(writing)
    current: dict[str, Any] = {}
    try:
        for told in _lines(reading, _PATIENCE * bounds.seconds):
            if "failed" in told:
                raise AssertionError(f"the valid files cannot be read: {told['failed']}")
            if "begun" in told:
                current = told
                continue
            current = {}
            yield Outcome(**told)
    finally:
        os.close(reading)
        with_end = _end(child)
    if current:
        told_end = f"the process ended: {with_end} (at most {bounds.seconds} s of CPU time are allowed)"
        yield Outcome(current["begun"], "?", False, told_end, float(bounds.seconds), 0, ended=True)


def _end(child: int) -> str:
    """Wait for a child, ending it where it has not ended; return how it did."""
    ended, status = os.waitpid(child, os.WNOHANG)
    if not ended:
        os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
        return "it did not go on"
    if os.WIFSIGNALED(status):
        return signal.Signals(os.WTERMSIG(status)).name
    return f"exit status {os.waitstatus_to_exitcode(status)}"


def _lines(reading: int, patience: float) -> Iterator[dict[str, Any]]:
    held = b""
    while True:
        ready, _, _ = select.select([reading], [], [], patience)
        part = os.read(reading, 1 << 16) if ready else b""
        if not part:
            if ready:
                # all is told: the child ends by itself, within a moment
                _brief_wait()
            return
        *whole, held = (held + part).split(b"\n")
        yield from map(json.loads, whole)


def _brief_wait() -> None:
    time.sleep(0.05)


def _work(
    attempt: Callable[[int], tuple[str, bool, str]],
    prepare: Callable[[], None],
    indices: Sequence[int],
    bounds: Bounds,
    writing: int,
    guarded: bool,
) -> None:
    def tell(told: dict[str, Any]) -> None:
        os.write(writing, json.dumps(told).encode() + b"\n")

    with tempfile.TemporaryFile() as printed:
        sys.stdout.flush()
        sys.stderr.flush()
        for descriptor in (1, 2):
            os.dup2(printed.fileno(), descriptor)
        sys.stdout, sys.stderr = os.fdopen(1, "w", closefd=False), os.fdopen(2, "w", closefd=False)
        warnings.simplefilter("error")
        # a crash is told by the parent, in one line
        faulthandler.disable()
        context = ExitStack()
        if guarded:
            context.enter_context(limited(seconds=bounds.seconds))
        else:
            # this process has limits already: no other is to read the files first
            obey(Limits(bounds.seconds, bounds.memory))
        try:
            prepare()
        except BaseException as error:
            tell({"failed": f"{type(error).__name__}: {error}"[:500]})
            return
        gc.collect()
        gc.freeze()
        for index in indices:
            tell({"begun": index})
            if not guarded:
                _limit(bounds)
            before, start = _peak_memory(anew=True), time.perf_counter()
            try:
                name, refused, broken = attempt(index)
            except BaseException as error:
                name, refused, broken = "?", False, f"{type(error).__name__}: {error}"[:500]
            seconds = time.perf_counter() - start
            # files that are let go of complain late
            gc.collect()
            memory = _peak_memory() - before
            broken = broken or _said(printed)
            tell(asdict(Outcome(index, name, refused, broken, seconds, max(0, memory))))


def _said(printed: Any) -> str:
    sys.stdout.flush()
    sys.stderr.flush()
    # the descriptor's own place moves with what is printed
    size = os.fstat(printed.fileno()).st_size
    if not size:
        return ""
    os.lseek(printed.fileno(), 0, os.SEEK_SET)
    text = os.read(printed.fileno(), 4096).decode(errors="replace")
    os.ftruncate(printed.fileno(), 0)
    os.lseek(printed.fileno(), 0, os.SEEK_SET)
    return f"it printed: {' '.join(text.split())[:600]}"


def _limit(bounds: Bounds) -> None:
    import resource

    used = resource.getrusage(resource.RUSAGE_SELF)
    _, most = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(used.ru_utime + used.ru_stime) + bounds.seconds, most))
    if Path("/proc/self/status").exists():
        # memory that is written to, not what threads reserve
        _, most = resource.getrlimit(resource.RLIMIT_DATA)
        resource.setrlimit(resource.RLIMIT_DATA, (_status("VmData") + bounds.memory, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _peak_memory(*, anew: bool = False) -> int:
    """Return the most memory held so far (bytes), or begin to count anew; 0 where the system does not tell."""
    if not Path("/proc/self/status").exists():
        return 0
    if anew:
        try:
            Path("/proc/self/clear_refs").write_text("5")
        except OSError:
            return 1 << 62
    return _status("VmHWM")


def _status(name: str) -> int:
    """Return a number of bytes that Linux tells of this process."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * int(next(line for line in lines if line.startswith(name)).split()[1])
