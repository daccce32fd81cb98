"""The one helper process of this process: started when first needed, asked one file at a time, gone with us."""

from __future__ import annotations

import atexit
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

FORKING = hasattr(os, "fork")
PRELOADED: tuple[str, ...] = ("log",)
"""Tasks that the helper is ready for as soon as it has started."""
_GRACE_SECONDS = 20.0
"""What a helper is given beyond a file's own time, to start and to load what reads it."""
_START_SECONDS = 120.0
_START = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from ppinfer.guarding.server import serve; serve(**json.loads(sys.argv[2]))"
)
_HOME = str(Path(__file__).absolute().parents[2])
_ENVIRONMENT = {
    # one thread: a process with more cannot be forked safely
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    # memory that is set aside in advance would count against a file
    "MALLOC_ARENA_MAX": "2",
    "ARROW_DEFAULT_MEMORY_POOL": "system",
    "JE_ARROW_MALLOC_CONF": "background_thread:false",
    # HDF5 loads no code that a file asks for
    "HDF5_PLUGIN_PRELOAD": "::",
}


class HelperError(Exception):
    """The helper process could not be started, or is gone."""


class _Helper:
    def __init__(self, *, forking: bool) -> None:
        self.forking = forking
        # -P, and no empty entry: nothing is imported from the folder that somebody happens to be in
        path = [entry for entry in sys.path if isinstance(entry, str) and entry not in ("", ".")]
        if _HOME not in path:
            path.append(_HOME)
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        how = {"forking": forking, "preloaded": PRELOADED}
        command = [sys.executable, "-P", "-c", _START, json.dumps(path), json.dumps(how)]
        try:
            self.process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                # no buffers: a fork of this process must be able to let go of the pipes, whoever is using them
                bufsize=0,
                env=environment | _ENVIRONMENT,
            )
        except (OSError, TypeError) as error:
            raise HelperError(str(error)) from error
        self.ready = False
        self._received = b""

    def ask(self, request: dict[str, Any], progress: Callable[[int, int], None]) -> dict[str, Any]:
        assert self.process.stdin is not None
        if not self.ready:
            self._await_start()
        seconds = request["seconds"] + _GRACE_SECONDS
        late = threading.Event()

        def give_up() -> None:
            late.set()
            self.process.kill()

        timer = threading.Timer(seconds, give_up)
        timer.daemon = True
        timer.start()
        try:
            line = json.dumps(request | {"forking": self.forking}).encode() + b"\n"
            while line:
                line = line[os.write(self.process.stdin.fileno(), line) :]
            while True:
                told = self._told()
                if told is None:
                    if late.is_set():
                        return {"limit": "seconds"}
                    raise HelperError("it ended without an answer")
                if "progress" not in told:
                    return told
                progress(*told["progress"])
        except OSError as error:
            raise HelperError(str(error)) from error
        finally:
            timer.cancel()

    def _await_start(self) -> None:
        timer = threading.Timer(_START_SECONDS, self.process.kill)
        timer.daemon = True
        timer.start()
        try:
            self.ready = self._told() is not None
        finally:
            timer.cancel()
        if not self.ready:
            assert self.process.stderr is not None
            lines = self.process.stderr.read().decode(errors="replace").strip().splitlines()
            raise HelperError(lines[-1] if lines else "it ended at once")

    def _told(self) -> dict[str, Any] | None:
        assert self.process.stdout is not None
        while b"\n" not in self._received:
            more = self.process.stdout.read(1 << 16)
            if not more:
                return None
            self._received += more
        line, _, self._received = self._received.partition(b"\n")
        told: dict[str, Any] = json.loads(line)
        return told

    def end(self, *, at_once: bool = True) -> None:
        if at_once:
            self.process.kill()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
        try:
            self.process.wait(timeout=1.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def forget(self) -> None:
        """In a forked copy of this process: the helper is the original's."""
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
        # it is not a child of this process, which must neither wait for it nor complain of it
        self.process.returncode = 0


_lock = threading.Lock()
_helper: _Helper | None = None


def ask_helper(request: dict[str, Any], progress: Callable[[int, int], None]) -> dict[str, Any]:
    """Ask for one file; a helper that is gone is replaced once.

    Raises
    ------
    HelperError
        If no helper can be started, or it ends twice without an answer.
    """
    global _helper
    with _lock:
        for attempt in (1, 2):
            fresh = _helper is None
            if _helper is None:
                _helper = _Helper(forking=FORKING)
            try:
                told = _helper.ask(request, progress)
            except HelperError:
                _renew(None)
                # one that has idled for long may be going just now
                if fresh or attempt == 2:
                    raise
            except BaseException:
                # an interruption: the answer would be taken for that of the next file
                _renew(None)
                raise
            else:
                if _helper.process.poll() is not None or not FORKING:
                    _renew(None)
                return told
    raise AssertionError


def start_helper() -> None:
    """Start the helper, if there is none yet, without waiting until it is ready."""
    global _helper
    with _lock, suppress(HelperError):
        if _helper is None and FORKING:
            _helper = _Helper(forking=True)


def end_helper() -> None:
    """End the helper, if there is one."""
    with _lock:
        _renew(None)


def _renew(other: _Helper | None) -> None:
    global _helper
    if _helper is not None:
        _helper.end()
    _helper = other


def _forget() -> None:
    global _helper, _lock
    _lock = threading.Lock()
    if _helper is not None:
        _helper.forget()
        _helper = None


atexit.register(end_helper)
if FORKING:
    os.register_at_fork(after_in_child=_forget)
