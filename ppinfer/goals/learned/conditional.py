"""The learned conditional in the place of the softmax."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from jaxtyping import Float

from ppinfer.distributions import Distribution
from ppinfer.errors import ModelError
from ppinfer.goals.conditional import GoalConditional, goal_axes
from ppinfer.goals.learned.examples import PredictionExamples
from ppinfer.goals.learned.nominal import nominal_plans

if TYPE_CHECKING:
    from ppinfer.goals.choice.chooser import GoalSituation
    from ppinfer.goals.learned.predictor import GoalPredictor


@dataclass(frozen=True, eq=False)
class LearnedConditional(GoalConditional):
    """p(post goal | robot goal), where the robot would follow its nominal plan to each of its goals.

    1. For every goal of the robot, its LQR's way there from where it is: the plan.
    2. The network, once for all plans.

    It needs no belief over prior goals: it looks at the motion that such beliefs are made of. So the answer is given
    ``robot_goal`` only.

    Parameters
    ----------
    predictor : GoalPredictor
        With learned weights, from `train` or `read_predictor`.

    Raises
    ------
    ModelError
        If a situation's states are not those that the network was trained on.

    Notes
    -----
    Where a situation has no histories, or shorter ones than the network looks back, the oldest known state is taken to
    have lasted: what examples at the start of a game look like.
    """

    name: ClassVar[str] = "learned"

    predictor: GoalPredictor

    def conditional(self, situation: GoalSituation) -> Distribution:
        """Return p(post_goal | robot_goal)."""
        examples = self._examples(situation)
        _, robot_goal, post_goal = goal_axes(situation.belief.axes[0])
        log_values = self.predictor.log_probabilities(examples)
        return Distribution._sound((robot_goal, post_goal), log_values, ("given", "random"))

    def _examples(self, situation: GoalSituation) -> PredictionExamples:
        configuration = self.predictor.configuration
        robot = configuration.robot
        if (
            situation.robot.shape != (robot.dynamics.states,)
            or situation.human.shape != situation.robot.shape
        ):
            raise ModelError(
                f"the learned conditional was trained on {configuration.dynamics} states of {robot.dynamics.states} "
                f"entries; got {situation.human.shape} for the human and {situation.robot.shape} for the robot"
            )
        count = len(situation.goals)
        present = np.ones(count, dtype=bool) if situation.present is None else situation.present
        goals = np.where(present[:, None], situation.goals, 0.0)
        # where the robot's goal does not exist there is no plan to it: it stays
        targets = np.where(present[:, None], goals, situation.robot_position)
        past = [
            _recent(history, state, configuration.past)
            for history, state in (
                (situation.human_history, situation.human),
                (situation.robot_history, situation.robot),
            )
        ]
        everywhere = [np.broadcast_to(each, (count, *each.shape)) for each in past]
        return PredictionExamples(
            human=everywhere[0],
            robot=everywhere[1],
            plan=nominal_plans(robot, situation.robot, targets, configuration.horizon),
            goals=np.broadcast_to(goals, (count, *goals.shape)),
            present=np.broadcast_to(present, (count, count)),
            frequency=np.broadcast_to(present / present.sum(), (count, count)),
            robot_goal=np.arange(count),
        )


def _recent(
    history: Float[np.ndarray, "step n"] | None, state: Float[np.ndarray, " n"], past: int
) -> Float[np.ndarray, "past n"]:
    known = state[None] if history is None or not len(history) else history[-past:]
    lasted = np.repeat(known[:1], past - len(known), axis=0)
    return np.concatenate([lasted, known])
