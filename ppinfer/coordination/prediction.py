"""What will the other agent do, when each considers plans of its own? A distribution over the other's plans."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from ppinfer.coordination.situation import Situation
from ppinfer.distributions import Axis, Distribution
from ppinfer.distributions.logspace import Array
from ppinfer.errors import ModelError


@dataclass(frozen=True)
class PlanPrediction:
    """The other agent's plan, if it chooses among equilibria of games that we can only guess.

    Whoever samples plans for itself considers others than we do. So we play many sub-games, each among a few of the
    plans that we sampled for both; in each, the equilibria that are free of collisions and not dominated are weighted
    by the min-norm (3) within a class of theta, and how often each plan of the other's is played is its probability.

    Parameters
    ----------
    games : int
        Sub-games.
    plans : int
        Plans of each agent in a sub-game, drawn without replacement, besides the static ones.
    norm_rationality : float
        lambda_n of (3) in the sub-games, 1/s.

    Raises
    ------
    ModelError
        If a parameter is out of its range, or a situation has more than two agents.

    Examples
    --------
    >>> import numpy as np
    >>> from ppinfer.coordination import PlanPrediction, PlanSet, Situation
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [2, 1], [0.0, 2.5, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> situation = Situation.from_contacts([robot, human], [[1.5, np.inf], [np.inf, np.inf]])
    >>> PlanPrediction().predict(situation, "robot").values
    array([[0., 1.],
           [1., 0.]])
    """

    games: int = 24
    plans: int = 7
    norm_rationality: float = 50.0

    def __post_init__(self) -> None:
        for name in ("games", "plans"):
            if getattr(self, name) < 1:
                raise ModelError(f"{name} must be at least 1; got {getattr(self, name)}")
        if not 0.0 <= self.norm_rationality < 1e30:
            raise ModelError(f"norm_rationality must lie in [0, 1e30); got {self.norm_rationality}")

    def predict(self, situation: Situation, ego: str) -> Distribution:
        """Return the distribution of the other agent's plan, given whom its equilibria favour.

        Returns
        -------
        Distribution
            Random in the other agent's plan axis, given ``theta``, the agents in order.
            The sub-games are drawn from the situation's seed.
        """
        from ppinfer.coordination.scans import plan_frequencies

        own = situation.player(ego)
        if len(situation.plans) != 2:
            raise ModelError(f"plans are predicted for two agents; there are {len(situation.plans)}")
        other = 1 - own
        rng = np.random.default_rng(situation.seed)
        drawn = [self._drawn(rng, len(plans), plans.static) for plans in situation.plans]
        costs = situation.game.costs if own == 0 else situation.game.costs.transpose(0, 2, 1)
        theirs = situation.plans[other]
        hold = len(theirs) - 1 if theirs.static is None else theirs.static
        frequencies = plan_frequencies(
            costs[own], costs[other], drawn[own], drawn[other], self.norm_rationality, hold
        )
        theta = Axis("theta", situation.agents)
        if own == 1:
            frequencies = frequencies[::-1]
        return Distribution.from_probabilities([theta, theirs.axis], frequencies, given=["theta"])

    def _drawn(self, rng: np.random.Generator, plans: int, static: int | None) -> Int[Array, "game plan"]:
        moving = np.array([plan for plan in range(plans) if plan != static], np.int64)
        drawn = rng.permuted(np.tile(moving, (self.games, 1)), axis=1)[:, : self.plans]
        if static is None:
            return drawn
        return np.concatenate([drawn, np.full((self.games, 1), static)], axis=1)
