"""Several norms at once, with weights that can be learned from what people chose."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.coordination.norms import Norm
from ppinfer.distributions import Axis, Distribution, Factor
from ppinfer.distributions.logspace import log_normalise, log_of, log_sum_exp
from ppinfer.errors import ImpossibleEvidenceError, ModelError
from ppinfer.games import Game


@dataclass(frozen=True)
class MixtureNorm(Norm):
    """Some people keep to one norm and some to another: p_n(a) = sum_k weight_k p_k(a).

    Parameters
    ----------
    norms : sequence of Norm
        At least one.
    weights : sequence of float
        The share of each; they sum to one.

    Raises
    ------
    ModelError
        If there are no norms, or the weights do not fit.

    Examples
    --------
    >>> from ppinfer.coordination import MinNorm, MixtureNorm, UniformNorm
    >>> from ppinfer.games import Game, pure_equilibria
    >>> game = Game([[[9.0, 1.0], [2.0, 9.0]], [[9.0, 2.0], [1.5, 9.0]]], ["robot", "human"])
    >>> norm = MixtureNorm([MinNorm(), UniformNorm()], [0.8, 0.2])
    >>> norm.probabilities(game, pure_equilibria(game)).values.round(3)
    array([[0. , 0.9],
           [0.1, 0. ]])
    """

    name: ClassVar[str] = "mixture"
    norms: Sequence[Norm]
    weights: Sequence[float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "norms", tuple(self.norms))
        object.__setattr__(self, "weights", tuple(float(weight) for weight in self.weights))
        if not self.norms or len(self.norms) != len(self.weights):
            raise ModelError(
                f"a mixture has one weight for each norm, at least one; got {len(self.norms)} norms and "
                f"{len(self.weights)} weights"
            )
        if not all(weight >= 0.0 for weight in self.weights) or abs(math.fsum(self.weights) - 1.0) > 1e-9:
            raise ModelError(f"weights are at least 0 and sum to 1; got {self.weights}")

    def log_weights(
        self, costs: Float[np.ndarray, "player ..."], among: Bool[np.ndarray, "..."]
    ) -> Float[np.ndarray, "..."]:
        """Return the log of the weighted sum of the norms' own probabilities."""
        over = tuple(range(among.ndim - len(costs), among.ndim))
        parts = []
        for norm, weight in zip(self.norms, self.weights, strict=True):
            own = np.where(among, norm.log_weights(costs, among), -math.inf)
            own, dead = log_normalise(own, over)
            # a norm that rules everything out has no say
            parts.append(np.where(False if dead is None else dead, -math.inf, own) + log_of(np.array(weight)))
        return log_sum_exp(np.stack(parts), (0,))

    @classmethod
    def fit(
        cls,
        norms: Sequence[Norm],
        game: Game,
        among: Factor,
        chosen: Any,
        *,
        tolerance: float = 1e-10,
        most_rounds: int = 10_000,
    ) -> MixtureNorm:
        """Learn the weights from profiles that people chose, by expectation maximisation.

        Each round, how probable it is that choice n followed norm k, weight_k p_k(a_n) / sum_j weight_j p_j(a_n), is
        averaged over the choices. The likelihood of weights is concave, so this finds its maximum.

        Parameters
        ----------
        norms : sequence of Norm
            What is mixed.
        game : Game
            One game for each choice, along one batch axis.
        among : Factor
            The equilibria that there were to choose from, as of `coordination_equilibria`.
        chosen : (choice, player) int
            The profile that was chosen in each game.
        tolerance : float
            Rounds end when no weight changes by more.
        most_rounds : int
            They end then in any case.

        Returns
        -------
        MixtureNorm
            Of the same norms.

        Raises
        ------
        ModelError
            If the choices do not fit the games.
        ImpossibleEvidenceError
            If a choice is impossible under every norm; the message says which.

        Examples
        --------
        >>> from ppinfer.coordination import MinNorm, MixtureNorm, UniformNorm, coordination_equilibria
        >>> from ppinfer.distributions import Axis
        >>> from ppinfer.games import Game
        >>> table = [[[9.0, 1.0], [2.0, 9.0]], [[9.0, 2.0], [1.5, 9.0]]]
        >>> game = Game([table] * 10, ["robot", "human"], batch=[Axis("trial", 10)])
        >>> chosen = [[0, 1]] * 8 + [[1, 0]] * 2
        >>> norm = MixtureNorm.fit([MinNorm(), UniformNorm()], game, coordination_equilibria(game), chosen)
        >>> [round(weight, 4) for weight in norm.weights]
        [0.6, 0.4]
        """
        profile = np.asarray(chosen)
        if len(game.batch) != 1 or profile.shape != (len(game.batch[0]), len(game.players)):
            raise ModelError(
                "one game along one batch axis and one profile belong to each choice; got games "
                f"{[axis.name for axis in game.axes]} and choices of shape {profile.shape}"
            )
        cell = (np.arange(len(profile)), *profile.T)
        likelihood = np.stack([norm.probabilities(game, among).log_values[cell] for norm in norms], axis=1)
        impossible = likelihood.max(axis=1) == -math.inf
        if impossible.any():
            first = int(impossible.argmax())
            raise ImpossibleEvidenceError(
                f"choice {first} (and {int(impossible.sum()) - 1} others) is impossible under every norm: profile "
                f"{tuple(profile[first].tolist())} is no equilibrium there, or each rules it out"
            )
        likelihood = np.exp(likelihood - likelihood.max(axis=1, keepdims=True))
        weights = np.full(len(norms), 1.0 / len(norms))
        for _ in range(most_rounds):
            share = weights * likelihood
            share /= share.sum(axis=1, keepdims=True)
            before, weights = weights, share.mean(axis=0)
            if np.abs(weights - before).max() <= tolerance:
                break
        return cls(norms, (weights / weights.sum()).tolist())

    def of_whom(self) -> Distribution:
        """Return the weights as a distribution over the norms, by their names (numbered where these repeat)."""
        names = [norm.name for norm in self.norms]
        labels = [name if names.count(name) == 1 else f"{name} {place}" for place, name in enumerate(names)]
        return Distribution.from_probabilities([Axis("norm", labels)], self.weights)
