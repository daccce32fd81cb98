"""Hypothesis strategies: situations in which a robot chooses a goal."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from ppinfer.distributions import Axis, Distribution, Factor
from ppinfer.goals.choice import GoalSituation
from ppinfer.testing.goal_scenes import POSITION_INDEX


@st.composite
def goal_situations(draw: st.DrawFn, *, max_goals: int = 5, history: int = 4) -> GoalSituation:
    """Draw situations of two double integrators in the plane, some with absent goals, all without ties.

    Parameters
    ----------
    max_goals : int
        From 1 goal to so many.
    history : int
        Steps of the histories.

    Examples
    --------
    >>> from hypothesis import find
    >>> len(find(goal_situations(), lambda situation: True).goals)
    1
    """
    goals = draw(st.integers(1, max_goals), label="goals")
    absent = draw(st.sets(st.integers(0, goals - 1), max_size=goals - 1), label="absent")
    sure = draw(st.sampled_from([0.3, 1.0, 30.0]), label="how sure beliefs are")
    rng = np.random.default_rng(draw(st.integers(0, 2**20), label="seed"))
    present = np.ones(goals, dtype=bool)
    present[list(absent)] = False
    previous = draw(st.sampled_from([None, *range(goals)]), label="previous")
    human, robot = rng.normal(0.0, 4.0, (2, history, 4))
    places = rng.uniform(-10.0, 10.0, (goals, 2))
    places[~present] = np.nan
    goal = Axis("goal", [f"goal {index}" for index in range(goals)])
    rationality = Axis("rationality", [5e-6, 5e-5, 5e-3])
    index = list(POSITION_INDEX)
    joint = _random([goal, rationality], rng, sure, present[:, None])
    return GoalSituation(
        goals=places,
        human=human[-1],
        robot=robot[-1],
        human_position=human[-1, index],
        robot_position=robot[-1, index],
        belief=joint.marginal("goal"),
        mental_model=_random([goal.rename("robot_goal")], rng, sure, present),
        rationality_belief=joint,
        previous=previous,
        present=present if absent else draw(st.sampled_from([None, present]), label="present"),
        human_history=human,
        robot_history=robot,
    )


def _random(axes: list[Axis], rng: np.random.Generator, sure: float, present: np.ndarray) -> Distribution:
    logs = np.where(present, sure * rng.normal(size=[len(axis) for axis in axes]), -np.inf)
    return Factor(axes, logs).normalize(*(axis.name for axis in axes))
