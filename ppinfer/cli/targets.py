"""Where a command may write: under a name of the right kind, and never over what it reads."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ppinfer.errors import LogError


def check_output(output: str, *, suffix: str, inputs: Sequence[str]) -> None:
    """Refuse an output of another kind, in no folder, or that is also an input, before any work is done.

    Raises
    ------
    LogError
        Naming the output and what was expected.

    Examples
    --------
    >>> check_output("posterior.nc", suffix=".nc", inputs=["log.nc"])
    """
    target = Path(output)
    if target.suffix != suffix:
        raise LogError(f"{output}: the output is a {suffix} file; give it a name that ends so")
    if not target.parent.is_dir():
        raise LogError(f"{output}: there is no folder {str(target.parent)!r}; make it first")
    if target.is_dir():
        raise LogError(f"{output}: is a folder; give the {suffix} file a name of its own")
    for name in inputs:
        if target.exists() and Path(name).exists() and target.samefile(name):
            raise LogError(f"{output}: is both read and written; give the output another name")
