"""Runs that are killed: in a child at an exact point, or as a whole command at any time."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

CHANGES = ("os.rename", "os.remove", "os.mkdir", "os.rmdir", "shutil.rmtree")


def killed(
    run: Callable[[], Any], folder: Path, event: str, number: int, *, torn: bool = False, of: str = ""
) -> bool:
    """Run something in a child that dies at the nth event of a kind on a path in a folder; tell whether it died.

    Events are ``fsync`` (where `torn`, what was written last is cut off in the middle first), ``write`` (a file is
    opened to be written) and those of `CHANGES`, before they happen; only those on a path that ends with `of` count.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        status = 1
        try:
            _die_at(event, number, str(folder), of, torn)
            nothing = os.open(os.devnull, os.O_WRONLY)
            for descriptor in (1, 2):
                os.dup2(nothing, descriptor)
            run()
            status = 0
        finally:
            os._exit(status)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        assert os.WTERMSIG(status) == signal.SIGKILL
        return True
    assert os.waitstatus_to_exitcode(status) == 0, "the run failed by itself"
    return False


def _die_at(event: str, number: int, folder: str, of: str, torn: bool) -> None:
    left = number

    def count(descriptor: int | None = None) -> None:
        nonlocal left
        left -= 1
        if left == 0:
            if torn and descriptor is not None:
                os.ftruncate(descriptor, max(0, os.fstat(descriptor).st_size - 20))
            os.kill(os.getpid(), signal.SIGKILL)

    def hook(name: str, told: tuple[Any, ...]) -> None:
        if name in ("open", event) and not str(told[0]).endswith(of):
            return
        if name == "open" and event == "write":
            path, mode, flags = told
            writes = set(mode or "") & set("wxa+") or (flags or 0) & (os.O_WRONLY | os.O_RDWR)
            if writes and str(path).startswith(folder):
                count()
        elif name == event and str(told[0]).startswith(folder):
            count()

    sys.addaudithook(hook)
    if event == "fsync":
        real = os.fsync

        def fsync(descriptor: int) -> None:
            count(descriptor)
            real(descriptor)

        os.fsync = fsync  # type: ignore[assignment]


def kill_at_any_time(
    argv: Sequence[str], seconds: float, rng: np.random.Generator, *, once: Callable[[], bool] = lambda: True
) -> bool:
    """Start a command, kill it within some seconds after `once` holds; tell whether it was still running."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    with subprocess.Popen(
        argv, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=environment, start_new_session=True
    ) as process:
        while process.poll() is None and not once():
            time.sleep(0.002)
        try:
            process.wait(rng.uniform(0, seconds))
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            return True
        assert process.stderr is not None
        assert process.returncode == 0, process.stderr.read().decode()
        return False
