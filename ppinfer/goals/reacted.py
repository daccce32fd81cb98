"""Who has seen it already has reacted already: a conditional for a human who may know the robot's goal by now."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ppinfer.distributions import Distribution
from ppinfer.goals.conditional import GoalConditional, SoftmaxConditional, goal_axes

if TYPE_CHECKING:
    from ppinfer.goals.choice.chooser import GoalSituation


@dataclass(frozen=True)
class ReactedConditional(GoalConditional):
    """A reaction that is only expected of a human who does not know the robot's goal yet.

    p(post | prior, theta_R) = b_H(theta_R) [post = prior] + (1 - b_H(theta_R)) p'(post | prior, theta_R),

    where p' is another conditional and b_H the mental model. With probability b_H(theta_R) the human takes theta_R
    to be the robot's goal already: then the goal that it is seen to pursue is the one *after* its reaction. Without
    this a robot expects for ever that a human who stands at its goal, and knows, is about to leave: p' depends on where
    everything is, and not on what the human has made of it.

    Parameters
    ----------
    reaction : GoalConditional
        p'.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from ppinfer.testing import example_goal_situation
    >>> situation = example_goal_situation()
    >>> sure = Distribution.from_probabilities([situation.mental_model.axes[0]], [1.0, 0.0, 0.0])
    >>> told = ReactedConditional().post(replace(situation, mental_model=sure))
    >>> bool(np.allclose(told.values[0], situation.belief.values))
    True
    """

    name: ClassVar[str] = "reacted"

    reaction: GoalConditional = field(default_factory=SoftmaxConditional)

    def conditional(self, situation: GoalSituation) -> Distribution:
        """Return p(post_goal | goal, robot_goal)."""
        before = self.reaction.conditional(situation)
        axes = goal_axes(situation.belief.axes[0])
        missing = [axis for axis in axes[:2] if axis.name not in before.names]
        names = [axis.name for axis in axes]
        spread = np.exp(before.log_values)
        # where p' does not depend on an axis it is the same all along it
        order = [name for name in names if name in before.names]
        spread = np.transpose(spread, [before.names.index(name) for name in order])
        for axis in missing:
            spread = np.expand_dims(spread, names.index(axis.name))
        knows = np.exp(situation.mental_model.log_values)[None, :, None]
        stays = np.eye(len(axes[0]))[:, None, :]
        if situation.present is not None:
            # nobody's prior goal is one that is absent; where it is asked for all the same, p' answers
            knows = np.where(situation.present[:, None, None], knows, 0.0)
        values = knows * stays + (1.0 - knows) * np.broadcast_to(spread, (len(axes[0]),) * 3)
        with np.errstate(divide="ignore"):
            return Distribution._sound(axes, np.log(values), ("given", "given", "random"))

    def post(self, situation: GoalSituation) -> Distribution:
        """Return b_post: with probability b_H(robot_goal) the belief as it is, else what p' makes of it."""
        before = self.reaction.post(situation)
        knows = np.exp(situation.mental_model.log_values)[:, None]
        values = knows * np.exp(situation.belief.log_values) + (1.0 - knows) * np.exp(before.log_values)
        with np.errstate(divide="ignore"):
            return Distribution._sound(before.axes, np.log(values), ("given", "random"))
