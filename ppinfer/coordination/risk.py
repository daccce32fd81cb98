"""Risk-aware choice of an equilibrium, for agents that each consider plans of their own."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from ppinfer.coordination.plans import PlanSet
from ppinfer.coordination.policy import Decision, Policy
from ppinfer.coordination.prediction import PlanPrediction
from ppinfer.coordination.situation import Motion, Situation
from ppinfer.distributions import Axis, Distribution, Factor
from ppinfer.errors import ModelError


@dataclass(frozen=True, eq=False)
class Anticipation:
    """What BayesRisk remembers from one replan to the next: its belief, and what it expected of the other.

    Parameters
    ----------
    belief : Distribution
        Over ``theta``.
    predictive : Distribution
        Of the other agent's plan, given ``theta``.
    plans : PlanSet
        The other agent's plans.
    """

    belief: Distribution
    predictive: Distribution
    plans: PlanSet


@dataclass(frozen=True)
class BayesRisk(Policy):
    """The equilibrium that is best for somebody, likely for the other's personality, and unlikely to end in a stop.

    1. `PlanPrediction` gives W(j | theta), a distribution over the other agent's plans.
    2. p(theta) moves by a sticky transition and is updated by L(theta) = sum_j W(j | theta) exp(-lambda |q - tau_j|),
       with the last replan's W and the other agent's joint positions at the end of what was executed.
    3. The risk of an own plan i is r(i) = sum_theta p(theta) sum_j W(j | theta) g(t_ij), with t_ij the time of first
       contact and g = 1 until `sure_until`, then falling as exp(-(t - sure_until) / `fade`).
    4. Among the collision-free, undominated equilibria of few own plans against all of the other's, the one with the
       largest -norm_rationality min_i c_i + log p_alpha - risk_weight r - delay_weight (c_ego - min c_ego).

    Parameters
    ----------
    samples : int
        Plans sampled for each agent, besides the static one.
    acting : int
        How many of its own sampled plans the agent chooses among, besides the static one.
    commits : bool
        Whether the rest of the unfinished plan is one of these.
    prediction : PlanPrediction
        Where W comes from.
    rationality : float
        lambda, 1/rad.
    contamination : float
        Share of each update's likelihood that says nothing: nobody is written off for ever.
    stay : float
        Probability per replan that theta stays what it is.
    norm_rationality, delay_weight : float
        1/s.
    risk_weight : float
        Price of a certain contact, in units of log probability.
    sure_until, fade : float
        Seconds.

    Raises
    ------
    ModelError
        If a parameter is out of its range, or a situation has more than two agents or no contact times.
    """

    name: ClassVar[str] = "bayes-risk"
    samples: int = 24
    acting: int = 7
    commits: bool = True
    prediction: PlanPrediction = field(default_factory=PlanPrediction)
    rationality: float = 10.0
    contamination: float = 0.04
    stay: float = 0.98
    norm_rationality: float = 1.0
    delay_weight: float = 0.1
    risk_weight: float = 20.0
    sure_until: float = 0.9
    fade: float = 4.0

    def decide(self, situation: Situation, ego: str, memory: Anticipation | None = None) -> Decision:
        """Return what `ego` does; `memory` is the Anticipation of its last decision."""
        own = situation.player(ego)
        if len(situation.plans) != 2:
            raise ModelError(f"bayes-risk is for two agents; there are {len(situation.plans)}")
        if situation.contact_time is None:
            raise ModelError("bayes-risk weighs risk: give the situation's contact_time")
        belief = self.believed(situation, ego, memory)
        predictive = self.prediction.predict(situation, ego)
        other = situation.plans[1 - own]
        expected = (belief * predictive).sum("theta").values
        contact = situation.contact_time if own == 0 else situation.contact_time.T
        risk = self.risk(contact, expected)
        remembered = Anticipation(belief, predictive, other)
        ego_plans = situation.plans[own]
        acting = np.array(
            [plan for plan in range(len(ego_plans)) if plan != ego_plans.static][: self.acting]
            + ([] if ego_plans.static is None else [ego_plans.static])
        )
        scores = self._scores(situation, own, acting, belief, risk)
        told = Distribution.from_probabilities([other.axis], expected / expected.sum())
        return self._decision(situation, own, scores, belief, told, remembered)

    def believed(self, situation: Situation, ego: str, memory: Anticipation | None) -> Distribution:
        """Return p(theta) after what was seen since the last replan."""
        if memory is None:
            return Distribution.uniform(Axis("theta", situation.agents))
        seen = last_seen(situation.motion, situation.player(memory.plans.agent))
        prior = memory.belief.values
        stay = self.stay
        moved = stay * prior + (1.0 - stay) * prior[::-1]
        if seen is not None:
            when, where = seen
            distance = np.linalg.norm(memory.plans.positions([when])[:, 0] - where, axis=-1)
            likelihood = memory.predictive.values @ np.exp(-self.rationality * (distance - distance.min()))
            likelihood = (1.0 - self.contamination) * likelihood / likelihood.sum() + self.contamination / 2.0
            moved = moved * likelihood
        return Distribution.from_probabilities(memory.belief.axes, moved / moved.sum())

    def risk(
        self, contact_time: Float[np.ndarray, "own other"], expected: Float[np.ndarray, " other"]
    ) -> Float[np.ndarray, " own"]:
        """Return the risk of each own plan under a distribution over the other agent's plans."""
        after = np.maximum(contact_time - self.sure_until, 0.0)
        risk: np.ndarray = np.exp(-after / self.fade) @ expected
        return risk

    def _scores(self, situation, own, acting, belief, risk):
        from ppinfer.games.scans import pure_mask2, undominated_mask2

        costs = situation.game.costs if own == 0 else situation.game.costs.transpose(0, 2, 1)
        order = [own, 1 - own]
        few = np.ascontiguousarray(costs[np.ix_(order, acting)])[None]
        mask = pure_mask2(few) & np.isfinite(few).all(axis=1)
        mask = undominated_mask2(few, mask, False)[0]
        scores = np.full(costs.shape[1:], -math.inf)
        if not mask.any():
            return scores
        c_own, c_other = few[0]
        favours = np.stack([c_own <= c_other, c_other <= c_own]) & mask
        count = favours.sum(axis=(1, 2))
        p_theta = belief.values[order]
        share = np.where(count > 0, p_theta / np.maximum(count, 1), 0.0)
        p_alpha = np.einsum("t,tij->ij", share, favours)
        with np.errstate(divide="ignore"):
            value = (
                -self.norm_rationality * np.minimum(c_own, c_other)
                + np.log(p_alpha)
                - self.risk_weight * risk[acting][:, None]
                - self.delay_weight * (c_own - c_own[mask].min())
            )
        scores[acting] = np.where(mask, value, -math.inf)
        return scores

    def _decision(self, situation, own, scores, belief, predictive, remembered):
        ego_plans = situation.plans[own]
        if not np.isfinite(scores).any():
            hold = len(ego_plans) - 1 if ego_plans.static is None else ego_plans.static
            point = np.zeros(len(ego_plans))
            point[hold] = 1.0
            alone = Distribution.from_probabilities([ego_plans.axis], point)
            return Decision(hold, alone, None, belief, predictive, remembered)
        best = np.unravel_index(int(np.argmax(scores)), scores.shape)
        grid = scores if own == 0 else scores.T
        distribution = Factor(situation.game.plans, grid).normalize(*(axis.name for axis in situation.game.plans))
        profile = (int(best[0]), int(best[1]))
        return Decision(
            profile[0], distribution, profile if own == 0 else profile[::-1], belief, predictive, remembered
        )


def last_seen(motion: Motion | None, agent: int) -> tuple[float, Float[np.ndarray, " joint"]] | None:
    """Return when, s since the last replan, and where an agent was last seen moving freely; None if it was not.

    A step that a safety stop held says nothing of what anybody meant to do.
    """
    if motion is None:
        return None
    executed = np.flatnonzero(~motion.held[1:]) + 1
    if not len(executed):
        return None
    where = motion.position[executed[-1], agent]
    if np.isnan(where).any():
        return None
    return float(len(executed) * motion.dt), where
