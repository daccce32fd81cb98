"""The helper process: forks for each file, sets limits, and tells what came of it. Started by `process`."""

from __future__ import annotations

import gc
import importlib.util
import json
import math
import os
import select
import signal
import sys
import time
import warnings
from collections.abc import Sequence
from typing import Any, NoReturn

from ppinfer.guarding.answers import told_error
from ppinfer.guarding.limits import Limits, obey
from ppinfer.guarding.tasks import TASKS, run_task

IDLE_SECONDS = 300.0
"""A helper that nobody asks anything for so long ends; the next file starts another."""
_MOST_ANSWER = 1 << 26
_PROGRESS_SECONDS = 0.1
_OPEN_FILES = 512
_LEAST_MEMORY = 1 << 26
"""With less than this a library crashes where it should say that there is no memory."""


def serve(*, forking: bool, preloaded: Sequence[str]) -> None:
    """Answer requests, a line of JSON each, until the process that asks is gone.

    Parameters
    ----------
    forking
        Whether to fork for each file; otherwise one request is answered, by this process itself.
    preloaded
        Tasks to get ready for at once.
    """
    # an interruption from the keyboard is for the process that asks; it ends this one
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    warnings.simplefilter("ignore")
    requests, answers = os.dup(0), os.dup(1)
    _silence(0, 1)
    _load_less()
    for name in preloaded:
        TASKS[name].preload()
    _say(answers, {"ready": True})
    # until here a failure to start is told there
    _silence(2)
    parent, rest = os.getppid(), b""
    while True:
        line, rest = _next_line(requests, rest, parent)
        if not line:
            return
        request = json.loads(line)
        TASKS[request["task"]].preload()
        if os.path.isdir(os.path.join(request["cwd"], request["path"])):
            # a store of this kind: nothing of it is looked at yet
            importlib.import_module("zarr")
        if not forking:
            # one process a file: whoever asks sees to the time
            os.chdir(request["cwd"])
            _say(answers, {"answer": _answer(request, answers)})
            return
        # what is there is shared with the fork as long as nobody touches it
        gc.freeze()
        if not _answered_by_child(request, requests, answers):
            return


def _load_less() -> None:
    """Leave out what reads nothing: a command waits for this process to be ready."""
    # xarray would load it, for arrays that are put off; readers put off nothing
    sys.modules.setdefault("dask", None)  # type: ignore[arg-type]
    # readers name the modules that they need; the package itself loads all that is computed over whole studies as well
    found = importlib.util.find_spec("ppinfer.studies")
    if found is not None and found.name not in sys.modules:
        package = importlib.util.module_from_spec(found)
        sys.modules[found.name] = package


def _next_line(requests: int, rest: bytes, parent: int) -> tuple[bytes, bytes]:
    until = time.monotonic() + IDLE_SECONDS
    while b"\n" not in rest:
        if os.name == "posix":
            # now and then: a copy of the pipe in some other process must not keep this one alive
            ready, _, _ = select.select([requests], [], [], 5.0)
            if not ready:
                if os.getppid() != parent or time.monotonic() > until:
                    return b"", b""
                continue
        more = os.read(requests, 1 << 16)
        if not more:
            return b"", b""
        rest += more
    line, _, rest = rest.partition(b"\n")
    return line, rest


