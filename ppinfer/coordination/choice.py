"""From a distribution over profiles to a plan: which of several best ones, and what to do when there is none."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from jaxtyping import Float

from ppinfer.coordination.policy import Decision
from ppinfer.coordination.situation import Situation
from ppinfer.distributions import Distribution

TIE = 1e-9
"""Costs (s) and log probabilities that differ by less are the same but for rounding."""


def best_profile(
    log_values: Float[np.ndarray, "..."], own_cost: Float[np.ndarray, "..."], player: int
) -> tuple[int, ...]:
    """Return the profile with the largest value.

    Ties go to the lowest cost of the player's own, then to its lowest plan, then to the others' lowest plans.

    Examples
    --------
    >>> best_profile(np.array([[0.0, -1.0], [0.0, 0.0]]), np.array([[2.0, 0.0], [1.0, 1.0]]), 0)
    (1, 0)
    """
    best = log_values >= log_values.max() - TIE
    if np.count_nonzero(best) == 1:
        return tuple(int(place) for place in np.unravel_index(int(best.argmax()), best.shape))
    own = np.where(best, own_cost, math.inf)
    best = own <= own.min() + TIE
    order = (player, *(other for other in range(best.ndim) if other != player))
    turned = best.transpose(order)
    place = np.unravel_index(int(turned.argmax()), turned.shape)
    profile = dict(zip(order, place, strict=True))
    return tuple(int(profile[axis]) for axis in range(best.ndim))


def decide_by(situation: Situation, distribution: Distribution, player: int, **learned: Any) -> Decision:
    """Return the decision for the player's part of the most probable profile."""
    profile = best_profile(distribution.log_values, situation.game.costs[player], player)
    return Decision(profile[player], distribution, profile, **learned)


def hold(situation: Situation, player: int, **learned: Any) -> Decision:
    """Return the decision not to move, for when no profile is left to choose; its distribution is a point mass.

    An agent without a static plan takes the plan that collides in the fewest profiles.
    """
    own = situation.plans[player]
    plan = own.static
    if plan is None:
        plan = int(collisions(situation, player).argmin())
    point = np.full(len(own), -math.inf)
    point[plan] = 0.0
    return Decision(plan, Distribution([own.axis], point), **learned)


def collisions(situation: Situation, player: int) -> Float[np.ndarray, " plan"]:
    """Return in how many profiles each of the player's plans collides."""
    cost = np.moveaxis(situation.game.costs[player], player, 0)
    count: np.ndarray = np.isinf(cost).reshape(len(cost), -1).sum(axis=1).astype(np.float64)
    return count
