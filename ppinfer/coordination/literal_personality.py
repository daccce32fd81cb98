"""The personality posterior as the paper prints it, (5)-(10)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.coordination.classes import favoured_classes
from ppinfer.coordination.design import PlayDesign
from ppinfer.coordination.evidence import PlayEvidence
from ppinfer.coordination.norms import check_rationality
from ppinfer.coordination.personality_model import PersonalityModel, PersonalityState
from ppinfer.coordination.reading import Reading
from ppinfer.coordination.reading_online import observe_anchored
from ppinfer.coordination.situation import Situation
from ppinfer.distributions import Factor
from ppinfer.games.equilibria import Dominance


@dataclass(frozen=True)
class LiteralPersonality(PersonalityModel):
    """(5)-(10) to the letter, to be compared with; `Personality` repairs what does not hold.

    1. The states (joint positions, rad, and velocities, rad/s) of all agents at every sample since the trial began,
       that of the replan included, are compared with the profiles a^0 planned at its start; a plan that has ended
       stays at its last state. f_dist is their Euclidean distance, and p(a^0 | H) (6) is normalised over the
       equilibria of that game.
    2. Equilibria with c_1 < c_2 favour agent 1, those with c_2 < c_1 agent 2, of which each is equally likely (8); one
       with c_1 = c_2 belongs to no class.
    3. p(theta | H) = sum over a^0 of p(a^0 | H) p(theta | a^0) (9), (10). Where (10) is 0 / 0 it says nothing about
       theta.
    4. p_alpha at the start of a trial is uniform (5).

    If all equilibria of the first game favour one agent, theta is certain from the start, whatever anybody does.

    Parameters
    ----------
    rationality : float
        lambda_alpha of (6).
    dominance : {"weak", "strict"}
        Which equilibria count; "strict" is the paper's. See `coordination_equilibria`.

    Raises
    ------
    ModelError
        If a parameter is out of its range.

    Examples
    --------
    >>> from ppinfer.coordination import LiteralPersonality, PlanSet, Situation
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [1], [0.0], [[0.0]], static=0)
    >>> situation = Situation.from_contacts([robot, human], [[np.inf], [np.inf]])
    >>> LiteralPersonality().observe(situation, "robot", None).belief.values
    array([0., 1.])
    """

    name: ClassVar[str] = "personality-literal"
    rationality: float = 10.0
    dominance: Dominance = "weak"

    def __post_init__(self) -> None:
        check_rationality("rationality", self.rationality)

    @cached_property
    def reading(self) -> Reading:
        """How motion is read as evidence."""
        return Reading(
            self.rationality,
            every=None,
            observed="all",
            velocities=True,
            reanchor=False,
            average=False,
            skip_empty=False,
            contamination=0.0,
        )

    def favoured(
        self, costs: Float[np.ndarray, "player ..."], among: Bool[np.ndarray, "..."]
    ) -> Bool[np.ndarray, "theta ..."]:
        """Return which profiles belong to the class of each theta; ties belong to none."""
        return favoured_classes(costs, among, ties=False)

    def accumulates(self) -> bool:
        """Beliefs are inferred each time from all that was seen."""
        return False

    def log_likelihood(self, evidence: PlayEvidence) -> Factor:
        """Return log p(theta | H) of (9), up to a constant."""
        from ppinfer.coordination.reading_histories import history_log_likelihood

        return evidence.likelihood_factor(
            self.theta(evidence.history.agents), history_log_likelihood(self, self.reading, evidence)
        )

    def observe(self, situation: Situation, ego: str, state: PersonalityState | None) -> PersonalityState:
        """Return what is believed at a replan; `state` is the last replan's, None at the first of a trial."""
        return observe_anchored(self, self.reading, situation, ego, state, uninformed_at_first=True)

    def simulate(self, design: PlayDesign, rng: np.random.Generator) -> PlayEvidence:
        """Return the design with motion drawn from the model: see `ppinfer.coordination.simulation`."""
        from ppinfer.coordination.simulation import simulate_motion

        return simulate_motion(self, self.reading, design, rng)
