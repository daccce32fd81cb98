"""Whom an equilibrium favours."""

from __future__ import annotations

from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

FavourBy = Literal["cost", "loss"]
"""Whether whom an equilibrium favours is a matter of what it costs each, or of what each loses by it."""

TIE = 1e-9
"""Seconds within which costs are the same but for rounding."""

FAIR = "fair"
"""Label of the class of equilibria that favour nobody by more than a few seconds."""


def favoured_classes(
    costs: Float[np.ndarray, "player ..."],
    among: Bool[np.ndarray, "..."],
    *,
    ties: bool = True,
    fair_within: float | None = None,
    favour_by: FavourBy = "cost",
) -> Bool[np.ndarray, "theta ..."]:
    """Return which profiles favour whom.

    A profile favours agent i where c_i(a) <= c_j(a) for all j; by loss, where what it costs i more than the best
    equilibrium for i is no more than that is for any other. With `fair_within`, those whose costs all lie that
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
    favour_by : {"cost", "loss"}
        By cost, an agent with a short way is favoured by every equilibrium, so that one with a long way cannot show
        what it is like. By loss, each agent is favoured by its own best equilibrium, wherever there is a choice.

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
    >>> game = np.array([[[2.0, 4.0]], [[7.0, 5.0]]])
    >>> favoured_classes(game, np.ones((1, 2), bool), favour_by="loss").tolist()
    [[[True, False]], [[False, True]]]
    """
    if favour_by == "loss":
        costs = _losses(costs, among)
    # differences of durations: what is as much but for rounding is as much
    cheapest = costs <= costs.min(axis=0) + TIE
    if not ties:
        cheapest &= cheapest.sum(axis=0) == 1
    classes: np.ndarray = cheapest & among
    if fair_within is None:
        return classes
    # infinite costs occur only where nothing is an equilibrium
    finite = np.where(among, costs, 0.0)
    fair = among & (finite.max(axis=0) - finite.min(axis=0) <= fair_within)
    return np.concatenate([classes & ~fair, fair[None]])


def _losses(
    costs: Float[np.ndarray, "player ..."], among: Bool[np.ndarray, "..."]
) -> Float[np.ndarray, "player ..."]:
    """Return how much more than in its best equilibrium each agent pays, s; inf where there is no equilibrium."""
    # a plan axis for every player, the last ones; what is before them are copies
    grid = tuple(range(costs.ndim - len(costs), costs.ndim))
    paid = np.where(among, costs, np.inf)
    best = paid.min(axis=grid, keepdims=True)
    return paid - np.where(np.isfinite(best), best, 0.0)
