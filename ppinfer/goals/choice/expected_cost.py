"""The robot that counts what it expects: time until both have arrived, and clashes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ppinfer.goals.choice.chooser import GoalChooser, GoalDecision, GoalSituation
from ppinfer.goals.choice.distances import change_costs, human_distances, robot_distances
from ppinfer.goals.conditional import GoalConditional, SoftmaxConditional
from ppinfer.goals.model import LARGEST, require_range


@dataclass(frozen=True)
class ExpectedCost(GoalChooser):
    """Goes for the goal with the least expected way of whoever arrives last, over all that the human may do.

    With d_R and d_H the distances from the robot and the human to the goals, the score of r is

        sum_i b_post(i | r) [ max(d_R(r), d_H(i)) + penalty [i = r] ] + change_weight |theta_r - previous|,

    the last term 0 for a robot without a goal until now. Distances stand for times: the agents are taken to be equally
    fast.

    Parameters
    ----------
    penalty : float
        What both going for the same goal costs (m), >= 0.
    change_weight : float
        What a metre between the last goal and the new one costs (m), >= 0; it keeps the robot from dithering between
        goals that are about as good.
    conditional : GoalConditional
        How the human reacts.

    Raises
    ------
    ModelError
        Where a weight is negative.

    Examples
    --------
    >>> from ppinfer.testing import example_goal_situation
    >>> decision = ExpectedCost().choose(example_goal_situation())
    >>> decision.goal, decision.score.round(1)
    (0, array([5.1, 8.9, 9.6]))
    """

    name: ClassVar[str] = "expected-cost"

    penalty: float = 20.0
    change_weight: float = 0.1
    conditional: GoalConditional = field(default_factory=SoftmaxConditional)

    def __post_init__(self) -> None:
        require_range("penalty", self.penalty, 0.0, LARGEST)
        require_range("change_weight", self.change_weight, 0.0, LARGEST)

    def choose(self, situation: GoalSituation) -> GoalDecision:
        """Return the goal that minimises the score."""
        post = self.conditional.post(situation)
        probability = np.exp(post.log_values)
        latest = np.maximum(robot_distances(situation, absent=0.0)[:, None], human_distances(situation))
        score = np.einsum("ri,ri->r", probability, latest) + self.penalty * probability.diagonal()
        score += change_costs(situation, self.change_weight)
        return GoalDecision.minimising(score, post)
