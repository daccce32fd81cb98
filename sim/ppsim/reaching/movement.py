"""How agents of the reaching game move: dynamics, LQR towards a goal, and how rational each takes the other to be."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from ppinfer.goals import Dynamics, GoalLQR, NoisilyRational


@dataclass(frozen=True)
class Movement:
    """What both agents are in the game of the study: double integrators under LQR control, without limits.

    Parameters
    ----------
    dt : float
        Time step (s).
    state_weight, control_weight : float
        Q = state_weight I and R = control_weight I; the study's are 10 and 1.
    rationality : float
        Inverse temperature beta_H (1/cost) with which agents infer each other's goals.

    Raises
    ------
    ModelError
        Where a value is not positive and finite.

    Examples
    --------
    >>> movement = Movement()
    >>> movement.control(np.zeros(4), np.array([1.0, 0.0])).round(2)
    array([2.59, 0.  ])
    """

    dt: float = 0.1
    state_weight: float = 10.0
    control_weight: float = 1.0
    rationality: float = 3e-4

    def __post_init__(self) -> None:
        _ = self.agent

    @cached_property
    def dynamics(self) -> Dynamics:
        """Of both agents."""
        return Dynamics.named("double-integrator", self.dt)

    @cached_property
    def model(self) -> GoalLQR:
        """What each takes the other for: eq. (22)-(27)."""
        return GoalLQR(
            dynamics="double-integrator",
            control_weight=self.control_weight,
            state_weight=self.state_weight,
            rationality=self.rationality,
        )

    @cached_property
    def agent(self) -> NoisilyRational:
        """The agent of that model; its mean control is the best one."""
        return self.model.agent_at(self.dt)

    def control(
        self, state: Float[np.ndarray, " n"], goal: Float[np.ndarray, " 2"] | None
    ) -> Float[np.ndarray, " 2"]:
        """Return the best control towards a goal at rest; without one, that which brakes: rest where it is now."""
        dynamics, agent = self.dynamics, self.agent
        if goal is None:
            goal = state[list(dynamics.position_index)]
        return agent.mean_control(state, dynamics.goal_states(goal))
