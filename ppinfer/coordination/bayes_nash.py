"""The policy of the paper: a norm and what is known of the other's personality (2)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from ppinfer.coordination.choice import decide_by, hold
from ppinfer.coordination.literal_personality import LiteralPersonality
from ppinfer.coordination.norms import MinNorm, Norm, over_profiles
from ppinfer.coordination.personality import Personality
from ppinfer.coordination.personality_model import PersonalityModel, PersonalityState
from ppinfer.coordination.policy import Decision, Policy
from ppinfer.coordination.situation import Situation
from ppinfer.games.equilibria import indicator


@dataclass(frozen=True)
class BayesNash(Policy):
    """Play the equilibrium that is most probable under p(a) proportional to p_n(a) p_alpha(a) (2).

    Ties go to the lowest own cost, then the lowest own plan, then the others' lowest plans. Without any equilibrium it
    holds, and goes on learning.

    Parameters
    ----------
    norm : Norm
        p_n; by default `MinNorm` with a cost unit of 100 s, which leaves room for p_alpha. The paper's unit is 1 s.
    personality : PersonalityModel
        Where p_alpha comes from; it says which equilibria count. By default `Personality` with classes by loss.
    samples, commits
        As of every `Policy`.

    Examples
    --------
    >>> from ppinfer.coordination import BayesNash, PlanSet, Situation
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [2, 1], [0.0, 4.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> situation = Situation.from_contacts([robot, human], [[1.5, np.inf], [np.inf, np.inf]])
    >>> decision = BayesNash().decide(situation, "robot")
    >>> decision.profile, decision.belief.values
    ((0, 1), array([0.5, 0.5]))
    """

    name: ClassVar[str] = "bayes"
    norm: Norm = field(default_factory=lambda: MinNorm(cost_unit=100.0))
    personality: PersonalityModel = field(default_factory=lambda: Personality(favour_by="loss"))
    samples: int = 7
    commits: bool = False

    def decide(self, situation: Situation, ego: str, memory: PersonalityState | None = None) -> Decision:
        """Return the part of `ego` in the most probable equilibrium; `memory` is the last replan's."""
        player = situation.player(ego)
        state = self.personality.observe(situation, ego, memory)
        if not state.equilibria.any():
            return hold(situation, player, belief=state.belief, memory=state)
        game = situation.game
        p_n = self.norm.probabilities(game, indicator(game, state.equilibria))
        distribution = over_profiles(game, p_n.log_values + state.log_p_alpha)
        return decide_by(situation, distribution, player, belief=state.belief, memory=state)

    def belief_model(self) -> PersonalityModel:
        """Return `personality`."""
        return self.personality


@dataclass(frozen=True)
class CostBayesNash(BayesNash):
    """`BayesNash` with classes by cost and a cost unit of 50 s: between the printed one and `BayesNash`."""

    name: ClassVar[str] = "bayes-cost"
    norm: Norm = field(default_factory=lambda: MinNorm(cost_unit=50.0))
    personality: PersonalityModel = field(default_factory=Personality)


@dataclass(frozen=True)
class LiteralBayesNash(BayesNash):
    """`BayesNash` as printed: `LiteralPersonality`, and costs in seconds."""

    name: ClassVar[str] = "bayes-literal"
    norm: Norm = field(default_factory=MinNorm)
    personality: PersonalityModel = field(default_factory=LiteralPersonality)
