"""The naive robot: the goal nearest to it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ppinfer.goals.choice.chooser import GoalChooser, GoalDecision, GoalSituation
from ppinfer.goals.choice.distances import robot_distances
from ppinfer.goals.conditional import unmoved_post


@dataclass(frozen=True)
class NearestGoal(GoalChooser):
    """Goes for the goal nearest to itself, whatever the human does: the *naive* robot.

    The score is the distance (m) from the robot; the first of equally near goals is taken.

    Examples
    --------
    >>> from ppinfer.testing import example_goal_situation
    >>> NearestGoal().choose(example_goal_situation()).goal
    0
    """

    name: ClassVar[str] = "naive"

    def choose(self, situation: GoalSituation) -> GoalDecision:
        """Return the nearest goal."""
        return GoalDecision.minimising(robot_distances(situation), unmoved_post(situation.belief))
