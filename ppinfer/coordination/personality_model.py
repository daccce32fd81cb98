"""What a model of personality is: a likelihood over theta with its generative twin, online and offline."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.coordination.classes import FAIR, FavourBy, favoured_classes, log_p_alpha
from ppinfer.coordination.design import PlayDesign
from ppinfer.coordination.equilibria import coordination_equilibria
from ppinfer.coordination.evidence import PlayEvidence
from ppinfer.coordination.history import PlayHistory
from ppinfer.coordination.situation import Situation
from ppinfer.distributions import Axis, Distribution, Factor
from ppinfer.distributions.logspace import log_of
from ppinfer.errors import ImpossibleEvidenceError
from ppinfer.games import Game
from ppinfer.games.equilibria import Dominance


@dataclass(frozen=True, eq=False)
class PersonalityState:
    """What is believed of a personality at a replan, and what the next one needs to know.

    Parameters
    ----------
    theta : Axis
        Whom equilibria may favour.
    log_belief : (theta,) float64
        log p(theta) after all that was seen.
    game : Game
        The game of this replan.
    equilibria : (*plans) bool
        Its equilibria that agents may coordinate on.
    classes : (theta, *plans) bool
        Which of them favour whom.
    uninformed : bool
        Whether p_alpha is uniform whatever the classes (5).
    memory : object
        The model's own.
    """

    theta: Axis
    log_belief: Float[np.ndarray, " theta"]
    game: Game
    equilibria: Bool[np.ndarray, "..."]
    classes: Bool[np.ndarray, "theta ..."]
    uninformed: bool = False
    memory: Any = None

    @property
    def belief(self) -> Distribution:
        """p(theta)."""
        return Distribution._sound((self.theta,), self.log_belief, ("random",))

    @cached_property
    def log_p_alpha(self) -> Float[np.ndarray, "..."]:
        """Log p_alpha(a) of (7) and (8) over the profiles, -inf where there is no equilibrium."""
        among = self.equilibria.reshape(-1)
        if self.uninformed:
            flat = np.where(among, -math.log(max(1, int(among.sum()))), -np.inf)
        else:
            flat = log_p_alpha(self.log_belief, self.classes.reshape(len(self.theta), -1), among)
        return flat.reshape(self.equilibria.shape)

    @property
    def p_alpha(self) -> Distribution:
        """Over the profiles: how probable each equilibrium is for what is believed of the personality (7).

        Raises
        ------
        ImpossibleEvidenceError
            If the game has no equilibrium to choose.
        """
        return Factor(self.game.plans, np.where(self.equilibria, self.log_p_alpha, -np.inf)).normalize(
            *(axis.name for axis in self.game.plans)
        )


class PersonalityModel(ABC):
    """A likelihood over theta, whom an agent's equilibria favour; subclasses are small frozen dataclasses.

    A subclass defines `log_likelihood` and `simulate`. That is enough for offline inference (`infer_personality`)
    and for `BayesNash`, which sees one situation at a time; both give the same numbers.
    `ppinfer.testing.check_personality` holds a subclass to that and to the laws.

    Attributes
    ----------
    stay : float
        Probability per replan that theta stays what it is; else it becomes any other, evenly.
    window : int or None
        How many replans the likelihood looks at, the last one included; None: all since the trial began.
    dominance : {"weak", "strict"}
        Which equilibria count; see `coordination_equilibria`.

    Examples
    --------
    A model of one's own: whoever has moved further since the last replan is favoured.

    >>> from dataclasses import dataclass
    >>> from ppinfer.coordination import PersonalityModel
    >>> @dataclass(frozen=True)
    ... class Busy(PersonalityModel):
    ...     def log_likelihood(self, evidence):
    ...         position = evidence.history.position[evidence.sample]
    ...         moved = np.zeros((len(position), len(evidence.history.agents)))
    ...         moved[1:] = np.linalg.norm(position[1:] - position[:-1], axis=-1)
    ...         moved[evidence.first] = 0.0
    ...         return evidence.likelihood_factor(self.theta(evidence.history.agents), moved)
    ...     def simulate(self, design, rng):
    ...         raise NotImplementedError
    """

    name: ClassVar[str] = "custom"
    stay: float = 1.0
    window: int | None = 2
    dominance: Dominance = "weak"
    fair_within: float | None = None
    ties: bool = True
    favour_by: FavourBy = "cost"

    @abstractmethod
    def log_likelihood(self, evidence: PlayEvidence) -> Factor:
        """Return how likely what was seen up to each replan is under each theta, a Factor over (replan, theta).

        What was seen since the replan before where beliefs accumulate; all since the trial began where not. Up to a
        constant for each replan; 0 where there is nothing to learn, as at the first replan of a trial.
        """

    @abstractmethod
    def simulate(self, design: PlayDesign, rng: np.random.Generator) -> PlayEvidence:
        """Return evidence drawn from the model for the personalities in `design`."""

    def accumulates(self) -> bool:
        """Whether the belief is built up replan by replan, or is inferred each time from all that was seen."""
        return True

    def theta(self, agents: Sequence[str]) -> Axis:
        """Return the axis of personalities: whom equilibria favour, and ``fair`` where that is a class."""
        return _theta_axis(tuple(agents), self.fair_within is not None)

    def favoured(
        self, costs: Float[np.ndarray, "player ..."], among: Bool[np.ndarray, "..."]
    ) -> Bool[np.ndarray, "theta ..."]:
        """Return which profiles belong to the class of each theta; see `favoured_classes`."""
        return favoured_classes(
            costs, among, ties=self.ties, fair_within=self.fair_within, favour_by=self.favour_by
        )

    def observe(self, situation: Situation, ego: str, state: PersonalityState | None) -> PersonalityState:
        """Return what is believed at a replan; `state` is the last replan's, None at the first of a trial."""
        seen = () if state is None else state.memory
        seen = (*seen, situation)
        if self.window is not None:
            seen = seen[-self.window :]
        evidence = PlayHistory.from_situations([seen], ego).seen_by(ego)
        log_likelihood = self.log_likelihood(evidence).log_values[-1]
        return self._state(situation, self._moved(situation, state) + log_likelihood, seen)

    def _moved(self, situation: Situation, state: PersonalityState | None) -> Float[np.ndarray, " theta"]:
        """Return log p(theta) before this replan's evidence: what was believed, one sticky step on."""
        if state is None or not self.accumulates():
            count = len(self.theta(situation.agents))
            return np.full(count, -np.log(count))
        if self.stay == 1.0:
            return state.log_belief
        moves = state.log_belief[:, None] + self._log_transition(len(state.log_belief))
        moved: np.ndarray = np.logaddexp.reduce(moves, axis=0)
        return moved

    def _log_transition(self, count: int) -> Float[np.ndarray, "theta next_theta"]:
        """Return the log of the sticky transition."""
        return _log_sticky(self.stay, count)

    def _state(
        self,
        situation: Situation,
        log_belief: Float[np.ndarray, " theta"],
        memory: Any,
        *,
        uninformed: bool = False,
    ) -> PersonalityState:
        """Return the state for a belief that is yet to be normalised."""
        game = situation.game
        equilibria = coordination_equilibria(game, self.dominance).log_values > -np.inf
        return self._state_among(situation, log_belief, equilibria, memory, uninformed=uninformed)

    def _state_among(
        self,
        situation: Situation,
        log_belief: Float[np.ndarray, " theta"],
        equilibria: Bool[np.ndarray, "..."],
        memory: Any,
        *,
        classes: Bool[np.ndarray, "theta ..."] | None = None,
        uninformed: bool = False,
    ) -> PersonalityState:
        peak = log_belief.max()
        if not np.isfinite(peak):
            raise ImpossibleEvidenceError(
                f"no personality is possible at {situation.time:g} s of the trial: each was ruled out there or before. "
                "Give `contamination` some share of the evidence, or `stay` less than 1"
            )
        belief = log_belief - peak
        belief = belief - np.log(np.exp(belief).sum())
        belief.setflags(write=False)
        if classes is None:
            classes = self.favoured(situation.game.costs, equilibria)
        theta = self.theta(situation.agents)
        return PersonalityState(theta, belief, situation.game, equilibria, classes, uninformed, memory)


@lru_cache(maxsize=16)
def _log_sticky(stay: float, count: int) -> Float[np.ndarray, "theta next_theta"]:
    transition = np.full((count, count), (1.0 - stay) / (count - 1))
    np.fill_diagonal(transition, stay)
    return log_of(transition)


@lru_cache(maxsize=16)
def _theta_axis(agents: tuple[str, ...], fair: bool) -> Axis:
    return Axis("theta", [*agents, *([FAIR] if fair else [])])
