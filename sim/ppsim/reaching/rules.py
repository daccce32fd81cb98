"""The rules of the reaching game, and where its goals and agents may lie."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ppsim.errors import SimulationError

_TRIES = 1000
_NONE = np.zeros((0, 2))


@dataclass(frozen=True)
class Rules:
    """The workspace and what counts in it; lengths in m.

    Parameters
    ----------
    goals : int
        Goals on the table at a time, at least as many as there are agents.
    extent : float
        Goals and starts are drawn uniformly from a square of half-width `extent` about the origin; agents may
        leave it.
    pick_radius : float
        A goal is picked from within this distance.
    separation : float
        Least distance between two goals; more than twice the pick radius, so that nobody is at two goals.
    clearance : float
        Least distance of a new goal, and of another agent's start, from an agent; more than the pick radius.
    collision_distance : float
        Two agents nearer than this collide.
    points : int
        What the team scores when the agents are at distinct goals.

    Raises
    ------
    SimulationError
        Where a value is out of its range, or that many goals do not fit.

    Examples
    --------
    >>> Rules(goals=3).labels
    ('0', '1', '2')
    """

    goals: int = 4
    extent: float = 10.0
    pick_radius: float = 0.5
    separation: float = 3.0
    clearance: float = 2.0
    collision_distance: float = 1.0
    points: int = 2

    def __post_init__(self) -> None:
        for name in ("extent", "pick_radius", "separation", "clearance", "collision_distance"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise SimulationError(f"{name} must be positive and finite (m); got {value!r}")
        if self.goals < 1:
            raise SimulationError(f"goals must be at least 1; got {self.goals}")
        if self.separation <= 2 * self.pick_radius:
            raise SimulationError(
                f"separation {self.separation:g} m must exceed twice the pick radius {self.pick_radius:g} m, or an "
                "agent could be at two goals at once"
            )
        if self.clearance <= self.pick_radius:
            raise SimulationError(
                f"clearance {self.clearance:g} m must exceed the pick radius {self.pick_radius:g} m, or a goal could "
                "appear under an agent"
            )
        # circles of half the separation about every goal, all within the square grown by as much
        room = (2 * self.extent + self.separation) ** 2
        if self.goals * math.pi * (self.separation / 2) ** 2 > 0.5 * room:
            raise SimulationError(
                f"{self.goals} goals {self.separation:g} m apart do not fit into a square of half-width "
                f"{self.extent:g} m; ask for fewer goals or less separation"
            )

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the goals: their numbers."""
        return tuple(str(goal) for goal in range(self.goals))

    def draw_starts(self, rng: np.random.Generator, agents: int) -> Float[np.ndarray, "agent 2"]:
        """Draw where the agents start, at least the clearance apart."""
        return self._scatter(rng, agents, self.clearance, np.zeros((0, 2)), "starts")

    def draw_goals(
        self, rng: np.random.Generator, agents: Float[np.ndarray, "agent 2"]
    ) -> Float[np.ndarray, "goal 2"]:
        """Draw the goals anew: apart from one another, and clear of where the agents are."""
        return self._scatter(rng, self.goals, self.separation, agents, "goals")

    def draw_picked(
        self,
        rng: np.random.Generator,
        goals: Float[np.ndarray, "goal 2"],
        picked: Int[np.ndarray, " picked"],
        agents: Float[np.ndarray, "agent 2"],
    ) -> Float[np.ndarray, "goal 2"]:
        """Draw the goals that were picked anew, apart from those that stay, and clear of where the agents are.

        The new ones take the slots of the old ones.
        """
        staying = np.delete(goals, picked, axis=0)
        drawn = goals.copy()
        drawn[picked] = self._scatter(rng, len(picked), self.separation, agents, "goals", staying)
        return drawn

    def _scatter(
        self,
        rng: np.random.Generator,
        count: int,
        apart: float,
        avoided: Float[np.ndarray, "avoided 2"],
        what: str,
        staying: Float[np.ndarray, "staying 2"] = _NONE,
    ) -> Float[np.ndarray, "count 2"]:
        for _ in range(_TRIES):
            places = rng.uniform(-self.extent, self.extent, (count, 2))
            between = np.linalg.norm(places[:, None] - places, axis=-1)[np.triu_indices(count, 1)]
            away = np.linalg.norm(places[:, None] - avoided, axis=-1)
            beside = np.linalg.norm(places[:, None] - staying, axis=-1)
            if (between >= apart).all() and (away >= self.clearance).all() and (beside >= apart).all():
                return places
        raise SimulationError(
            f"no room was found for {count} {what} {apart:g} m apart in {_TRIES} tries; ask for fewer goals, less "
            "separation or a larger extent"
        )
