"""Small sets of prediction examples that need no simulation."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np

from ppinfer.goals.dynamics import Dynamics
from ppinfer.goals.learned.examples import PredictionExamples
from ppinfer.goals.learned.nominal import nominal_plans
from ppinfer.goals.noisily_rational import NoisilyRational

if TYPE_CHECKING:
    from ppinfer.studies.learning import LearningRow
    from ppinfer.studies.prediction_examples import ExampleHeader, ExampleStore


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


def example_header(examples: PredictionExamples) -> ExampleHeader:
    """Return the header of a store of such examples.

    Examples
    --------
    >>> example_header(example_predictions(2)).past
    4
    """
    from ppinfer.studies.prediction_examples import ExampleHeader

    return ExampleHeader(
        past=examples.human.shape[1],
        horizon=examples.plan.shape[1],
        goals=examples.goals.shape[1],
        states=examples.human.shape[2],
        dynamics="double-integrator",
        dt=0.1,
        state_weight=10.0,
        control_weight=1.0,
        kinds=("yielding",),
        batch=max(1, min(64, len(examples))),
        configuration={"seed": 0, "continuations": 10},
    )


def example_store(path: str | os.PathLike[str], count: int) -> ExampleStore:
    """Write a store of such examples, as a generator would, and return it.

    Examples
    --------
    >>> len(example_store("examples.zarr", 5))
    5
    """
    from ppinfer.studies.prediction_examples import ExampleStore, ExampleWriter, StoredExamples

    examples = example_predictions(count)
    interaction = np.full(count, 4.0, np.float32)
    stored = StoredExamples(examples, np.zeros(count, dtype=int), interaction)
    ExampleWriter(path, example_header(examples)).append(stored)
    return ExampleStore(path)


def example_learning_rows() -> list[LearningRow]:
    """Return rows of a study of learning, with scores made up but for their order.

    Examples
    --------
    >>> [row.prediction for row in example_learning_rows()]
    ['even', 'model', 'model fitted', 'learned', 'learned', 'learned']
    """
    from ppinfer.studies.learning import LearningRow
    from ppinfer.studies.prediction_scores import score_predictions

    examples = example_predictions(200)
    named = (("even", 0, 0.0), ("model", 0, 0.5), ("model fitted", 100, 0.6))
    rows = []
    for name, count, power in (
        *named,
        ("learned", 100, 0.3),
        ("learned", 1000, 0.6),
        ("learned", 10000, 0.9),
    ):
        logs = power * np.log(examples.frequency)
        logs -= np.logaddexp.reduce(logs, axis=1, keepdims=True)
        score = score_predictions(logs, examples.frequency, examples.present)
        rows.append(LearningRow(name, count, count / 600, 5 if name == "learned" else 0, score.loss, score))
    return rows
