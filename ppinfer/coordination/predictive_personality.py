"""Whom the other agent's equilibria favour, when each agent considers plans of its own."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from jaxtyping import Float, Int

from ppinfer.coordination.design import PlayDesign
from ppinfer.coordination.equilibria import coordination_equilibria
from ppinfer.coordination.evidence import PlayEvidence
from ppinfer.coordination.norms import check_rationality
from ppinfer.coordination.personality_model import PersonalityModel, PersonalityState
from ppinfer.coordination.plans import PlanSet
from ppinfer.coordination.prediction import PlanPrediction
from ppinfer.coordination.reading import Reading
from ppinfer.coordination.situation import Motion, Situation
from ppinfer.distributions import Distribution, Factor
from ppinfer.errors import ModelError
from ppinfer.games.equilibria import Dominance


@dataclass(frozen=True, eq=False)
class Expectation:
    """What was expected of the other agent at a replan.

    Parameters
    ----------
    predictive : Distribution
        Over the other agent's plans, given ``theta``.
    plans : PlanSet
        These plans.
    """

    predictive: Distribution
    plans: PlanSet


@dataclass(frozen=True)
class PredictivePersonality(PersonalityModel):
    """Evidence from where the other agent went, against a prediction over many plans it might have had in mind.

    At each replan `PlanPrediction` gives W(j | theta). At the next one

        L(theta) = sum_j W(j | theta) exp(-rationality |q - tau_j|),

    with q the other agent's joint position after the last executed step (a step that a safety stop held tells nothing),
    and tau_j where plan j would be by then. Scaled to sum to one, it is contaminated as in `Personality`.

    Parameters
    ----------
    prediction : PlanPrediction
        Where W comes from.
    rationality : float
        lambda_alpha, 1/rad.
    contamination : float
        Share of each update's likelihood that says nothing: nobody is written off for ever.
    stay : float
        Probability per replan that theta stays what it is.

    Raises
    ------
    ModelError
        If a parameter is out of its range, or there are more than two agents.

    Examples
    --------
    >>> from ppinfer.coordination import PlanSet, PredictivePersonality, Situation
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [2, 1], [0.0, 2.5, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> situation = Situation.from_contacts([robot, human], [[1.5, np.inf], [np.inf, np.inf]])
    >>> state = PredictivePersonality().observe(situation, "robot", None)
    >>> state.memory.predictive.prob(theta="human", human_plan=0)
    1.0
    """

    name: ClassVar[str] = "personality-predictive"
    prediction: PlanPrediction = field(default_factory=PlanPrediction)
    rationality: float = 10.0
    contamination: float = 0.04
    stay: float = 0.98
    dominance: Dominance = "weak"

    def __post_init__(self) -> None:
        check_rationality("rationality", self.rationality)
        for name in ("contamination", "stay"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ModelError(f"{name} must lie in [0, 1]; got {getattr(self, name)!r}")

    def observe(self, situation: Situation, ego: str, state: PersonalityState | None) -> PersonalityState:
        """Return what is believed at a replan, and in its memory what is expected of the other agent until the next."""
        log_belief = self._moved(situation, state)
        if state is not None:
            expected: Expectation = state.memory
            player = situation.player(expected.plans.agent)
            log_belief = log_belief + self._learned(expected, situation.motion, player)
        expectation = self.expect(situation, ego)
        equilibria = coordination_equilibria(situation.game, self.dominance).log_values > -np.inf
        return self._state_among(situation, log_belief, equilibria, expectation)

    def expect(self, situation: Situation, ego: str) -> Expectation:
        """Return what the other agent may do from a replan on."""
        predictive = self.prediction.predict(situation, ego)
        return Expectation(predictive, situation.plans[1 - situation.player(ego)])

    def log_likelihood(self, evidence: PlayEvidence) -> Factor:
        """Return the contaminated likelihood at each replan, times the number of classes: 0 says nothing.

        Each replan draws its sub-games from its own seed, so it goes from replan to replan.
        """
        history = evidence.history
        theta = self.theta(history.agents)
        log_likelihood = np.zeros((len(evidence.replans), len(theta)))
        expected: Expectation | None = None
        for row, (replan, first) in enumerate(zip(evidence.replans, evidence.first, strict=True)):
            trial = int(history.trial_of_replan[replan])
            situation = history.situation(trial, int(replan - history.replan_start[trial]))
            if row != first and expected is not None:
                log_likelihood[row] = self._learned(expected, situation.motion, 1 - evidence.player)
            expected = self.expect(situation, evidence.ego)
        return evidence.likelihood_factor(theta, log_likelihood)

    def simulate(self, design: PlayDesign, rng: np.random.Generator) -> PlayEvidence:
        """Return the design with motion drawn from the model: plans from W, and noise about where they lead."""
        from ppinfer.coordination.simulation import simulate_motion

        evidence, history = design.evidence, design.evidence.history

        def played(anchor: Int[np.ndarray, " replan"]) -> Int[np.ndarray, "replan agent"]:
            chosen = np.zeros((len(anchor), 2), np.int64)
            for place, row in enumerate(anchor):
                replan = int(evidence.replans[row])
                trial = int(history.trial_of_replan[replan])
                situation = history.situation(trial, replan - int(history.replan_start[trial]))
                astray = rng.random() < self.contamination
                theta = int(rng.integers(2)) if astray else int(design.theta[row])
                weights = self.expect(situation, evidence.ego).predictive.values[theta]
                chosen[place, 1 - evidence.player] = rng.choice(len(weights), p=weights / weights.sum())
            return chosen

        # only the last executed sample of an interval counts, however long it is
        reading = Reading(self.rationality, 1e9, "others", False, True, True, True, self.contamination)
        return simulate_motion(self, reading, design, rng, played)

    def _learned(
        self, expected: Expectation, motion: Motion | None, player: int
    ) -> Float[np.ndarray, " theta"]:
        """Return the log likelihood of the motion since a replan, up to a constant."""
        seen = last_seen(motion, player)
        if seen is None:
            return np.zeros(2)
        when, where = seen
        distance = np.linalg.norm(expected.plans.positions([when])[:, 0] - where, axis=-1)
        # a plan that no theta would have may be the nearest: those that one may have set the scale
        weights = expected.predictive.values
        nearest = distance[(weights > 0.0).any(axis=0)].min()
        with np.errstate(under="ignore", over="ignore"):
            likelihood = np.where(
                weights > 0.0, weights * np.exp(-self.rationality * (distance - nearest)), 0.0
            ).sum(axis=1)
        total = likelihood.sum()
        shares: np.ndarray = (1.0 - self.contamination) * likelihood / total + self.contamination / 2.0
        with np.errstate(divide="ignore"):
            return np.log(2.0 * shares)


def last_seen(motion: Motion | None, player: int) -> tuple[float, Float[np.ndarray, " joint"]] | None:
    """Return when, s of executed motion since the last replan, and where an agent was seen last; None: it was not.

    A step that a safety stop held says nothing of what anybody meant to do.
    """
    if motion is None:
        return None
    executed = np.flatnonzero(~motion.held[1:]) + 1
    if not len(executed):
        return None
    where = motion.position[executed[-1], player]
    if np.isnan(where).any():
        return None
    return float(len(executed) * motion.dt), where
