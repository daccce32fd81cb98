"""The influencing robot: the goal that makes the human go where the two of them are served soonest."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ppinfer.goals.choice.chooser import GoalChooser, GoalDecision, GoalSituation
from ppinfer.goals.choice.distances import human_distances, robot_distances
from ppinfer.goals.conditional import GoalConditional, SoftmaxConditional
from ppinfer.goals.model import LARGEST, require_range


@dataclass(frozen=True)
class Influence(GoalChooser):
    """Goes for the goal that leaves both agents the shortest ways, the human's as the human will choose it then.

    With theta_H(r) the most probable post goal given r, the argmax of b_post(. | r) (the first of equals), the score is

        |x_H - theta_H(r)| + |x_R - theta_r| + penalty [theta_H(r) = theta_r].

    Parameters
    ----------
    penalty : float
        What both going for the same goal costs (m), >= 0.
    conditional : GoalConditional
        How the human reacts.

    Raises
    ------
    ModelError
        Where the penalty is negative.

    Examples
    --------
    >>> from ppinfer.testing import example_goal_situation
    >>> Influence().choose(example_goal_situation()).goal
    0
    """

    name: ClassVar[str] = "influence"

    penalty: float = 20.0
    conditional: GoalConditional = field(default_factory=SoftmaxConditional)

    def __post_init__(self) -> None:
        require_range("penalty", self.penalty, 0.0, LARGEST)

    def choose(self, situation: GoalSituation) -> GoalDecision:
        """Return the goal that minimises the score."""
        post = self.conditional.post(situation)
        human_goal = post.log_values.argmax(axis=1)
        score = robot_distances(situation) + human_distances(situation)[human_goal]
        score[human_goal == np.arange(len(score))] += self.penalty
        return GoalDecision.minimising(score, post)
