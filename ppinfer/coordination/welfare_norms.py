"""Norms that weigh everybody's costs: the sum, the worst, or nothing at all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.coordination.norms import Norm, check_rationality, scaled


@dataclass(frozen=True)
class Utilitarian(Norm):
    """What costs all together least is expected: p_n(a) proportional to exp(-rationality sum_i c_i(a)).

    Parameters
    ----------
    rationality : float
        How strictly people keep to it, 1/s.

    Raises
    ------
    ModelError
        If it is out of its range.

    Examples
    --------
    >>> from ppinfer.coordination import Utilitarian
    >>> from ppinfer.games import Game, pure_equilibria
    >>> game = Game([[[9.0, 1.0], [3.0, 9.0]], [[9.0, 4.0], [1.0, 9.0]]], ["robot", "human"])
    >>> Utilitarian(rationality=1.0).probabilities(game, pure_equilibria(game)).values.round(3)
    array([[0.   , 0.269],
           [0.731, 0.   ]])
    """

    name: ClassVar[str] = "utilitarian"
    rationality: float = 1.0

    def __post_init__(self) -> None:
        check_rationality("rationality", self.rationality)

    def log_weights(
        self, costs: Float[np.ndarray, "player ..."], among: Bool[np.ndarray, "..."]
    ) -> Float[np.ndarray, "..."]:
        """Return -rationality sum_i c_i."""
        return scaled(costs.sum(axis=0), self.rationality)


@dataclass(frozen=True)
class Egalitarian(Norm):
    """What costs the worst-off least is expected (minimax): p_n(a) proportional to exp(-rationality max_i c_i(a)).

    Parameters
    ----------
    rationality : float
        How strictly people keep to it, 1/s.

    Raises
    ------
    ModelError
        If it is out of its range.

    Examples
    --------
    >>> from ppinfer.coordination import Egalitarian
    >>> from ppinfer.games import Game, pure_equilibria
    >>> game = Game([[[9.0, 1.0], [3.0, 9.0]], [[9.0, 4.0], [1.0, 9.0]]], ["robot", "human"])
    >>> Egalitarian(rationality=1.0).probabilities(game, pure_equilibria(game)).values.round(3)
    array([[0.   , 0.269],
           [0.731, 0.   ]])
    """

    name: ClassVar[str] = "egalitarian"
    rationality: float = 1.0

    def __post_init__(self) -> None:
        check_rationality("rationality", self.rationality)

    def log_weights(
        self, costs: Float[np.ndarray, "player ..."], among: Bool[np.ndarray, "..."]
    ) -> Float[np.ndarray, "..."]:
        """Return -rationality max_i c_i."""
        return scaled(costs.max(axis=0), self.rationality)


@dataclass(frozen=True)
class UniformNorm(Norm):
    """Nothing is expected: every equilibrium is as probable. The personality posterior is left alone.

    Examples
    --------
    >>> from ppinfer.coordination import UniformNorm
    >>> from ppinfer.games import Game, pure_equilibria
    >>> game = Game([[[9.0, 1.0], [3.0, 9.0]], [[9.0, 4.0], [1.0, 9.0]]], ["robot", "human"])
    >>> UniformNorm().probabilities(game, pure_equilibria(game)).values.round(3)
    array([[0. , 0.5],
           [0.5, 0. ]])
    """

    name: ClassVar[str] = "uniform"

    def log_weights(
        self, costs: Float[np.ndarray, "player ..."], among: Bool[np.ndarray, "..."]
    ) -> Float[np.ndarray, "..."]:
        """Return 0."""
        return np.zeros(among.shape)
