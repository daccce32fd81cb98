"""Mixed strategies: which games allow of them, what they cost, and the distribution over profiles that they make."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

from ppinfer.distributions import Axis, Distribution
from ppinfer.distributions.axis import first_cell
from ppinfer.errors import GameError
from ppinfer.games.game import Game


def finite_costs(game: Game, infinite_as: float | None = None) -> Float[np.ndarray, "..."]:
    """Return the costs of a game in which every plan may be played; infinite ones replaced where that is asked for.

    Under a mixed strategy every profile has a chance, and one of infinite cost makes the expectation infinite.

    Parameters
    ----------
    game : Game
    infinite_as : float, optional
        What an infinite cost counts as, in the unit of the costs: at least the largest finite one.

    Raises
    ------
    GameError
        If a cost is infinite and `infinite_as` is not given, or is no stand-in for it.

    Examples
    --------
    >>> game = Game([[[1.0, np.inf]], [[2.0, np.inf]]], ["robot", "human"])
    >>> finite_costs(game, infinite_as=30.0)[0]
    array([[ 1., 30.]])
    """
    infinite = np.isinf(game.costs)
    if game.present is not None:
        # absent profiles read inf, and are nobody's cost
        infinite &= np.expand_dims(game.present, len(game.batch))
    if not infinite.any():
        return game.costs
    if infinite_as is None:
        axes = (*game.batch, Axis("player", game.players), *game.plans)
        raise GameError(
            f"the cost is inf at {first_cell(axes, infinite)}; mixed strategies give every profile a chance, so its "
            "expectation would be infinite. Say what an infinite cost (a collision) counts as: infinite_as=, in the "
            "unit of the costs; or drop the plans with restrict"
        )
    largest = np.max(game.costs, where=np.isfinite(game.costs), initial=-math.inf)
    if not math.isfinite(infinite_as) or infinite_as < largest:
        raise GameError(
            f"infinite_as is {infinite_as}; it must be finite and at least the largest finite cost, {largest}, or "
            "an infinite cost would be preferred to a finite one"
        )
    return np.where(infinite, infinite_as, game.costs)


def whole_plans(game: Game) -> tuple[Int[np.ndarray, "_"], ...]:
    """Return which plans of each player of one game are present.

    Raises
    ------
    GameError
        If profiles are absent other than because a plan is: a mixed strategy would play them.

    Examples
    --------
    >>> game = Game(np.zeros((2, 2, 2)), ["robot", "human"], present=[[True, False], [True, False]])
    >>> [plans.tolist() for plans in whole_plans(game)]
    [[0, 1], [0]]
    """
    if game.present is None:
        return tuple(np.arange(len(axis)) for axis in game.plans)
    players = range(len(game.players))
    plans = tuple(
        np.flatnonzero(game.present.any(axis=tuple(other for other in players if other != player)))
        for player in players
    )
    if not len(plans[0]):
        raise GameError(f"{game!r} has no profile present, so nobody can play it")
    hole = np.zeros(game.present.shape, bool)
    hole[np.ix_(*plans)] = ~game.present[np.ix_(*plans)]
    if hole.any():
        raise GameError(
            f"the profile {first_cell(game.plans, hole)} is absent though each of its plans is present in others; "
            "players who mix independently would play it. Mask whole plans only"
        )
    return plans


def expected_costs(
    costs: Float[np.ndarray, "..."], strategies: Sequence[Float[np.ndarray, "_"]]
) -> list[Float[np.ndarray, "_"]]:
    """Return what each plan is expected to cost its player while the others play their strategies.

    Parameters
    ----------
    costs : (player, *plans) float64
    strategies : sequence of (plan,) float64
        Probabilities; one array a player.

    Examples
    --------
    >>> expected_costs(np.array([[[0.0, 4.0], [1.0, 1.0]], [[2.0, 0.0], [2.0, 0.0]]]), [np.array([1.0, 0.0])] * 2)
    [array([0., 1.]), array([2., 0.])]
    """
    expected = []
    for player, own in enumerate(costs):
        # from the last player on, so that the dimensions left keep their places
        for other in range(len(strategies) - 1, -1, -1):
            if other != player:
                own = np.tensordot(own, strategies[other], axes=(other, 0))
        expected.append(own)
    return expected


def product_of(strategies: Sequence[Distribution]) -> Distribution:
    """Return the joint distribution of independent strategies, over the grid of their plans.

    Examples
    --------
    >>> coins = [Distribution.uniform(Axis(f"{name}_plan", 2)) for name in ("robot", "human")]
    >>> product_of(coins).values
    array([[0.25, 0.25],
           [0.25, 0.25]])
    """
    joint = strategies[0]
    for strategy in strategies[1:]:
        product = joint * strategy
        assert isinstance(product, Distribution)  # independent, by the chain rule
        joint = product
    return joint
