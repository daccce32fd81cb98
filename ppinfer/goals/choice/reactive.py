"""The reactive robot: it waits until it knows what the human wants, and takes another goal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ppinfer.goals.choice.chooser import GoalChooser, GoalDecision, GoalSituation
from ppinfer.goals.choice.distances import robot_distances
from ppinfer.goals.conditional import unmoved_post
from ppinfer.goals.model import require_range


@dataclass(frozen=True)
class ReactToGoal(GoalChooser):
    """Waits until it is sure of the human's goal, then goes for the nearest of the others: the *reactive* robot.

    The goal that the human wants is the most probable one of the belief (the first of equals). While its probability is
    below the threshold the robot waits, every score is inf, and it waits again should the belief fall below later. Else
    the score is the distance (m) from the robot, inf for the goal that the human wants; where there is no other, it
    waits.

    Parameters
    ----------
    threshold : float
        Probability, in [0, 1].

    Raises
    ------
    ModelError
        Where the threshold is no probability.

    Examples
    --------
    >>> from ppinfer.testing import example_goal_situation
    >>> situation = example_goal_situation()
    >>> situation.belief.values
    array([0.7, 0.2, 0.1])
    >>> ReactToGoal().choose(situation).goal is None, ReactToGoal(threshold=0.5).choose(situation).goal
    (True, 1)
    """

    name: ClassVar[str] = "reactive"

    threshold: float = 0.8

    def __post_init__(self) -> None:
        require_range("threshold", self.threshold, 0.0, 1.0)

    def choose(self, situation: GoalSituation) -> GoalDecision:
        """Return the nearest goal that the human does not want, or wait."""
        log_belief = situation.belief.log_values
        wanted = int(log_belief.argmax())
        if np.exp(log_belief[wanted]) >= self.threshold:
            score = robot_distances(situation)
            score[wanted] = np.inf
        else:
            score = np.full(len(log_belief), np.inf)
        return GoalDecision.minimising(score, unmoved_post(situation.belief))
