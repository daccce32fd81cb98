"""Who is meant by a name on the command line: one of ours, or one's own by ``module:attribute``."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Collection, Sequence
from typing import Any, TypeVar

from ppsim.errors import SimulationError

T = TypeVar("T")


def checked_names(what: str, names: Sequence[str], known: Collection[str], *, own: bool = False) -> None:
    """Raise a SimulationError unless there are names, each known (or ``module:attribute``) and given once.

    Examples
    --------
    >>> checked_names("robots", ["naive", "mine:Robot"], ["naive"], own=True)
    """
    if not names:
        raise SimulationError(f"no {what} are named; there are {', '.join(known)}")
    for name in names:
        if name not in known and not (own and ":" in name):
            hint = ", or module:attribute of your own" if own else ""
            raise SimulationError(f"there are no {what} {name!r}; there are {', '.join(known)}{hint}")
        if list(names).count(name) > 1:
            raise SimulationError(f"{what}: {name!r} is named twice")


def made_by_name(name: str, kind: type[T], *, what: str) -> T:
    """Return what ``module:attribute`` names: an instance of `kind`, or what makes one when it is called.

    The module is looked for in the working directory too.

    Parameters
    ----------
    name : str
        ``module:attribute``.
    kind : type
        What it has to be.
    what : str
        What errors call it.

    Raises
    ------
    SimulationError
        Where it cannot be imported or made, or is something else.

    Examples
    --------
    >>> from fractions import Fraction
    >>> made_by_name("fractions:Fraction", Fraction, what="share")
    Fraction(0, 1)
    """
    module_name, _, attribute = name.partition(":")
    here = os.getcwd()
    if here not in sys.path:
        sys.path.insert(0, here)
    try:
        found: Any = importlib.import_module(module_name)
        for part in attribute.split("."):
            found = getattr(found, part)
    except (ImportError, AttributeError, ValueError, SyntaxError) as error:
        raise SimulationError(f"{what} {name!r} cannot be imported: {error}") from error
    try:
        made = found() if callable(found) and not isinstance(found, kind) else found
    except TypeError as error:
        raise SimulationError(
            f"{what} {name!r} cannot be made by calling it without arguments: {error}"
        ) from error
    if not isinstance(made, kind):
        where = kind.__module__
        public = ".".join(where.split(".")[:2]) if where.startswith("ppinfer.") else where
        raise SimulationError(
            f"{what} {name!r} is a {type(made).__name__}; expected a {public}.{kind.__name__}, or what makes one"
        )
    return made
