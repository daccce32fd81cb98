"""The plan that a robot follows unless something else is decided: its LQR's way to a goal."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from jaxtyping import Float

from ppinfer.goals.noisily_rational import NoisilyRational


def nominal_plans(
    robot: NoisilyRational,
    state: Float[np.ndarray, "*#batch n"],
    targets: Float[np.ndarray, "*#batch space"],
    horizon: int,
) -> Float[np.ndarray, "*batch horizon n"]:
    """Return the states of the next steps under the best controls: x_t - theta = (A - BK)^t (x_0 - theta).

    Parameters
    ----------
    robot : NoisilyRational
        Dynamics and feedback gain K; its goals stay where they are.
    state : (..., n) float64
        Where it is.
    targets : (..., space) float64
        The goals (m). Leading axes broadcast.
    horizon : int
        How many steps.

    Examples
    --------
    >>> from ppinfer.goals import Dynamics
    >>> robot = NoisilyRational.lqr(Dynamics.double_integrator(0.1), state_weight=10.0)
    >>> plans = nominal_plans(robot, np.zeros(4), np.array([[1.0, 0.0], [0.0, 2.0]]), 100)
    >>> plans.shape, plans[:, -1, [0, 2]].round(2) + 0.0
    ((2, 100, 4), array([[1., 0.],
           [0., 2.]]))
    """
    goal = robot.dynamics.goal_states(targets)
    off = state - goal
    powers = _powers(robot.closed_loop.tobytes(), robot.dynamics.states, horizon)
    plans: np.ndarray = goal[..., None, :] + np.einsum("tij,...j->...ti", powers, off)
    return plans


@lru_cache(maxsize=32)
def _powers(closed_loop: bytes, states: int, horizon: int) -> Float[np.ndarray, "horizon n n"]:
    F = np.frombuffer(closed_loop).reshape(states, states)
    powers = np.empty((horizon, states, states))
    power = np.eye(states)
    for step in range(horizon):
        power = F @ power
        powers[step] = power
    return powers
