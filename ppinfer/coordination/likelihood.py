"""How likely motion is if everybody follows a profile: (6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from ppinfer.coordination.distances import Distance, Euclidean
from ppinfer.coordination.norms import check_rationality
from ppinfer.coordination.plans import PlanSet
from ppinfer.coordination.situation import Motion
from ppinfer.distributions import Factor
from ppinfer.errors import ModelError


@dataclass(frozen=True)
class TrajectoryLikelihood:
    """p(a | H) proportional to exp(-rationality f_dist(a, H)) (6): motion follows the plans, more or less.

    Parameters
    ----------
    rationality : float
        lambda_alpha, one over the unit of the distance.
    distance : Distance
        f_dist: `Euclidean` as in the paper, `RootMeanSquare`, `TimeWarping`, or one of your own.
    velocities : bool
        Whether a state is joint positions, rad, and velocities, rad/s, as in the paper, or positions alone.

    Raises
    ------
    ModelError
        If the rationality is out of its range.

    Examples
    --------
    >>> from ppinfer.coordination import Motion, PlanSet, TrajectoryLikelihood
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [2, 1], [0.0, 4.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> moved = np.linspace([[0.0], [0.0]], [[0.5], [0.0]], 11)
    >>> motion = Motion(moved, np.zeros_like(moved), np.zeros(11, bool))
    >>> likelihood = TrajectoryLikelihood(velocities=False).log_likelihood([robot, human], motion)
    >>> likelihood.normalize("robot_plan", "human_plan").mode()
    {'robot_plan': 0, 'human_plan': 1}
    """

    rationality: float = 10.0
    distance: Distance = field(default_factory=Euclidean)
    velocities: bool = True

    def __post_init__(self) -> None:
        check_rationality("rationality", self.rationality)

    def log_likelihood(self, plans: Sequence[PlanSet], motion: Motion, *agents: str) -> Factor:
        """Return log p(H | a), up to a constant, over the plan axes.

        Parameters
        ----------
        plans : sequence of PlanSet
            Of every agent, in the order of the motion's agent dimension.
        motion : Motion
            Since these plans were made, all of its samples. Those in which an agent is missing tell nothing.
        *agents : str
            Whose motion counts; everybody's if none is named. The result is constant in the plans of the others.

        Returns
        -------
        Factor
            Normalise it over the plan axes, within the equilibria, for p(a | H).
        """
        every = [own.agent for own in plans]
        for agent in agents:
            if agent not in every:
                raise ModelError(f"there is no agent {agent!r}; there are {', '.join(every)}")
        watched = [place for place, own in enumerate(plans) if not agents or own.agent in agents]
        states = np.concatenate(
            [self._states(motion.position, motion.velocity, place) for place in watched], axis=1
        )
        known = ~np.isnan(states).any(axis=1)
        axes = [plans[place].axis for place in watched]
        shape = tuple(len(axis) for axis in axes)
        whole = [own.axis for own in plans]
        if not known.any():
            return Factor(whole, np.zeros([len(axis) for axis in whole]))
        times = np.flatnonzero(known) * motion.dt
        choice = np.stack([place.ravel() for place in np.indices(shape)])
        sequences = np.concatenate(
            [
                self._sequences(plans[place], times)[chosen]
                for place, chosen in zip(watched, choice, strict=True)
            ],
            axis=2,
        )
        far = self.distance.between(sequences, states[known]).reshape(shape)
        return Factor(axes, -self.rationality * far).align(*whole)

    def _states(
        self,
        position: Float[np.ndarray, "time agent joint"],
        velocity: Float[np.ndarray, "time agent joint"],
        agent: int,
    ) -> Float[np.ndarray, "time state"]:
        parts = [position[:, agent], velocity[:, agent]] if self.velocities else [position[:, agent]]
        return np.concatenate(parts, axis=1)

    def _sequences(
        self, own: PlanSet, times: Float[np.ndarray, " time"]
    ) -> Float[np.ndarray, "plan time state"]:
        where, speed = own._sampled(times)
        return np.concatenate([where, speed], axis=2) if self.velocities else where
