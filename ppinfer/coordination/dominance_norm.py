"""The norm of risk dominance: what everybody would lose most by leaving is expected."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.coordination.norms import LARGEST, Norm, check_rationality
from ppinfer.errors import ModelError


@dataclass(frozen=True)
class RiskDominant(Norm):
    """Equilibria are compared in pairs by what agents would lose who left one for the other (Harsanyi and Selten).

    Agent i's deviation loss at a, towards b, is c_i(b_i, a_-i) - c_i(a): what it costs to be the only one who plays b.
    Of two equilibria the one with the larger product of deviation losses is the less risky: it dominates the other. Of
    several, p_n(a) is proportional to exp(rationality s(a)), with s(a) the share of the others that a dominates; equal
    products count half.

    1. For every two profiles a, b among the equilibria, the product over the agents whose plans differ.
    2. A collision counts as a loss of `collision_loss`: it is bad, but not worse than every risk.
    3. Where no other equilibrium is there, the one is certain.

    Parameters
    ----------
    rationality : float
        How strictly people keep to it; 0 is the uniform norm.
    collision_loss : float
        Seconds; no deviation loses more.

    Raises
    ------
    ModelError
        If a parameter is out of its range.

    Examples
    --------
    The stag hunt: hunting together is best for both, and risky.

    >>> from ppinfer.coordination import RiskDominant
    >>> from ppinfer.games import Game, pure_equilibria
    >>> game = Game([[[1.0, 9.0], [3.0, 3.0]], [[1.0, 3.0], [9.0, 3.0]]], ["robot", "human"])
    >>> RiskDominant(rationality=2.0).probabilities(game, pure_equilibria(game)).values.round(3)
    array([[0.119, 0.   ],
           [0.   , 0.881]])
    """

    name: ClassVar[str] = "risk-dominant"
    rationality: float = 10.0
    collision_loss: float = 60.0

    def __post_init__(self) -> None:
        check_rationality("rationality", self.rationality)
        if not 0.0 < self.collision_loss < LARGEST:
            raise ModelError(
                f"collision_loss must be a positive number of seconds; got {self.collision_loss!r}"
            )

    def log_weights(
        self, costs: Float[np.ndarray, "player ..."], among: Bool[np.ndarray, "..."]
    ) -> Float[np.ndarray, "..."]:
        """Return rationality times the share of the other equilibria that each dominates."""
        players = len(costs)
        plans = among.shape[among.ndim - players :]
        table = costs.reshape(players, -1, *plans)
        mask = among.reshape(-1, *plans)
        cells = np.argwhere(mask)
        game, profile = cells[:, 0], cells[:, 1:]
        first, second = pairs_within(game)
        ours = self._losses(table, game[first], profile[first], profile[second])
        theirs = self._losses(table, game[first], profile[second], profile[first])
        wins = (ours > theirs) + 0.5 * (ours == theirs)
        others = np.bincount(game)[game] - 1
        share = np.bincount(first, wins, minlength=len(cells)) / np.maximum(others, 1)
        weights = np.zeros(mask.shape)
        weights[mask] = self.rationality * share
        return weights.reshape(among.shape)

    def _losses(
        self,
        table: Float[np.ndarray, "player game ..."],
        game: Int[np.ndarray, " pair"],
        here: Int[np.ndarray, "pair player"],
        there: Int[np.ndarray, "pair player"],
    ) -> Float[np.ndarray, " pair"]:
        """Return the product of deviation losses at `here`, towards `there`."""
        product = np.ones(len(game))
        for player, costs in enumerate(table):
            alone = here.copy()
            alone[:, player] = there[:, player]
            stay, leave = (costs[(game, *profile.T)] for profile in (here, alone))
            loss = np.full(len(game), self.collision_loss)
            # staying where it costs infinitely much loses nothing to leaving
            np.subtract(leave, stay, out=loss, where=np.isfinite(leave) & np.isfinite(stay))
            loss[np.isinf(stay)] = 0.0
            product *= np.where(
                here[:, player] == there[:, player], 1.0, np.clip(loss, 0.0, self.collision_loss)
            )
        return product


def pairs_within(
    group: Int[np.ndarray, " item"],
) -> tuple[Int[np.ndarray, " pair"], Int[np.ndarray, " pair"]]:
    """Return all ordered pairs of different items of one group; groups are in order.

    Examples
    --------
    >>> first, second = pairs_within(np.array([0, 0, 2]))
    >>> first.tolist(), second.tolist()
    ([0, 1], [1, 0])
    """
    size = np.bincount(group)[group]
    start = np.searchsorted(group, group)
    first = np.repeat(np.arange(len(group)), size)
    place = np.arange(len(first)) - np.repeat(np.cumsum(size) - size, size)
    second = np.repeat(start, size) + place
    apart = first != second
    return first[apart], second[apart]
