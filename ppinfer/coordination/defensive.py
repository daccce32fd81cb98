"""The policy that expects the worst (11)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ppinfer.coordination.choice import TIE, collisions
from ppinfer.coordination.policy import Decision, Policy
from ppinfer.coordination.situation import Situation
from ppinfer.distributions import Distribution, Factor


@dataclass(frozen=True)
class Defensive(Policy):
    """Take the plan whose worst case over the others' plans costs least (11).

    If every plan collides with some of the others' plans, take the one that collides with the fewest, rather staying
    put than moving. Its distribution is over its own plans: uniform over those that are equally good. Ties go to the
    lowest plan.

    Parameters
    ----------
    samples, commits
        As of every `Policy`.

    Examples
    --------
    >>> from ppinfer.coordination import Defensive, PlanSet, Situation
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [2, 1], [0.0, 4.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> situation = Situation.from_contacts([robot, human], [[1.5, np.inf], [np.inf, np.inf]])
    >>> Defensive().decide(situation, "robot").plan
    1
    """

    name: ClassVar[str] = "defensive"
    samples: int = 7
    commits: bool = False

    def decide(self, situation: Situation, ego: str, memory: Any = None) -> Decision:
        """Return the maximin plan; nothing is remembered."""
        player = situation.player(ego)
        own = situation.plans[player]
        cost = np.moveaxis(situation.game.costs[player], player, 0)
        worst = cost.reshape(len(own), -1).max(axis=1)
        # a value that no plan can guarantee is no reason to prefer one
        stay = own.static
        if np.isinf(worst).all():
            worst = collisions(situation, player)
        else:
            stay = None
        best = worst <= worst.min() + TIE
        plan = stay if stay is not None and best[stay] else int(best.argmax())
        distribution: Distribution = Factor.from_mask([own.axis], best).normalize(own.axis.name)
        return Decision(plan, distribution)
