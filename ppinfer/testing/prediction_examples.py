"""Small sets of prediction examples that need no simulation."""

from __future__ import annotations

import numpy as np

from ppinfer.goals.dynamics import Dynamics
from ppinfer.goals.learned.examples import PredictionExamples
from ppinfer.goals.learned.nominal import nominal_plans
from ppinfer.goals.noisily_rational import NoisilyRational


def example_predictions(
    count: int, *, past: int = 4, horizon: int = 8, goals: int = 3, seed: int = 0
) -> PredictionExamples:
    """Return examples of a human who goes to the nearest goal that the robot does not, as most would.

    Parameters
    ----------
    count : int
        How many.
    past, horizon : int
        Steps of the past and of the plan, 0.1 s each.
    goals : int
        How many goals each has.
    seed : int
        Of the places.

    Examples
    --------
    >>> example_predictions(2).frequency.sum(axis=1)
    array([1., 1.], dtype=float32)
    """
    rng = np.random.default_rng(seed)
    agent = NoisilyRational.lqr(Dynamics.double_integrator(0.1), state_weight=10.0)
    places = rng.uniform(-10.0, 10.0, (count, goals, 2))
    start = agent.dynamics.goal_states(rng.uniform(-10.0, 10.0, (2, count, 2)))
    robot_goal = rng.integers(goals, size=count)
    target = places[np.arange(count), robot_goal]
    distance = np.linalg.norm(places - start[0][:, None, [0, 2]], axis=-1)
    distance[np.arange(count), robot_goal] += 10.0
    frequency = np.full((count, goals), 0.1 / max(1, goals - 1), np.float32)
    frequency[np.arange(count), distance.argmin(axis=1)] = 0.9 if goals > 1 else 1.0
    stood = np.repeat(start[:, :, None], past, axis=2).astype(np.float32)
    return PredictionExamples(
        human=stood[0],
        robot=stood[1],
        plan=nominal_plans(agent, start[1], target, horizon).astype(np.float32),
        goals=places.astype(np.float32),
        present=np.ones((count, goals), dtype=bool),
        frequency=frequency,
        robot_goal=robot_goal,
    )
