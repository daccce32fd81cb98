"""Which goal an agent goes for: small policies that any seat can hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.goals.model import require_range
from ppsim.reaching.world import Observation


@runtime_checkable
class GoalChoice(Protocol):
    """Chooses a goal, and chooses again as the game goes on."""

    @property
    def name(self) -> str:
        """What the log calls it."""
        ...

    def choose(self, seen: Observation, current: int | None, rng: np.random.Generator) -> int:
        """Return the goal to go for now; `current` is None where the goals are new."""
        ...


def taken_goals(seen: Observation, radius: float) -> Bool[np.ndarray, " goal"]:
    """Return which goals another agent is at, within `radius` (m)."""
    taken = np.zeros(len(seen.goals), dtype=bool)
    for agent, position in seen.position.items():
        if agent != seen.agent:
            taken |= np.linalg.norm(seen.goals - position, axis=1) <= radius
    return taken


@dataclass(frozen=True)
class _Keeping:
    """Keeps a goal until the goals are new or, if it yields, until another agent is there.

    Two agents who want the same goal get it sooner or later if one yields and the other does not.

    Parameters
    ----------
    yields : bool
        Whether goals that another agent is at are left to it.
    radius : float
        From which distance (m) an agent is at a goal: the pick radius.
    """

    yields: bool = True
    radius: float = 0.5

    def choose(self, seen: Observation, current: int | None, rng: np.random.Generator) -> int:
        """Return the goal to go for now."""
        taken = taken_goals(seen, self.radius) if self.yields else np.zeros(len(seen.goals), dtype=bool)
        if current is not None and not taken[current]:
            return current
        distance = np.linalg.norm(seen.goals - seen.position[seen.agent], axis=1)
        return self._draw(np.where(taken, np.inf, distance), rng)

    def _draw(self, distance: Float[np.ndarray, " goal"], rng: np.random.Generator) -> int:
        raise NotImplementedError


@dataclass(frozen=True)
class NearestGoal(_Keeping):
    """The nearest goal.

    Examples
    --------
    >>> NearestGoal(yields=False).name
    'nearest-goal'
    """

    name: ClassVar[str] = "nearest-goal"

    def _draw(self, distance: Float[np.ndarray, " goal"], rng: np.random.Generator) -> int:
        return int(np.argmin(distance))


@dataclass(frozen=True)
class NearGoal(_Keeping):
    """A goal drawn with probability proportional to exp(-distance / scale): near ones are preferred, as people do.

    Parameters
    ----------
    scale : float
        In m.
    """

    scale: float = 4.0
    name: ClassVar[str] = "near-goal"

    def _draw(self, distance: Float[np.ndarray, " goal"], rng: np.random.Generator) -> int:
        weight = np.exp((distance.min() - distance) / self.scale)
        return int(rng.choice(len(weight), p=weight / weight.sum()))


@dataclass(frozen=True)
class RandomGoal(_Keeping):
    """Any goal, with equal chances."""

    name: ClassVar[str] = "random-goal"

    def _draw(self, distance: Float[np.ndarray, " goal"], rng: np.random.Generator) -> int:
        return int(rng.choice(np.flatnonzero(np.isfinite(distance))))


@dataclass(frozen=True)
class ChangingMind:
    """Another policy's choice, given up at each sample with probability 1 - stay for any other goal.

    Parameters
    ----------
    choice : GoalChoice
        The policy.
    stay : float
        Probability per sample that the goal stays what it is, as in the goal models.

    Examples
    --------
    >>> ChangingMind(NearestGoal(), stay=0.99).name
    'nearest-goal'
    """

    choice: GoalChoice
    stay: float

    def __post_init__(self) -> None:
        require_range("stay", self.stay, 0.0, 1.0)

    @property
    def name(self) -> str:
        """What the log calls it: the policy's own name."""
        return self.choice.name

    def choose(self, seen: Observation, current: int | None, rng: np.random.Generator) -> int:
        """Return the goal to go for now."""
        if current is not None and len(seen.goals) > 1 and rng.random() >= self.stay:
            other = int(rng.integers(len(seen.goals) - 1))
            current = other + (other >= current)
        return self.choice.choose(seen, current, rng)


GOAL_CHOICES: dict[str, type[NearestGoal] | type[NearGoal] | type[RandomGoal]] = {
    choice.name: choice for choice in (NearestGoal, NearGoal, RandomGoal)
}
"""Policies by name, for commands."""
