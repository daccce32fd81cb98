"""Who can sit at the table: policies by name, and policies of one's own by ``module:attribute``."""

from __future__ import annotations

from ppinfer.coordination import POLICIES, BayesNash, MinNorm, Policy
from ppsim.arms.careful import Careful
from ppsim.naming import checked_names, made_by_name

#: Policies that check, before they execute a plan, how probable it is to stay clear: which policy each asks first.
CAREFUL = {"bayes-clear": "bayes", "bayes-risk-clear": "bayes-risk"}
ROBOTS = (*POLICIES, *CAREFUL)
#: The simulated humans are the first three of the paper's robots.
HUMANS = ("defensive", "selfish", "norm")


__all__ = ["HUMANS", "ROBOTS", "checked_names", "make_human", "make_robot"]


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
        Of the norm within "bayes" and "bayes-clear", s.
    """
    if name in CAREFUL:
        return Careful(make_robot(CAREFUL[name], human, cost_unit=cost_unit))
    if name == "oracle":
        return POLICIES[name](other=human)
    if name == "bayes":
        return BayesNash(norm=MinNorm(cost_unit=cost_unit))
    return POLICIES[name]() if name in POLICIES else _own(name)


def _own(name: str) -> Policy:
    # a policy may be anything that has what the class of policies asks for
    return made_by_name(name, Policy, what="policy")  # type: ignore[type-abstract]
