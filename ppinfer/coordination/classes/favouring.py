"""Whom an equilibrium favours."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

FAIR = "fair"
"""Label of the class of equilibria that favour nobody by more than a few seconds."""


def favoured_classes(
    costs: Float[np.ndarray, "player ..."],
    among: Bool[np.ndarray, "..."],
    *,
    ties: bool = True,
    fair_within: float | None = None,
) -> Bool[np.ndarray, "theta ..."]:
    """Return which profiles favour whom.

    A profile favours agent i where c_i(a) <= c_j(a) for all j. With `fair_within`, those whose costs all lie that
    close to each other are a class of their own, the last, and favour nobody.

    Parameters
    ----------
    costs : (player, ...) float64
        Seconds, players first.
    among : (...) bool
        The equilibria; nothing else belongs to a class.
    ties : bool
        Whether a profile that costs several agents the same (least) belongs to the class of each; if not, to none.
    fair_within : float, optional
        Seconds.

    Examples
    --------
    >>> costs = np.array([[2.0, 4.0, 3.0], [5.0, 3.0, 3.0]])
    >>> favoured_classes(costs, np.ones(3, bool))
    array([[ True, False,  True],
           [False,  True,  True]])
    >>> favoured_classes(costs, np.ones(3, bool), fair_within=1.0)
    array([[ True, False, False],
           [False, False, False],
           [False,  True,  True]])
    """
    cheapest = costs == costs.min(axis=0)
    if not ties:
        cheapest &= cheapest.sum(axis=0) == 1
    classes: np.ndarray = cheapest & among
    if fair_within is None:
        return classes
    # infinite costs occur only where nothing is an equilibrium
    finite = np.where(among, costs, 0.0)
    fair = among & (finite.max(axis=0) - finite.min(axis=0) <= fair_within)
    return np.concatenate([classes & ~fair, fair[None]])
