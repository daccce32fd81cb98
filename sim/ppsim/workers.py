"""Work shared among processes, with results in order: whoever did what, the outcome is the same."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar

from ppsim.errors import SimulationError

Made = TypeVar("Made")
# batches that a worker may be ahead of what has been taken, so that memory does not grow with what is left
_AHEAD = 4


def in_order(make: Callable[[int], Made], indices: Sequence[int], *, workers: int = 1) -> Iterator[Made]:
    """Yield what a function makes of every index, in order; with several workers in processes of their own.

    Only so much is made ahead of what was taken, so that results of any number need little memory.

    Raises
    ------
    SimulationError
        Where there are no workers.

    Examples
    --------
    >>> list(in_order(abs, [-1, 2]))
    [1, 2]
    """
    if workers < 1:
        raise SimulationError(f"workers must be at least 1; got {workers}")
    if workers == 1 or len(indices) < 2:
        yield from map(make, indices)
        return
    # fresh processes: a forked one may inherit locks that a thread held
    context = multiprocessing.get_context("spawn")
    count = min(workers, len(indices))
    pool = ProcessPoolExecutor(count, mp_context=context, initializer=follow_the_parent)
    try:
        left = iter(indices)
        waiting = [pool.submit(make, index) for _, index in zip(range(_AHEAD * count), left, strict=False)]
        while waiting:
            yield waiting.pop(0).result()
            waiting += [pool.submit(make, index) for _, index in zip(range(1), left, strict=False)]
    finally:
        pool.shutdown(cancel_futures=True)


def follow_the_parent() -> None:
    """Begin a worker process that leaves Ctrl-C to its parent and ends with it."""
    # Ctrl-C reaches every process of the terminal; a worker's traceback would tell nothing
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # a parent that is killed tells its workers nothing: they would wait for ever
    threading.Thread(target=_end_with_the_parent, daemon=True).start()


def _end_with_the_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
