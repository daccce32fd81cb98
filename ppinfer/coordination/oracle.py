"""The policy that is told what the others' policies make of each game: the ceiling for inference over theta."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

import numpy as np
from jaxtyping import Bool

from ppinfer.coordination.choice import TIE, decide_by, hold
from ppinfer.coordination.classes import favoured_classes
from ppinfer.coordination.equilibria import coordination_equilibria
from ppinfer.coordination.norm_nash import NormNash
from ppinfer.coordination.norms import MinNorm, Norm, among_mask
from ppinfer.coordination.policy import Decision, Policy
from ppinfer.coordination.situation import Situation
from ppinfer.distributions import Axis, Factor
from ppinfer.games.equilibria import indicator


@dataclass(frozen=True)
class OracleNash(Policy):
    """Play the norm's choice among the equilibria of the class that the others' own policy picks in this game.

    `other` is asked what it would do in the very situation that the ego sees. The class is that of the profile which
    it picks: a selfish agent's favours itself, a norm-following agent's whom the norm does. One that thinks of no
    profile, such as a defensive agent, leaves the ego to go first. An equilibrium that costs both the same is of
    both classes; a class without equilibria restricts nothing.

    Parameters
    ----------
    other : Policy
        What every other agent follows.
    norm : Norm
        Chooses within the class.
    dominance : {"weak", "strict"}
        Which equilibria count; see `coordination_equilibria`.
    samples, commits
        As of every `Policy`.

    Examples
    --------
    >>> from ppinfer.coordination import OracleNash, PlanSet, Selfish, Situation
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [2, 1], [0.0, 2.5, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> situation = Situation.from_contacts([robot, human], [[1.5, np.inf], [np.inf, np.inf]])
    >>> OracleNash(other=Selfish()).decide(situation, "robot").profile
    (1, 0)
    """

    name: ClassVar[str] = "oracle"
    other: Policy = field(default_factory=NormNash)
    norm: Norm = field(default_factory=MinNorm)
    dominance: Literal["weak", "strict"] = "weak"
    samples: int = 7
    commits: bool = False

    def decide(self, situation: Situation, ego: str, memory: Any = None) -> Decision:
        """Return the part of `ego` in the equilibrium; what the others' policies remember is remembered for them."""
        player = situation.player(ego)
        game = situation.game
        remembered = dict(memory) if memory is not None else {}
        equilibria = among_mask(game, coordination_equilibria(game, self.dominance))
        classes = favoured_classes(game.costs, equilibria)
        told: Bool[np.ndarray, " theta"] = np.zeros(len(situation.plans), np.bool_)
        for agent in situation.agents:
            if agent == ego:
                continue
            asked = self.other.decide(situation, agent, remembered.get(agent))
            remembered[agent] = asked.memory
            if asked.profile is None:
                told[player] = True
            else:
                cost = np.array([own[asked.profile] for own in game.costs])
                told |= cost <= cost.min() + TIE
        belief = Factor.from_mask([Axis("theta", situation.agents)], told).normalize("theta")
        if not equilibria.any():
            return hold(situation, player, belief=belief, memory=remembered)
        within = classes[told].any(axis=0)
        if not within.any():
            within = equilibria
        distribution = self.norm.probabilities(game, indicator(game, within))
        return decide_by(situation, distribution, player, belief=belief, memory=remembered)
