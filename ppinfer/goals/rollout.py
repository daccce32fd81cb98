"""Motion of noisily rational agents that pursue their goals, all rows in one compiled scan."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from ppinfer.goals.model import GoalDesign
from ppinfer.goals.noisily_rational import NoisilyRational


def roll_out(
    agent: NoisilyRational, start: Float[np.ndarray, "row n"], design: GoalDesign, rng: np.random.Generator
) -> tuple[Float[np.ndarray, "sample n"], Float[np.ndarray, "sample m"]]:
    """Return the states and controls of an agent that draws its controls from (22) towards the goals pursued.

    Parameters
    ----------
    agent : NoisilyRational
        Who moves.
    start : (row, n) float64
        Its state at the first sample of each row.
    design : GoalDesign
        The goals pursued, and how long each row is.
    rng : numpy.random.Generator
        Draws the noise of the controls.

    Examples
    --------
    >>> from ppinfer.goals import Dynamics
    >>> rng = np.random.default_rng(0)
    >>> design = GoalDesign.random(rng, rows=2, samples=5)
    >>> agent = NoisilyRational.lqr(Dynamics.single_integrator(design.dt))
    >>> state, control = roll_out(agent, design.start, design, rng)
    >>> state.shape, control.shape
    ((10, 2), (10, 2))
    """
    from ppinfer.goals.scans import linear_motion

    dynamics = agent.dynamics
    samples = int(design.row_size.sum())
    drawn = rng.standard_normal((samples, dynamics.controls))
    state, control = np.empty((samples, dynamics.states)), np.empty((samples, dynamics.controls))
    linear_motion(
        np.ascontiguousarray(start),
        dynamics.goal_states(design.pursued),
        design.row_size,
        drawn @ np.linalg.cholesky(agent.control_covariance).T,
        dynamics.A,
        dynamics.B,
        agent.K,
        agent.goal_gain,
        state,
        control,
    )
    return state, control
