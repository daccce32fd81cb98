"""How far goals are, from the agents and from the robot's last one."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from ppinfer.goals.choice.chooser import GoalSituation


def human_distances(situation: GoalSituation) -> Float[np.ndarray, " goal"]:
    """Return the distance (m) from the human to each goal; 0 where a goal is absent, for sums that give it no weight.

    Examples
    --------
    >>> from ppinfer.testing import example_goal_situation
    >>> human_distances(example_goal_situation()).round(2)
    array([3.  , 5.  , 5.83])
    """
    return _distances(situation, situation.human_position, absent=0.0)


def robot_distances(situation: GoalSituation, *, absent: float = np.inf) -> Float[np.ndarray, " goal"]:
    """Return the distance (m) from the robot to each goal; inf, or another number, where a goal is absent.

    Examples
    --------
    >>> from ppinfer.testing import example_goal_situation
    >>> robot_distances(example_goal_situation()).round(2)
    array([4.12, 8.06, 9.06])
    """
    return _distances(situation, situation.robot_position, absent=absent)


def change_costs(situation: GoalSituation, weight: float) -> Float[np.ndarray, " goal"]:
    """Return what it costs to go for each goal after the robot's last one: a weight times the distance between the two.

    0 for each where the robot had no goal, or had one that is gone; inf where a goal is absent: it cannot be chosen.

    Parameters
    ----------
    situation : GoalSituation
        Goals, and the last one of the robot.
    weight : float
        Cost per m.

    Examples
    --------
    >>> from ppinfer.testing import example_goal_situation
    >>> change_costs(example_goal_situation(), 0.5)
    array([0. , 4. , 2.5])
    """
    present, previous = situation.present, situation.previous
    if previous is None or (present is not None and not present[previous]):
        cost = np.zeros(len(situation.goals))
    else:
        cost = weight * _distances(situation, situation.goals[previous], absent=0.0)
    if present is not None:
        cost[~present] = np.inf
    return cost


def _distances(
    situation: GoalSituation, point: Float[np.ndarray, " space"], *, absent: float
) -> Float[np.ndarray, " goal"]:
    away = situation.goals - point
    distance: np.ndarray = np.sqrt((away * away).sum(axis=1))
    return distance if situation.present is None else np.where(situation.present, distance, absent)