def _answered_by_child(request: dict[str, Any], requests: int, answers: int) -> bool:
    """Return whether there is still somebody to answer to."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(read)
        os.close(requests)
        os.close(answers)
        _be_child(request, write)
    os.close(write)
    deadline = time.monotonic() + request["seconds"]
    received, total, answer = b"", 0, b""
    over: dict[str, Any] | None = None
    waited_for = True
    while over is None and waited_for:
        ready, _, _ = select.select([read, requests], [], [], max(0.0, deadline - time.monotonic()))
        if not ready:
            over = {"limit": "seconds"}
        elif read in ready:
            more = os.read(read, 1 << 16)
            if not more:
                break
            total += len(more)
            if total > _MOST_ANSWER:
                over = {"died": "it told more than can be wrong with any file"}
            *lines, received = (received + more).split(b"\n")
            for line in lines:
                if line.startswith(b"P"):
                    _send(answers, b'{"progress": ' + line[1:] + b"}\n")
                else:
                    answer = line
        else:
            # nothing is asked while a file is read: whoever asked is gone
            waited_for = False
    os.close(read)
    if over is not None or not waited_for:
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    if not waited_for:
        return False
    if over is None and status == 0 and answer.startswith(b"A"):
        _send(answers, b'{"answer": ' + answer[1:] + b"}\n")
    else:
        _say(answers, over or _died(status))
    return True


def _died(status: int) -> dict[str, Any]:
    if not os.WIFSIGNALED(status):
        return {"died": f"exit status {os.waitstatus_to_exitcode(status)}"}
    number = os.WTERMSIG(status)
    if number in (signal.SIGXCPU, signal.SIGALRM):
        return {"limit": "seconds"}
    if number == signal.SIGKILL:
        # not by us: the system kills what takes too much
        return {"limit": "memory"}
    return {"died": signal.Signals(number).name}


def _be_child(request: dict[str, Any], write: int) -> NoReturn:
    status = 1
    gc.disable()
    try:
        os.chdir(request["cwd"])
        _limit(request)
        _send(write, b"A" + json.dumps(_answer(request, write), default=_plain).encode() + b"\n")
        status = 0
    except MemoryError:
        # nothing is left to tell it with but the status
        os.kill(os.getpid(), signal.SIGKILL)
    finally:
        os._exit(status)


def _answer(request: dict[str, Any], progress: int) -> dict[str, Any]:
    limits = Limits(request["seconds"], request["memory"])
    last = 0.0

    def tell(done: int, total: int, /) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= _PROGRESS_SECONDS:
            last = now
            _send(
                progress,
                (b"P[%d, %d]\n" if request["forking"] else b'{"progress": [%d, %d]}\n') % (done, total),
            )

    obey(limits)
    try:
        return {"result": run_task(request["task"], request["path"], limits, request["told"], tell)}
    except MemoryError:
        return {"limit": "memory"}
    except RecursionError:
        return {"unexpected": "it is nested too deeply"}
    except Exception as error:
        return told_error(error)


def _limit(request: dict[str, Any]) -> None:
    try:
        import resource
    except ImportError:
        return
    seconds = math.ceil(request["seconds"])
    limits = {
        "RLIMIT_CPU": seconds + 1,
        # nothing is written, and no memory is left behind by a crash
        "RLIMIT_FSIZE": 0,
        "RLIMIT_CORE": 0,
        "RLIMIT_NOFILE": _OPEN_FILES,
    }
    if sys.platform == "linux":
        with open("/proc/self/statm") as file:
            pages = int(file.read().split()[0])
        limits["RLIMIT_AS"] = pages * resource.getpagesize() + max(request["memory"], _LEAST_MEMORY)
    for name, most in limits.items():
        which = getattr(resource, name)
        _, hard = resource.getrlimit(which)
        # a limit that the system set lower stays
        most = min(most, 2**62) if hard == resource.RLIM_INFINITY else min(most, hard)
        try:
            resource.setrlimit(which, (most, most))
        except (OSError, ValueError):
            continue
    # where this process has lost its parent, it ends by itself
    signal.alarm(seconds + 5)


def _plain(value: Any) -> Any:
    # sizes and indices of NumPy
    return value.item()


def _silence(*descriptors: int) -> None:
    null = os.open(os.devnull, os.O_RDWR)
    for descriptor in descriptors:
        os.dup2(null, descriptor)
    os.close(null)


def _say(to: int, told: dict[str, Any]) -> None:
    _send(to, json.dumps(told, default=_plain).encode() + b"\n")


def _send(to: int, content: bytes) -> None:
    while content:
        content = content[os.write(to, content) :]
