"""Risk-aware choice of an equilibrium, for agents that each consider plans of their own."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Float, Int

from ppinfer.coordination.choice import best_profile, hold
from ppinfer.coordination.classes import log_p_alpha
from ppinfer.coordination.equilibria import coordination_equilibria
from ppinfer.coordination.norms import MinNorm, Norm, check_rationality
from ppinfer.coordination.personality_model import PersonalityState
from ppinfer.coordination.policy import Decision, Policy
from ppinfer.coordination.predictive_personality import PredictivePersonality
from ppinfer.coordination.situation import Situation
from ppinfer.distributions import Distribution, Factor
from ppinfer.errors import ModelError


@dataclass(frozen=True)
class BayesRisk(Policy):
    """Play the equilibrium that a norm and the other's personality make likely, and that is unlikely to end in a stop.

    1. `PlanPrediction` gives W(j | theta), a distribution over the other agent's plans; `PredictivePersonality` says
       what p(theta) is.
    2. The risk of an own plan i is r(i) = sum_theta p(theta) sum_j W(j | theta) g(t_ij), with t_ij the time of first
       contact and g = 1 until `sure_until`, then falling as exp(-(t - sure_until) / `fade`).
    3. The game is that of few own plans against all of the other's. Among its collision-free, undominated equilibria

           log p(a) = log p_n(a) + log p_alpha(a) - risk_weight r(a_ego) - delay_weight (c_ego(a) - min c_ego) + const.

    Without any equilibrium it holds. Risk keeps arms apart; what is known of the other's personality takes back the
    waiting that risk would cost.

    Parameters
    ----------
    norm : Norm
        p_n; milder than that of `NormNash`, by default 1 for each second.
    personality : PredictivePersonality
        Where p(theta) and W come from.
    acting : int
        How many of its own sampled plans the agent chooses among, besides the static one.
    risk_weight : float
        Price of a certain contact, in units of log probability.
    delay_weight : float
        Price of a second's delay, 1/s.
    sure_until, fade : float
        Seconds: contacts before the next replan cannot be avoided any more, later ones more and more easily.
    samples, commits
        As of every `Policy`.

    Raises
    ------
    ModelError
        If a parameter is out of its range; if a situation has more than two agents, or no contact times.

    Examples
    --------
    >>> from ppinfer.coordination import BayesRisk, PlanSet, Situation
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [2, 1], [0.0, 4.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> situation = Situation.from_contacts([robot, human], [[1.5, np.inf], [np.inf, np.inf]])
    >>> decision = BayesRisk().decide(situation, "robot")
    >>> decision.profile, decision.predictive.values.round(6)
    ((0, 1), array([0., 1.]))
    """

    name: ClassVar[str] = "bayes-risk"
    norm: Norm = field(default_factory=lambda: MinNorm(rationality=1.0))
    personality: PredictivePersonality = field(default_factory=PredictivePersonality)
    acting: int = 7
    risk_weight: float = 20.0
    delay_weight: float = 0.1
    sure_until: float = 0.9
    fade: float = 4.0
    samples: int = 24
    commits: bool = True

    def __post_init__(self) -> None:
        for name in ("risk_weight", "delay_weight"):
            check_rationality(name, getattr(self, name))
        if self.acting < 1:
            raise ModelError(f"acting must be at least 1; got {self.acting!r}")
        if not 0.0 <= self.sure_until < np.inf or not 0.0 < self.fade < np.inf:
            raise ModelError(
                f"sure_until and fade are seconds, fade positive; got {self.sure_until!r} and {self.fade!r}"
            )

    def decide(self, situation: Situation, ego: str, memory: PersonalityState | None = None) -> Decision:
        """Return the part of `ego` in the best equilibrium; `memory` is the last replan's."""
        player = situation.player(ego)
        if situation.contact_time is None:
            raise ModelError("bayes-risk weighs risk: give the situation its contact_time")
        state = self.personality.observe(situation, ego, memory)
        learned = {
            "belief": state.belief,
            "predictive": (state.belief * state.memory.predictive).marginal(
                f"{situation.agents[1 - player]}_plan"
            ),
            "memory": state,
        }
        acting = self._acting(situation, player)
        distribution = self._distribution(situation, player, acting, state, learned["predictive"])
        if distribution is None:
            return hold(situation, player, **learned)
        profile = best_profile(distribution.log_values, situation.game.costs[player], player)
        return Decision(profile[player], distribution, profile, **learned)

    def belief_model(self) -> PredictivePersonality:
        """Return `personality`."""
        return self.personality

    def risk(self, situation: Situation, ego: str, predictive: Distribution) -> Float[np.ndarray, " plan"]:
        """Return the risk of each of ego's plans, if the other agent's is distributed as predicted.

        0 is never a contact, 1 one that is sure and near.
        """
        if situation.contact_time is None:
            raise ModelError("risk needs the situation's contact_time")
        contact = np.moveaxis(situation.contact_time, situation.player(ego), 0)
        later = np.maximum(contact - self.sure_until, 0.0)
        risk: np.ndarray = np.exp(-later / self.fade) @ predictive.values
        return risk

    def _acting(self, situation: Situation, player: int) -> Int[np.ndarray, " plan"]:
        plans = situation.plans[player]
        moving = [plan for plan in range(len(plans)) if plan != plans.static][: self.acting]
        return np.array(moving if plans.static is None else [*moving, plans.static])

    def _distribution(
        self,
        situation: Situation,
        player: int,
        acting: Int[np.ndarray, " plan"],
        state: PersonalityState,
        predictive: Distribution,
    ) -> Distribution | None:
        """Return p(a) over the profiles of the whole game; None if there is no equilibrium."""
        ego = situation.agents[player]
        few = situation.restrict({ego: acting})
        among = coordination_equilibria(few.game, self.personality.dominance).log_values > -np.inf
        if not among.any():
            return None
        costs = few.game.costs
        classes = self.personality.favoured(costs, among)
        p_alpha = log_p_alpha(state.log_belief, classes.reshape(len(classes), -1), among.reshape(-1))
        risk = self.risk(situation, ego, predictive)[acting]
        along = [-1 if axis == player else 1 for axis in range(2)]
        score = (
            np.where(among, self.norm.log_weights(costs, among), 0.0)
            + p_alpha.reshape(among.shape)
            - self.risk_weight * risk.reshape(along)
        )
        own = np.where(among, costs[player], 0.0)
        score -= self.delay_weight * (own - costs[player][among].min())
        whole = np.full([len(axis) for axis in situation.game.plans], -np.inf)
        where: list[Any] = [slice(None), slice(None)]
        where[player] = acting
        whole[tuple(where)] = np.where(among, score, -np.inf)
        axes = situation.game.plans
        return Factor(axes, whole).normalize(*(axis.name for axis in axes))
