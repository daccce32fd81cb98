"""Simulated humans, who infer the robot's goal as it moves, by Bayes' rule (22)-(27), and make of it what they will."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from ppinfer.goals import OnlineGoalBelief
from ppinfer.goals.model import require_range
from ppsim.errors import SimulationError
from ppsim.reaching.movement import Movement
from ppsim.reaching.world import Observation

#: Beliefs nearer to one another than this are the same: what rounding makes of even ones is no prediction.
_EVEN = 1e-9


class SimulatedHuman(ABC):
    """What a human makes of where the goals are and of where the robot seems to be heading: one method.

    Examples
    --------
    One who goes for the goal that the robot least seems to want:

    >>> class Shy(SimulatedHuman):
    ...     name = "shy"
    ...     def choose(self, distance, belief):
    ...         return int(belief.argmin())
    >>> Shy().choose(np.array([1.0, 2.0]), np.array([0.3, 0.7]))
    0
    """

    name: ClassVar[str] = "custom"

    @abstractmethod
    def choose(self, distance: Float[np.ndarray, " goal"], belief: Float[np.ndarray, " goal"]) -> int | None:
        """Return the goal to go for now, None to stand.

        Parameters
        ----------
        distance : (goal,) float64
            From the human to each goal (m).
        belief : (goal,) float64
            The human's belief b_H over the robot's goal, which starts even whenever goals are new.
        """


@dataclass(frozen=True)
class WaitingHuman(SimulatedHuman):
    """Stands until it is sure where the robot is heading, or its own goal is free.

    1. Once the most probable goal of the robot has at least `threshold`, it goes for the nearest of the others.
    2. Until then it goes for its nearest goal where that is free, that is where some other goal is more probable to be
       the robot's; else it stands.

    Parameters
    ----------
    threshold : float
        Probability from which on it is sure, in [0, 1].

    Raises
    ------
    ModelError
        Where the threshold is no probability.

    Examples
    --------
    >>> human, distance = WaitingHuman(), np.array([1.0, 2.0, 3.0])
    >>> beliefs = np.array([[1 / 3, 1 / 3, 1 / 3], [0.3, 0.6, 0.1], [0.6, 0.3, 0.1], [0.9, 0.1, 0.0]])
    >>> [human.choose(distance, belief) for belief in beliefs]
    [None, 0, None, 1]
    """

    name: ClassVar[str] = "waiting"

    threshold: float = 0.8

    def __post_init__(self) -> None:
        require_range("threshold", self.threshold, 0.0, 1.0)

    def choose(self, distance: Float[np.ndarray, " goal"], belief: Float[np.ndarray, " goal"]) -> int | None:
        """Return the goal to go for now, None to stand."""
        predicted = int(belief.argmax())
        if belief[predicted] >= self.threshold:
            return nearest_other(distance, predicted)
        own = int(distance.argmin())
        return own if belief[own] < belief[predicted] - _EVEN else None


@dataclass(frozen=True)
class MovingHuman(SimulatedHuman):
    """Heads for its nearest goal at once, and for the next one while it is the nearest that the robot seems to want.

    Examples
    --------
    >>> human, distance = MovingHuman(), np.array([1.0, 2.0, 3.0])
    >>> beliefs = np.array([[1 / 3, 1 / 3, 1 / 3], [0.4, 0.3, 0.3], [0.3, 0.4, 0.3]])
    >>> [human.choose(distance, belief) for belief in beliefs]
    [0, 1, 0]
    """

    name: ClassVar[str] = "moving"

    def choose(self, distance: Float[np.ndarray, " goal"], belief: Float[np.ndarray, " goal"]) -> int | None:
        """Return the goal to go for now."""
        predicted = int(belief.argmax())
        if belief[predicted] - belief.min() <= _EVEN:
            return int(distance.argmin())
        return nearest_other(distance, predicted)


@dataclass(frozen=True)
class StubbornHuman(SimulatedHuman):
    """Heads for its nearest goal, whatever the robot does: it never yields.

    Examples
    --------
    >>> StubbornHuman().choose(np.array([1.0, 2.0]), np.array([0.99, 0.01]))
    0
    """

    name: ClassVar[str] = "stubborn"

    def choose(self, distance: Float[np.ndarray, " goal"], belief: Float[np.ndarray, " goal"]) -> int | None:
        """Return the nearest goal."""
        return int(distance.argmin())


#: Simulated humans by name.
HUMANS: dict[str, type[SimulatedHuman]] = {
    human.name: human for human in (WaitingHuman, MovingHuman, StubbornHuman)
}


def nearest_other(distance: Float[np.ndarray, " goal"], taken: int) -> int:
    """Return the nearest goal but one; that one, where there is no other.

    Examples
    --------
    >>> nearest_other(np.array([1.0, 3.0, 2.0]), 0)
    2
    """
    others = distance.copy()
    others[taken] = math.inf
    return int(others.argmin())


class HumanSeat:
    """Sits a simulated human in the game: it watches the robot, chooses, and moves by LQR.

    1. The belief over the robot's goal (27) is updated with the robot's motion, and starts anew whenever goals do.
    2. The human chooses a goal, or to stand.
    3. It moves by the best control towards it; standing, it brakes. With `noise` its velocity is disturbed besides.

    Parameters
    ----------
    human : SimulatedHuman
        Who chooses.
    movement : Movement, optional
        How it moves, and how rational it takes the robot to be.
    noise : float
        Standard deviation of a disturbance of its velocity, per dimension and step (m/s).

    Attributes
    ----------
    goal : int
        The goal that the latest action was for; -1 where it stands.

    Raises
    ------
    SimulationError
        Where the noise is negative or not finite.

    Examples
    --------
    >>> from ppsim.reaching import ReachingWorld, Rules
    >>> seat = HumanSeat(StubbornHuman())
    >>> seat.reset(np.random.default_rng(0))
    >>> seen = ReachingWorld(Rules(), seat.movement.dynamics).reset(1)["human"]
    >>> seat.act(seen).shape, seat.goal
    ((2,), 0)
    """

    def __init__(
        self, human: SimulatedHuman, movement: Movement | None = None, *, noise: float = 0.0
    ) -> None:
        if not (math.isfinite(noise) and noise >= 0):
            raise SimulationError(f"the human's noise must be finite and not negative (m/s); got {noise!r}")
        self.human = human
        self.movement = movement or Movement()
        self.noise = noise

    @property
    def controller(self) -> str:
        """What the log calls it."""
        return self.human.name

    def reset(self, rng: np.random.Generator) -> None:
        """Begin a game without a goal."""
        self._rng = rng
        self._drawn = -1
        self._belief: OnlineGoalBelief | None = None
        self.goal = -1

    def act(self, observation: Observation) -> Float[np.ndarray, " 2"]:
        """Watch the robot, choose a goal, and move towards it."""
        if self._belief is None:
            labels = [str(goal) for goal in range(len(observation.goals))]
            self._belief = OnlineGoalBelief(self.movement.model, dt=self.movement.dt, labels=labels)
        if observation.drawn != self._drawn:
            self._belief.restart(observation.goals)
            self._drawn = observation.drawn
        (other,) = (agent for agent in observation.position if agent != observation.agent)
        belief = self._belief.observe(
            observation.time, observation.position[other], velocity=observation.velocity[other]
        )
        away = observation.goals - observation.position[observation.agent]
        choice = self.human.choose(np.sqrt((away * away).sum(axis=1)), np.exp(belief.log_values))
        self.goal = -1 if choice is None else choice
        action = self.movement.control(
            observation.state, None if choice is None else observation.goals[choice]
        )
        if self.noise > 0:
            # an acceleration that is held for one step
            action = action + (self.noise / self.movement.dt) * self._rng.standard_normal(2)
        return action


def make_human(kind: str, movement: Movement | None = None, *, noise: float = 0.0) -> HumanSeat:
    """Return the seat of a simulated human.

    Parameters
    ----------
    kind : {"waiting", "moving", "stubborn"}
        Which.
    movement : Movement, optional
        How it moves.
    noise : float
        As in `HumanSeat`.

    Raises
    ------
    SimulationError
        Where there is no such human.

    Examples
    --------
    >>> make_human("moving").controller
    'moving'
    """
    if kind not in HUMANS:
        raise SimulationError(f"there are no humans {kind!r}; there are {', '.join(HUMANS)}")
    return HumanSeat(HUMANS[kind](), movement, noise=noise)
