"""Before a file from elsewhere is opened here, the helper process reads it to its end."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ppinfer.errors import LogError, PPInferError
from ppinfer.guarding.answers import error_told
from ppinfer.guarding.fingerprints import REMEMBERED, Fingerprint, fingerprint, was_written
from ppinfer.guarding.inputs import refuse_special
from ppinfer.guarding.limits import Limits, how_to_allow_more, is_guarding, limits_for, told_bytes, trusting
from ppinfer.guarding.process import HelperError, ask_helper, start_helper

_TRIES = 3


def _silent(done: int, total: int, /) -> None:
    pass


@contextmanager
def admitted(
    task: str,
    path: str | os.PathLike[str],
    *,
    error: type[PPInferError] = LogError,
    beside: tuple[Path, ...] = (),
    progress: Callable[[int, int], None] = _silent,
    **told: Any,
) -> Iterator[dict[str, Any]]:
    """Have a file read by the helper process; within the block it may be opened here, and must stay as it was.

    Nothing is asked for a file that this process wrote, that it asked for before, or that is not there; nor within
    `trusting`, nor within another such block.

    Parameters
    ----------
    task
        What reads the file, a name of `ppinfer.guarding.tasks.TASKS`.
    path
        The file or folder.
    error
        The class of what is raised where a limit was reached, or the reader crashed.
    beside
        Other files that the task will read: their sizes count.
    progress
        Told how far the reading is.
    **told
        What else the task needs, as JSON can hold it.

    Yields
    ------
    dict
        What the task returned; empty if nothing was asked.

    Raises
    ------
    PPInferError
        What the reader raised, or of the class ``error`` where a limit was reached, the reader crashed, or the file
        was changed meanwhile.

    Examples
    --------
    >>> with admitted("log", "nowhere.nc") as known:
    ...     known
    {}
    """
    source = Path(path)
    refuse_special(source, error)
    state = _state(source, error) if is_guarding() else None
    if state is None:
        yield {}
        return
    known: dict[str, Any] = {}
    if not was_written(source, state):
        key = f"{task} {sorted(told.items())}" if told else task
        found = REMEMBERED.recall(key, source, state)
        if found is None:
            found, state = _asked(task, source, state, error, beside, progress, told)
            REMEMBERED.remember(key, source, state, found)
        known = found
    with trusting():
        yield known
    if _state(source, error) != state:
        raise error(f"{source}: was changed while it was being read; try again once nobody writes to it")


def asked(
    task: str,
    path: str | os.PathLike[str],
    *,
    error: type[PPInferError] = LogError,
    progress: Callable[[int, int], None] = _silent,
    **told: Any,
) -> Any | None:
    """Have the helper process answer a question about a file, and never open it here.

    Returns
    -------
    object or None
        What the task returned; None where the caller is to find out by itself, since nothing is guarded against.

    Examples
    --------
    >>> asked("validate-log", "nowhere.nc") is None
    True
    """
    source = Path(path)
    refuse_special(source, error)
    state = _state(source, error) if is_guarding() else None
    if state is None or was_written(source, state):
        return None
    return _asked(task, source, state, error, (), progress, told)[0]


def start_early(*paths: object) -> None:
    """Start the helper process if any of these is a file that it will be asked for, and do not wait for it.

    Examples
    --------
    >>> start_early("nowhere.nc", None, 3)
    """
    for path in paths:
        if not isinstance(path, str | os.PathLike) or not is_guarding():
            continue
        source = Path(path)
        state = None if source.is_dir() else _state(source, LogError)
        if source.is_dir() or (state is not None and not was_written(source, state)):
            start_helper()
            return


def _state(source: Path, error: type[PPInferError]) -> Fingerprint | None:
    try:
        return fingerprint(source, error)
    except (OSError, ValueError):
        # it is not there, or not to be looked at: whoever opens it says so
        return None


def _asked(
    task: str,
    source: Path,
    state: Fingerprint,
    error: type[PPInferError],
    beside: tuple[Path, ...],
    progress: Callable[[int, int], None],
    told: dict[str, Any],
) -> tuple[Any, Fingerprint]:
    for _ in range(_TRIES):
        others = [_state(other, error) for other in beside]
        limits = limits_for(state.size + sum(other.size for other in others if other is not None))
        request = {
            "task": task,
            "path": str(source),
            "cwd": _folder(),
            "seconds": limits.seconds,
            "memory": limits.memory,
            "told": told,
        }
        try:
            answer = ask_helper(request, progress)
        except HelperError as failure:
            raise error(
                f"{source}: is not opened: the process that reads files under limits cannot be started ({failure}); "
                "if you trust the file, set PPINFER_GUARD=off"
            ) from failure
        now = _state(source, error)
        if now == state:
            result = _result(answer, source, limits, error)
            if isinstance(result, dict):
                # what was read to its end for one question need not be for another
                for other_task, known in result.get("admits", {}).items():
                    REMEMBERED.remember(other_task, source, state, known)
            return result, state
        # something is being written, e.g. a recording of a study that runs
        if now is None:
            break
        state = now
    raise error(f"{source}: was changed while it was being read; try again once nobody writes to it")


def _folder() -> str:
    try:
        return os.getcwd()
    except OSError:
        # it was removed: a whole path can be opened all the same
        return os.path.abspath(os.sep)


def _result(answer: dict[str, Any], source: Path, limits: Limits, error: type[PPInferError]) -> Any:
    told = answer.get("answer", answer)
    if "result" in told:
        return told["result"]
    if told.get("limit") == "seconds":
        raise error(
            f"{source}: reading it takes more than {limits.seconds:.3g} s, the limit for a file of its size: "
            + how_to_allow_more("SECONDS", f"{10 * limits.seconds:.0f}")
        )
    if told.get("limit") == "memory":
        raise error(
            f"{source}: reading it takes more than {told_bytes(limits.memory)} of memory, the limit for a file of its "
            "size: " + how_to_allow_more("MEMORY", f"{max(1, 10 * limits.memory >> 30)}G")
        )
    if "died" in told:
        raise error(
            f"{source}: cannot be read: it crashed the library that reads it ({told['died']}): the file is damaged, or "
            "made to do harm; get it again from its source"
        )
    if "unexpected" in told:
        raise error(
            f"{source}: cannot be read: {told['unexpected']}; the file is damaged, or not what its name says: get it "
            "again from its source"
        )
    raise error_told(told)
