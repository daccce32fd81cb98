"""Situations in which a robot chooses a goal: an example, and the same scene told in other ways."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from ppinfer.distributions import Axis, Distribution
from ppinfer.goals.choice import GoalSituation

# entries of the state [px, vx, py, vy] that are positions
POSITION_INDEX = (0, 2)


def example_goal_situation() -> GoalSituation:
    """Return a situation: three goals, and a human at the origin who probably wants the goal that is near both agents.

    Examples
    --------
    >>> situation = example_goal_situation()
    >>> situation.labels, situation.previous
    (('cup', 'bowl', 'plate'), 0)
    """
    goal = Axis("goal", ["cup", "bowl", "plate"])
    human, robot = np.array([0.0, 0.5, 0.0, 0.0]), np.array([2.0, 0.0, -4.0, 0.0])
    belief = Distribution.from_probabilities([goal], [0.7, 0.2, 0.1])
    joint = belief * Distribution.from_probabilities(
        [Axis("rationality", [5e-6, 5e-5, 5e-3])], [0.2, 0.3, 0.5]
    )
    assert isinstance(joint, Distribution)
    return GoalSituation(
        goals=np.array([[3.0, 0.0], [-5.0, 0.0], [3.0, 5.0]]),
        human=human,
        robot=robot,
        human_position=human[list(POSITION_INDEX)],
        robot_position=robot[list(POSITION_INDEX)],
        belief=belief,
        mental_model=Distribution.uniform(goal.rename("robot_goal")),
        rationality_belief=joint,
        previous=0,
    )


def rearranged(situation: GoalSituation, order: Int[np.ndarray, " taken"]) -> GoalSituation:
    """Return the situation with its goals in another order; those left out must be absent.

    Examples
    --------
    >>> rearranged(example_goal_situation(), np.array([2, 0, 1])).labels
    ('plate', 'cup', 'bowl')
    """
    joint = situation.rationality_belief
    previous = np.flatnonzero(order == situation.previous)
    return replace(
        situation,
        goals=situation.goals[order],
        human=situation.human.copy(),
        robot=situation.robot.copy(),
        human_position=situation.human_position.copy(),
        robot_position=situation.robot_position.copy(),
        belief=_taken(situation.belief, "goal", order),
        mental_model=_taken(situation.mental_model, "robot_goal", order),
        rationality_belief=None if joint is None else _taken(joint, "goal", order),
        previous=int(previous[0]) if len(previous) else None,
        present=None if situation.present is None else situation.present[order],
    )


def moved_scene(situation: GoalSituation, by: Float[np.ndarray, " space"] | None = None) -> GoalSituation:
    """Return the situation with everything in it moved, for states [px, vx, py, vy].

    Examples
    --------
    >>> moved_scene(example_goal_situation(), np.array([1.0, 2.0])).robot
    array([ 3.,  0., -2.,  0.])
    """
    step = np.array([7.0, -3.0]) if by is None else by
    along = np.zeros(len(situation.human))
    along[list(POSITION_INDEX)] = step
    return replace(
        situation,
        goals=situation.goals + step,
        human=situation.human + along,
        robot=situation.robot + along,
        human_position=situation.human_position + step,
        robot_position=situation.robot_position + step,
        human_history=None if situation.human_history is None else situation.human_history + along,
        robot_history=None if situation.robot_history is None else situation.robot_history + along,
    )


def _taken(belief: Distribution, name: str, order: Int[np.ndarray, " taken"]) -> Distribution:
    position = belief.names.index(name)
    axes = list(belief.axes)
    axes[position] = Axis(name, [axes[position].labels[goal] for goal in order])
    return Distribution(axes, np.take(belief.log_values, order, axis=position))
