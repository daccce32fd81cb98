"""The courteous robot: the goal that leaves the human theirs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ppinfer.goals.choice.chooser import GoalChooser, GoalDecision, GoalSituation
from ppinfer.goals.choice.distances import change_costs
from ppinfer.goals.conditional import GoalConditional, SoftmaxConditional
from ppinfer.goals.model import LARGEST, require_range


@dataclass(frozen=True)
class Courtesy(GoalChooser):
    """Goes for the goal given which the human most probably keeps to the goal that they want now.

    With j the most probable goal of the belief (the first of equals), the score of r is

        -b_post(j | r) + change_weight |theta_r - previous|,

    the second term 0 for a robot without a goal until now.

    Parameters
    ----------
    change_weight : float
        lambda >= 0, in probability per m.
    conditional : GoalConditional
        How the human reacts.

    Raises
    ------
    ModelError
        Where the weight is negative.

    Examples
    --------
    >>> from ppinfer.testing import example_goal_situation
    >>> Courtesy().choose(example_goal_situation()).goal
    1
    """

    name: ClassVar[str] = "courtesy"

    change_weight: float = 0.02
    conditional: GoalConditional = field(default_factory=SoftmaxConditional)

    def __post_init__(self) -> None:
        require_range("change_weight", self.change_weight, 0.0, LARGEST)

    def choose(self, situation: GoalSituation) -> GoalDecision:
        """Return the goal that minimises the score."""
        post = self.conditional.post(situation)
        wanted = int(situation.belief.log_values.argmax())
        score = change_costs(situation, self.change_weight) - np.exp(post.log_values[:, wanted])
        return GoalDecision.minimising(score, post)
