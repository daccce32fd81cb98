"""The personality posterior, repaired: (5)-(10) with each departure from the paper a parameter."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ppinfer.coordination.classes import FavourBy
from ppinfer.coordination.design import PlayDesign
from ppinfer.coordination.evidence import PlayEvidence
from ppinfer.coordination.norms import check_rationality
from ppinfer.coordination.personality_model import PersonalityModel, PersonalityState
from ppinfer.coordination.reading import Observed, Reading
from ppinfer.coordination.reading_online import observe_anchored
from ppinfer.coordination.situation import Situation
from ppinfer.distributions import Factor
from ppinfer.errors import ModelError
from ppinfer.games.equilibria import Dominance


@dataclass(frozen=True)
class Personality(PersonalityModel):
    """Whom do the others' equilibria favour? Evidence gathers from replan to replan.

    At each replan the motion since the last one is compared with the plans made then:

    1. f_dist(a) is the Euclidean distance, rad, between the others' joint positions and their plans in profile a, over
       the samples every `every` seconds. Steps that a safety stop held do not count; where the motion ended before the
       first such sample, its last executed one does; who has left tells nothing.
    2. The likelihood of a class is the mean over its equilibria of exp(-rationality f_dist(a)).
    3. Scaled to sum to one over the classes, it is contaminated: (1 - e) L + e / (number of classes).
    4. theta moves by its sticky transition, then meets that likelihood.

    Each of the repairs to (5)-(10) can be switched off.

    Parameters
    ----------
    rationality : float
        lambda_alpha of (6), 1/rad.
    contamination : float
        e: the probability that an agent acts, this once, as one of any personality would. Nobody is written off for
        ever. 0 switches it off.
    stay : float
        Probability per replan that theta stays what it is. 1 switches it off.
    every : float
        Seconds between the samples that count.
    observed : {"others", "all"}
        Whose motion counts; "all" is the paper's.
    velocities : bool
        Whether joint velocities, rad/s, are part of a state, as in the paper.
    reanchor : bool
        Compare motion with the plans of the last replan, and accumulate. False: with the plans made at the start of
        the trial, all since then at once (fresh samples drift away from those); then `stay` has nothing to act on.
    average : bool
        The class likelihood is the mean over its equilibria. False: the sum of (9) and (10), which over-weighs the
        class with more of them.
    skip_empty : bool
        A game in which a class is empty tells nothing about that class. False: the empty class could not have caused
        anything that was seen.
    ties : bool
        An equilibrium that costs several agents the same belongs to the class of each. False: to none.
    fair_within : float, optional
        Seconds. Equilibria whose costs lie this close together are a class of their own, ``fair``; others favour whom
        they cost least.
    favour_by : {"cost", "loss"}
        By cost (the paper's), an equilibrium favours whom it costs least: who has the shorter way is often favoured by
        all of them. By loss, it favours whom it costs least more than that agent's own best equilibrium, so that every
        game with a choice tells something. See `favoured_classes`.
    dominance : {"weak", "strict"}
        Which equilibria count; see `coordination_equilibria`.

    Raises
    ------
    ModelError
        If a parameter is out of its range.

    Examples
    --------
    >>> from ppinfer.coordination import Motion, Personality, PlanSet, Situation
    >>> def see(motion=None):
    ...     robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    ...     human = PlanSet("human", [2, 1], [0.0, 2.5, 0.0], [[0.0], [1.0], [0.0]], static=1)
    ...     return Situation.from_contacts([robot, human], [[1.5, np.inf], [np.inf, np.inf]], motion=motion)
    >>> state = Personality().observe(see(), "robot", None)

    The human moves, which is not what one would do who lets the robot go first:

    >>> moved = np.linspace([[0.0], [0.0]], [[0.0], [0.2]], 9)
    >>> motion = Motion(moved, np.zeros_like(moved), np.zeros(9, bool))
    >>> Personality().observe(see(motion), "robot", state).belief.values.round(3)
    array([0.318, 0.682])
    """

    name: ClassVar[str] = "personality"
    rationality: float = 10.0
    contamination: float = 0.04
    stay: float = 0.98
    every: float = 0.8
    observed: Observed = "others"
    velocities: bool = False
    reanchor: bool = True
    average: bool = True
    skip_empty: bool = True
    ties: bool = True
    fair_within: float | None = None
    favour_by: FavourBy = "cost"
    dominance: Dominance = "weak"

    def __post_init__(self) -> None:
        check_rationality("rationality", self.rationality)
        for name in ("contamination", "stay"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ModelError(f"{name} must lie in [0, 1]; got {getattr(self, name)!r}")
        if not 0.0 < self.every < np.inf:
            raise ModelError(f"every must be a positive number of seconds; got {self.every!r}")
        if self.fair_within is not None and not 0.0 <= self.fair_within < np.inf:
            raise ModelError(f"fair_within must be a number of seconds, at least 0; got {self.fair_within!r}")
        for name, choices in (
            ("observed", ("others", "all")),
            ("dominance", ("weak", "strict")),
            ("favour_by", ("cost", "loss")),
        ):
            if getattr(self, name) not in choices:
                raise ModelError(f"{name} is one of {', '.join(choices)}; got {getattr(self, name)!r}")

    @cached_property
    def reading(self) -> Reading:
        """How motion is read as evidence."""
        return Reading(
            self.rationality,
            self.every,
            self.observed,
            self.velocities,
            self.reanchor,
            self.average,
            self.skip_empty,
            self.contamination,
        )

    def accumulates(self) -> bool:
        """Whether evidence gathers from replan to replan: with `reanchor`."""
        return self.reanchor

    def log_likelihood(self, evidence: PlayEvidence) -> Factor:
        """Return the contaminated likelihood at each replan, times the number of classes: 0 says nothing."""
        from ppinfer.coordination.reading_histories import history_log_likelihood

        return evidence.likelihood_factor(
            self.theta(evidence.history.agents), history_log_likelihood(self, self.reading, evidence)
        )

    def observe(self, situation: Situation, ego: str, state: PersonalityState | None) -> PersonalityState:
        """Return what is believed at a replan; `state` is the last replan's, None at the first of a trial."""
        return observe_anchored(self, self.reading, situation, ego, state)

    def simulate(self, design: PlayDesign, rng: np.random.Generator) -> PlayEvidence:
        """Return the design with motion drawn from the model: see `ppinfer.coordination.simulation`."""
        from ppinfer.coordination.simulation import simulate_motion

        return simulate_motion(self, self.reading, design, rng)
