"""Among which equilibria do agents coordinate? Those that nobody collides in and that none leaves everybody behind."""

from __future__ import annotations

from typing import Literal

from ppinfer.distributions import Factor
from ppinfer.games import Game, finite_profiles, pure_equilibria, undominated


def coordination_equilibria(game: Game, dominance: Literal["weak", "strict"] = "weak") -> Factor:
    """Return the indicator of the equilibria that agents may coordinate on.

    1. Pure equilibria (1), to the letter: where everybody collides whatever one does alone, nobody regrets anything.
    2. Of these, the ones in which nobody collides (all costs finite).
    3. Of these, the ones that are not dominated by another of them.

    Wherever some profile is free of collisions, and collisions are mutual and costs one's own otherwise, there is one.

    Parameters
    ----------
    game : Game
        Costs, s; with batch axes, many games at once.
    dominance : {"weak", "strict"}
        "weak" drops an equilibrium if another one is as good for all and better for one; "strict" (the paper's) only
        if another one is better for all.

    Returns
    -------
    Factor
        Over the game's batch and plan axes, 1 or 0. It may be 0 throughout: then there is nothing to do but hold.

    Examples
    --------
    >>> from ppinfer.games import Game
    >>> inf = np.inf
    >>> game = Game([[[inf, 4.0], [9.0, 9.0]], [[inf, 8.0], [5.0, 8.0]]], ["robot", "human"])
    >>> coordination_equilibria(game).values
    array([[0., 1.],
           [1., 0.]])
    """
    free = pure_equilibria(game) * finite_profiles(game)
    return undominated(game, free, dominance=dominance)
