"""Pure equilibria and what is asked of them, as factors of zeros and ones over the grid of profiles."""

from __future__ import annotations

import math
from typing import Any, Literal, TypeAlias

import numpy as np
from jaxtyping import Float

from ppinfer.distributions import Factor
from ppinfer.errors import GameError
from ppinfer.games.game import Game

Dominance: TypeAlias = Literal["weak", "strict"]
"""What drops a profile: being nowhere cheaper and somewhere dearer than another, or being dearer for all players."""


def pure_equilibria(game: Game) -> Factor:
    """Mark the pure equilibria: profiles at which no player could gain by deviating alone.

    Equation (1) to the letter, infinities included: a player whose cost is infinite whatever it does has nothing to
    gain. Such vacuous equilibria are left out by a product with `finite_profiles`.

    1. For each player, the least cost over its own plans, given those of the others (absent profiles set aside).
    2. A profile is marked where every player's cost is at most that.

    Parameters
    ----------
    game : Game
        Of any number of players, with any batch axes.

    Returns
    -------
    Factor
        Over the batch and plan axes: 1 at the equilibria, 0 elsewhere.

    See Also
    --------
    regret : how much each player could gain.

    Examples
    --------
    >>> game = Game([[[1.0, np.inf], [np.inf, 2.0]], [[2.0, np.inf], [np.inf, 1.0]]], ["robot", "human"])
    >>> pure_equilibria(game).values
    array([[1., 0.],
           [0., 1.]])
    """
    costs, lead = game.costs, len(game.batch)
    shape = costs.shape[:lead] + costs.shape[lead + 1 :]
    if len(game.players) == 2:
        from ppinfer.games.scans import pure_log_indicator2

        log_values = pure_log_indicator2(costs.reshape(-1, *costs.shape[lead:])).reshape(shape)
        if game.present is not None:
            log_values[~game.present] = -math.inf
        return Factor._trusted(game.axes, log_values)
    mask = np.ones(shape, bool) if game.present is None else game.present.copy()
    for player in range(len(game.players)):
        own = costs[(slice(None),) * lead + (player,)]
        mask &= own <= own.min(axis=lead + player, keepdims=True)
    return indicator(game, mask)


def finite_profiles(game: Game) -> Factor:
    """Mark the profiles that cost every player a finite amount (that are free of collisions).

    Parameters
    ----------
    game : Game
        Of any number of players, with any batch axes.

    Returns
    -------
    Factor
        Over the batch and plan axes: 1 where no cost is infinite, 0 elsewhere.

    Examples
    --------
    >>> finite_profiles(Game([[[1.0, np.inf]], [[2.0, 3.0]]], ["robot", "human"])).values
    array([[1., 0.]])
    """
    from ppinfer.games.scans import finite_log_indicator

    games = math.prod(map(len, game.batch))
    # absent profiles read inf
    log_values = finite_log_indicator(game.costs.reshape(games, len(game.players), -1))
    return Factor._trusted(game.axes, log_values.reshape([len(axis) for axis in game.axes]))


def regret(game: Game) -> Float[np.ndarray, "..."]:
    """Return how much each player could gain by deviating alone, at every profile.

    Parameters
    ----------
    game : Game
        Of any number of players, with any batch axes.

    Returns
    -------
    array of float, shape (*batch, player, *plans)
        In the unit of the costs: own cost less that of the best reply. 0 where both are infinite, inf where the own
        cost is and the best reply is not, NaN at profiles that do not exist. A profile is a pure equilibrium exactly
        where all players' regrets are 0.

    Examples
    --------
    >>> regret(Game([[[1.0, np.inf], [4.0, np.inf]], [[2.0, 3.0], [np.inf, 1.0]]], ["robot", "human"]))
    array([[[ 0.,  0.],
            [ 3.,  0.]],
           [[ 0.,  1.],
            [inf,  0.]]])
    """
    costs, lead = game.costs, len(game.batch)
    result = np.zeros_like(costs)
    for player in range(len(game.players)):
        which = (slice(None),) * lead + (player,)
        own = costs[which]
        best = own.min(axis=lead + player, keepdims=True)
        # inf - inf is left at 0
        np.subtract(own, best, out=result[which], where=own > best)
    if game.present is not None:
        np.copyto(result, np.nan, where=~np.expand_dims(game.present, lead))
    return result


def undominated(game: Game, among: Factor, *, dominance: Dominance = "weak") -> Factor:
    """Mark those of some profiles that no other of them dominates (a Pareto filter).

    Parameters
    ----------
    game : Game
        Whose costs are compared, as they are: an infinite cost is dearer than any other, and ties with itself.
    among : Factor
        Over axes of the game: the profiles that are compared with each other are those where it is positive, for
        example ``pure_equilibria(game) * finite_profiles(game)``. Batch axes that it lacks, it is constant in.
    dominance : {"weak", "strict"}
        ``"weak"`` drops a profile that some other costs no player more than, and a player less. ``"strict"`` drops
        only one that some other is cheaper than for every player (the paper's).

    Returns
    -------
    Factor
        Over the batch and plan axes: 1 at the profiles that are left, 0 elsewhere.

    Raises
    ------
    GameError
        If `dominance` is neither.
    AxisError
        If `among` has other axes than the game.

    Examples
    --------
    >>> game = Game([[[1.0, 1.0, 3.0]], [[2.0, 3.0, 9.0]]], ["robot", "human"])
    >>> undominated(game, finite_profiles(game)).values
    array([[1., 0., 0.]])
    >>> undominated(game, finite_profiles(game), dominance="strict").values
    array([[1., 1., 0.]])
    """
    if dominance not in ("weak", "strict"):
        raise GameError(f"dominance is 'weak' or 'strict', not {dominance!r}")
    from ppinfer.games.scans import undominated_mask

    if among.axes != game.axes:
        among = among.align(*game.axes)
    # in C order, which values laid out anew need not have
    mask = np.greater(among.log_values, -math.inf, order="C")
    if game.present is not None:
        mask &= game.present
    costs, players = game.costs, len(game.players)
    games = math.prod(map(len, game.batch))
    left: Any = undominated_mask(
        costs.reshape(games, players, -1), mask.reshape(games, -1), dominance == "strict"
    )
    return indicator(game, left.reshape(mask.shape))


def indicator(game: Game, mask: np.ndarray) -> Factor:
    """Return the factor that is 1 where a mask over the game's axes is true, and 0 elsewhere.

    Examples
    --------
    >>> indicator(Game([[[1.0, 2.0]], [[1.0, 2.0]]], ["robot", "human"]), np.array([[True, False]])).values
    array([[1., 0.]])
    """
    return Factor._trusted(game.axes, np.where(mask, 0.0, -math.inf))
