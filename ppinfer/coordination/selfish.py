"""The policy that expects the others to give way (12)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from ppinfer.coordination.choice import TIE, decide_by, hold
from ppinfer.coordination.equilibria import coordination_equilibria
from ppinfer.coordination.norms import over_profiles
from ppinfer.coordination.policy import Decision, Policy
from ppinfer.coordination.situation import Situation
from ppinfer.distributions.logspace import log_indicator


@dataclass(frozen=True)
class Selfish(Policy):
    """Play the equilibrium that costs oneself least (12).

    Its distribution over profiles is uniform over the equilibria of that cost; of these it takes the one with its own
    lowest plan, then the others' lowest plans. Without any equilibrium it holds.

    Parameters
    ----------
    dominance : {"weak", "strict"}
        Which equilibria count; see `coordination_equilibria`.
    samples, commits
        As of every `Policy`.

    Examples
    --------
    >>> from ppinfer.coordination import PlanSet, Selfish, Situation
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [2, 1], [0.0, 4.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> situation = Situation.from_contacts([robot, human], [[1.5, np.inf], [np.inf, np.inf]])
    >>> Selfish().decide(situation, "robot").profile, Selfish().decide(situation, "human").profile
    ((0, 1), (1, 0))
    """

    name: ClassVar[str] = "selfish"
    dominance: Literal["weak", "strict"] = "weak"
    samples: int = 7
    commits: bool = False

    def decide(self, situation: Situation, ego: str, memory: Any = None) -> Decision:
        """Return the part of `ego` in the equilibrium that it likes best; nothing is remembered."""
        player = situation.player(ego)
        equilibria = coordination_equilibria(situation.game, self.dominance).log_values > -np.inf
        if not equilibria.any():
            return hold(situation, player)
        own = np.where(equilibria, situation.game.costs[player], np.inf)
        return decide_by(
            situation, over_profiles(situation.game, log_indicator(own <= own.min() + TIE)), player
        )
