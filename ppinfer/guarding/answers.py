"""Errors as JSON and back: what is raised in the helper process is raised here, as the same error."""

from __future__ import annotations

import importlib
import re
from dataclasses import asdict
from typing import Any

import ppinfer.errors
from ppinfer.errors import PPInferError

# what libraries in C say of it
_NO_MEMORY = re.compile(
    r"memory allocation failed|out of memory|(can't|cannot|unable to) allocate", re.IGNORECASE
)
_FAULTS = "ppinfer.studies.faults"


def told_error(error: Exception) -> dict[str, Any]:
    """Return what another process needs to raise the error again.

    Examples
    --------
    >>> from ppinfer.errors import LogError
    >>> told_error(LogError("log.nc: the file is empty"))
    {'class': 'LogError', 'message': 'log.nc: the file is empty'}
    """
    if _is_memory(error):
        return {"limit": "memory"}
    if type(error).__name__ == "FaultyLogError":
        faulty: Any = error
        return {
            "class": "FaultyLogError",
            "source": faulty.source,
            "faults": {"listed": [asdict(fault) for fault in faulty.faults], "counts": faulty.counts},
        }
    if isinstance(error, PPInferError):
        return {"class": type(error).__name__, "message": str(error)}
    if isinstance(error, OSError) and error.errno:
        return {"os": [error.errno, error.strerror, None if error.filename is None else str(error.filename)]}
    text = " ".join(str(error).split())[:300]
    return {"unexpected": f"{type(error).__name__}: {text}" if text else type(error).__name__}


def error_told(told: dict[str, Any]) -> Exception:
    """Return the error that another process told, as this process would have raised it.

    Examples
    --------
    >>> error_told({"class": "LogError", "message": "log.nc: the file is empty"})
    LogError('log.nc: the file is empty')
    """
    if "os" in told:
        number, text, name = told["os"]
        return OSError(number, text, name) if name is not None else OSError(number, text)
    if told["class"] == "FaultyLogError":
        # by name: what is known of logs lies above this package
        faults: Any = importlib.import_module(_FAULTS)
        error: Exception = faults.FaultyLogError(told["source"], faults.Faults.from_json(told["faults"]))
        return error
    kind = getattr(ppinfer.errors, told["class"], PPInferError)
    known: Exception = kind(told["message"])
    return known


def _is_memory(error: BaseException | None) -> bool:
    # readers turn whatever goes wrong into errors of their own, which name what they came from
    while error is not None:
        if isinstance(error, MemoryError) or _NO_MEMORY.search(str(error)):
            return True
        error = error.__cause__
    return False
