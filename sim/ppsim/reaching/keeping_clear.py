"""Keeping clear of the human on the way to a goal: a look ahead, and a detour where it is needed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from ppsim.errors import SimulationError
from ppsim.reaching.movement import Movement


@dataclass(frozen=True)
class KeepClear:
    """Swerves where the best way to the goal would come too near to where the human may be by then.

    1. The human is taken to move by LQR towards each goal that has more than `least_probability`, before or after it
       reacts to the robot's goal, whichever is more, or to come to rest: nobody is relied on to make way.
    2. The robot's best way to its goal is taken where it stays `distance` away from all of these for `horizon` steps.
    3. Else ways towards `directions` points on each circle of `radii` about the robot, and one to rest, are looked at.
       Of those that stay clear, the one from whose end the goal costs least, in LQR's cost to go, is taken for this
       step; if there is none, the one whose smallest distance is largest.

    All of it is one array program without chance. Nothing is certified: what the human does may be none of the above;
    `ppinfer.safety` bounds the probability of that.

    Parameters
    ----------
    movement : Movement
        Of both agents.
    distance : float
        In m, between the centres; more than that of a collision.
    horizon : int
        Steps to look ahead.
    least_probability : float
        Goals of the human below this are left out.
    radii : tuple of float
        In m.
    directions : int
        Points on each circle.

    Raises
    ------
    SimulationError
        Where the distance, a radius or a number is not positive.

    Examples
    --------
    The human comes towards the robot; the robot does not go straight to its goal.

    >>> keep = KeepClear(Movement())
    >>> robot, human, goals = np.zeros(2), np.array([2.0, 0.5]), np.array([[3.0, 0.0], [-3.0, 0.0]])
    >>> keep.target(robot, np.zeros(2), goals[0], human, np.zeros(2), goals, np.array([0.1, 0.9])).round(2)
    array([-0., -3.])
    """

    movement: Movement
    distance: float = 1.3
    horizon: int = 12
    least_probability: float = 0.1
    radii: tuple[float, ...] = (1.5, 3.0)
    directions: int = 16

    def __post_init__(self) -> None:
        for name, values in (
            ("distance", (self.distance,)),
            ("horizon", (self.horizon,)),
            ("radii", self.radii),
            ("directions", (self.directions,)),
        ):
            if not values or not all(math.isfinite(value) and value > 0 for value in values):
                raise SimulationError(
                    f"{name} of keeping clear must be positive and finite; got {getattr(self, name)!r}"
                )

    @cached_property
    def _powers(self) -> Float[np.ndarray, "step 2 2"]:
        """F, F^2, ... of one dimension's closed loop: dimensions do not mix."""
        loop = self.movement.agent.closed_loop[:2, :2]
        return np.stack([np.linalg.matrix_power(loop, step) for step in range(1, self.horizon + 1)])

    @cached_property
    def _around(self) -> Float[np.ndarray, "way 2"]:
        angle = np.arange(self.directions) * (2 * np.pi / self.directions)
        circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return np.concatenate([np.zeros((1, 2)), *(radius * circle for radius in self.radii)])

    @cached_property
    def _cost_to_go(self) -> Float[np.ndarray, "2 2"]:
        cost: np.ndarray = self.movement.agent.P[:2, :2]
        return cost

    def ways(
        self,
        position: Float[np.ndarray, " 2"],
        velocity: Float[np.ndarray, " 2"],
        targets: Float[np.ndarray, "way 2"],
    ) -> Float[np.ndarray, "way step 2"]:
        """Return the positions of the next steps on the best way to each target."""
        ways: np.ndarray = (
            targets[:, None]
            + self._powers[:, 0, 0, None] * (position - targets)[:, None]
            + self._powers[:, 0, 1, None] * velocity
        )
        return ways

    def target(
        self,
        position: Float[np.ndarray, " 2"],
        velocity: Float[np.ndarray, " 2"],
        goal: Float[np.ndarray, " 2"],
        human_position: Float[np.ndarray, " 2"],
        human_velocity: Float[np.ndarray, " 2"],
        goals: Float[np.ndarray, "goal 2"],
        probability: Float[np.ndarray, " goal"],
    ) -> Float[np.ndarray, " 2"]:
        """Return the point to move towards in this step: the goal, or that of a way that keeps clear.

        Parameters
        ----------
        position, velocity : (2,) float64
            Of the robot (m, m/s).
        goal : (2,) float64
            Where it wants to go (m); its own position to stay.
        human_position, human_velocity : (2,) float64
            Of the human.
        goals, probability : (goal, 2) and (goal,) float64
            Where the human may be heading.
        """
        likely = goals[probability > self.least_probability]
        human = self.ways(human_position, human_velocity, np.concatenate([likely, human_position[None]]))
        apart = self.ways(position, velocity, goal[None]) - human
        if (apart * apart).sum(axis=-1).min() >= self.distance**2:
            return goal
        targets = position + self._around
        ways = self.ways(position, velocity, targets)
        apart = ways[:, None] - human
        nearest = (apart * apart).sum(axis=-1).min(axis=(1, 2))
        clear = nearest >= self.distance**2
        if not clear.any():
            farthest: np.ndarray = targets[int(nearest.argmax())]
            return farthest
        last = self._powers[-1]
        end = np.stack([ways[:, -1] - goal, last[1, 0] * (position - targets) + last[1, 1] * velocity])
        cost = np.einsum("iws,ij,jws->w", end, self._cost_to_go, end)
        best: np.ndarray = targets[int(np.where(clear, cost, np.inf).argmin())]
        return best
