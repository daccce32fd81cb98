"""Norms: what everybody expects everybody to choose among several equilibria."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Distribution, Factor
from ppinfer.distributions.layout import Kinds
from ppinfer.errors import ModelError
from ppinfer.games import Game

_BATCH: Kinds = ("batch",)
_RANDOM: Kinds = ("random",)

LARGEST = 1e30
"""Bound of a rationality: products with costs must stay numbers."""


class Norm(ABC):
    """A distribution over the equilibria of a game that all agents share; subclasses are small frozen dataclasses.

    A subclass says how much a profile weighs, `log_weights`; the rest follows. `ppinfer.testing.check_norm` holds it
    to the laws.

    Examples
    --------
    A norm of one's own: the first agent goes first.

    >>> from dataclasses import dataclass
    >>> from ppinfer.coordination import Norm
    >>> from ppinfer.games import Game, pure_equilibria
    >>> @dataclass(frozen=True)
    ... class FirstGoesFirst(Norm):
    ...     def log_weights(self, costs, among):
    ...         return -costs[0]
    >>> game = Game([[[9.0, 1.0], [2.0, 9.0]], [[9.0, 2.0], [1.0, 9.0]]], ["robot", "human"])
    >>> FirstGoesFirst().probabilities(game, pure_equilibria(game)).values.round(3)
    array([[0.   , 0.731],
           [0.269, 0.   ]])
    """

    name: ClassVar[str] = "custom"

    @abstractmethod
    def log_weights(
        self, costs: Float[np.ndarray, "player ..."], among: Bool[np.ndarray, "..."]
    ) -> Float[np.ndarray, "..."]:
        """Return the logarithm of what each profile weighs, up to a constant for each game.

        Parameters
        ----------
        costs : (player, *batch, *plans) float64
            Seconds, players first; inf is a collision.
        among : (*batch, *plans) bool
            The profiles that count, usually the equilibria. Weights of others are ignored, and may be anything but
            NaN.

        Returns
        -------
        (*batch, *plans) float64
            -inf for a profile that the norm rules out.
        """

    def probabilities(self, game: Game, among: Factor) -> Distribution:
        """Return the norm's distribution over the profiles of a game, zero outside `among`.

        Parameters
        ----------
        game : Game
            Costs, s.
        among : Factor
            An indicator over the game's axes: the profiles to choose among, as of `coordination_equilibria`.

        Returns
        -------
        Distribution
            Random in the plan axes; batch axes are the game's.

        Raises
        ------
        ImpossibleEvidenceError
            If a game has no profile to choose among, or the norm rules all of them out; the message names it.
        """
        mask = among_mask(game, among)
        weights = np.where(mask, self.log_weights(costs_by_player(game), mask), -math.inf)
        # a norm of the user's own may return anything: Factor names the cell that is NaN
        return over_profiles(game, Factor(game.axes, weights).log_values)


def over_profiles(game: Game, log_values: Float[np.ndarray, "..."]) -> Distribution:
    """Return the distribution over a game's profiles that is proportional to some values; batch axes stay."""
    return Distribution._normalised(
        game.axes, log_values, _BATCH * len(game.batch) + _RANDOM * len(game.plans)
    )


def among_mask(game: Game, among: Factor) -> Bool[np.ndarray, "..."]:
    """Return where an indicator over a game's axes is above 0, laid out as the game is."""
    if among.axes != game.axes:
        among = among.align(*game.axes)
    mask: np.ndarray = among.log_values > -math.inf
    return mask


def costs_by_player(game: Game) -> Float[np.ndarray, "player ..."]:
    """Return a game's costs with the players first, before the batch axes."""
    return np.moveaxis(game.costs, len(game.batch), 0) if game.batch else game.costs


def check_rationality(name: str, value: float) -> None:
    """Raise ModelError unless it is a finite number of at least 0."""
    if not 0.0 <= value < LARGEST:
        raise ModelError(f"{name} must lie in [0, {LARGEST:g}); got {value!r}")


@dataclass(frozen=True)
class MinNorm(Norm):
    """The agent that can be done first goes first (3): p_n(a) proportional to exp(-lambda_n min_i c_i(a) / unit).

    Parameters
    ----------
    rationality : float
        lambda_n: how strictly people keep to it.
    cost_unit : float
        Seconds that count as one unit of cost. 1 is the paper's, and with lambda_n = 50 all but decides: a tenth of a
        second makes a factor of exp(5). With 50 s the norm leaves room for what is known of a personality.

    Raises
    ------
    ModelError
        If a parameter is out of its range.

    Examples
    --------
    >>> from ppinfer.coordination import MinNorm
    >>> from ppinfer.games import Game, pure_equilibria
    >>> game = Game([[[9.0, 1.0], [2.0, 9.0]], [[9.0, 2.0], [1.5, 9.0]]], ["robot", "human"])
    >>> MinNorm(rationality=2.0).probabilities(game, pure_equilibria(game)).values.round(3)
    array([[0.   , 0.731],
           [0.269, 0.   ]])
    """

    name: ClassVar[str] = "min"
    rationality: float = 50.0
    cost_unit: float = 1.0

    def __post_init__(self) -> None:
        check_rationality("rationality", self.rationality)
        if not 0.0 < self.cost_unit < LARGEST:
            raise ModelError(f"cost_unit must be a positive number of seconds; got {self.cost_unit!r}")

    def log_weights(
        self, costs: Float[np.ndarray, "player ..."], among: Bool[np.ndarray, "..."]
    ) -> Float[np.ndarray, "..."]:
        """Return -lambda_n min_i c_i / unit."""
        return scaled(costs.min(axis=0), self.rationality / self.cost_unit)


def scaled(cost: Float[np.ndarray, "..."], rate: float) -> Float[np.ndarray, "..."]:
    """Return -rate * cost, where no rate at all makes nothing of infinite costs either."""
    if rate == 0.0:
        return np.zeros_like(cost)
    weights: np.ndarray = -rate * cost
    return weights
