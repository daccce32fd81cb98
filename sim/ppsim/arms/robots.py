"""Who can sit at the table: policies by name, and policies of one's own by ``module:attribute``."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Collection, Sequence
from typing import Any

from ppinfer.coordination import POLICIES, BayesNash, MinNorm, Policy
from ppsim.errors import SimulationError

ROBOTS = tuple(POLICIES)
#: The simulated humans are the first three of the paper's robots.
HUMANS = ("defensive", "selfish", "norm")


def checked_names(what: str, names: Sequence[str], known: Collection[str], *, own: bool = False) -> None:
    """Raise a SimulationError unless there are names, each known (or ``module:attribute``) and given once."""
    if not names:
        raise SimulationError(f"no {what} are named; there are {', '.join(known)}")
    for name in names:
        if name not in known and not (own and ":" in name):
            hint = ", or module:attribute of your own" if own else ""
            raise SimulationError(f"there are no {what} {name!r}; there are {', '.join(known)}{hint}")
        if list(names).count(name) > 1:
            raise SimulationError(f"{what}: {name!r} is named twice")


def make_human(name: str) -> Policy:
    """Return the policy of a simulated human."""
    return POLICIES[name]() if name in HUMANS else _own(name)


def make_robot(name: str, human: Policy, *, cost_unit: float = 100.0) -> Policy:
    """Return a robot's policy.

    Parameters
    ----------
    name : str
        One of `ROBOTS`, or ``module:attribute``: a Policy, or something that makes one when it is called.
    human : Policy
        Who sits opposite; the oracle is told what it would choose.
    cost_unit : float
        Of the norm within "bayes", s.
    """
    if name == "oracle":
        return POLICIES[name](other=human)
    if name == "bayes":
        return BayesNash(norm=MinNorm(cost_unit=cost_unit))
    return POLICIES[name]() if name in POLICIES else _own(name)


def _own(name: str) -> Policy:
    module_name, _, attribute = name.partition(":")
    here = os.getcwd()
    if here not in sys.path:
        sys.path.insert(0, here)
    try:
        found: Any = importlib.import_module(module_name)
        for part in attribute.split("."):
            found = getattr(found, part)
    except (ImportError, AttributeError, ValueError, SyntaxError) as error:
        raise SimulationError(f"policy {name!r} cannot be imported: {error}") from error
    try:
        made = found() if callable(found) and not isinstance(found, Policy) else found
    except TypeError as error:
        raise SimulationError(
            f"policy {name!r} cannot be made by calling it without arguments: {error}"
        ) from error
    if not isinstance(made, Policy):
        raise SimulationError(
            f"policy {name!r} is a {type(made).__name__}; expected a ppinfer.coordination.Policy, or what makes one"
        )
    return made
