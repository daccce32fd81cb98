"""What the human will do, given what the robot is about to do (Algorithm 1)."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Distribution
from ppinfer.goals.model import LARGEST, require_range
from ppinfer.goals.reaction import goal_axes, overall_post, post_goals, unmoved_post

if TYPE_CHECKING:
    from ppinfer.goals.choice.chooser import GoalSituation

__all__ = [
    "GoalConditional",
    "SoftmaxConditional",
    "conditional_log_weights",
    "goal_axes",
    "overall_post",
    "post_goals",
    "unmoved_post",
]

# exponents this far apart leave all their digits to sums of products of exponentials
_WIDEST = 500.0


class GoalConditional(ABC):
    """How the human's goal depends on the robot's; subclasses are small and have one method.

    A subclass may look at anything in the situation: positions, beliefs, and the histories of both agents. The answer
    is a plain conditional Distribution, random in ``post_goal`` and given ``goal`` (the human's prior goal),
    ``robot_goal``, both or neither, all three with the labels of ``situation.belief``: the rest of Algorithm 1 does not
    ask where it came from.

    Examples
    --------
    A human who minds nobody:

    >>> from ppinfer import Axis
    >>> class Deaf(GoalConditional):
    ...     def conditional(self, situation):
    ...         goal, _, post_goal = goal_axes(situation.belief.axes[0])
    ...         return Distribution.from_probabilities([goal, post_goal], np.eye(len(goal)), given=["goal"])
    >>> belief = Distribution.from_probabilities([Axis("goal", ["cup", "bowl"])], [0.9, 0.1])
    >>> from ppinfer.goals.choice import GoalSituation
    >>> situation = GoalSituation(
    ...     goals=np.eye(2), human=np.zeros(2), robot=np.ones(2), human_position=np.zeros(2), robot_position=np.ones(2),
    ...     belief=belief, mental_model=belief.rename(goal="robot_goal"),
    ... )
    >>> post_goals(Deaf().conditional(situation), belief).values
    array([[0.9, 0.1],
           [0.9, 0.1]])
    """

    name: ClassVar[str] = "custom"

    @abstractmethod
    def conditional(self, situation: GoalSituation) -> Distribution:
        """Return p(post_goal | goal, robot_goal), or one that is given fewer of these."""

    def post(self, situation: GoalSituation) -> Distribution:
        """Return b_post(post_goal | robot_goal) under the situation's belief, see `post_goals`."""
        return post_goals(self.conditional(situation), situation.belief)


@dataclass(frozen=True)
class SoftmaxConditional(GoalConditional):
    """The paper's conditional: post goals near the human, far from the robot's goal, near the prior goal.

    With goals theta_i (post), theta_j (prior), theta_R (the robot's) and the human at x_H,

        p(theta_i | theta_j, theta_R)
            = softmax_i( -beta_c [ w1 |theta_i - x_H| - w2 |theta_i - theta_R| + w3 |theta_i - theta_j| ] ).

    Parameters
    ----------
    human_weight : float
        w1 >= 0: what a metre from the human to a goal costs.
    robot_weight : float
        w2 >= 0: what a metre between a goal and the robot's is worth.
    stay_weight : float
        w3 >= 0: what a metre between a goal and the prior one costs.
    rationality : float
        beta_c > 0, in 1/m.

    Raises
    ------
    ModelError
        Where a weight is negative or the rationality is not positive.

    Notes
    -----
    **Weights with w2 <= w3 cannot make the human yield.** Where the prior goal is the human's nearest, every other goal
    is at least as far away and, by the triangle inequality, gains at most w2 |theta_i - theta_j| in distance from the
    robot's goal while it loses w3 |theta_i - theta_j|: the most probable post goal is the prior one whatever the robot
    does (ties aside), for any beta_c. A robot that believes this gives way to everybody, and against a human who does
    not give way either, or one who waits, both can stand for ever. Where the robot goes for the prior goal, goal i is
    preferred to it exactly when the way to i is longer by less than a share (w2 - w3) / w1 of the way between the two
    goals (`yielding_share`): never at 0, always at 1 or more. `can_yield` says whether it is above 0. The defaults (2,
    3, 1) have a share of 1; both sets of weights that the study used, `study_simulation` and `study_people`, have none.

    Examples
    --------
    >>> SoftmaxConditional().can_yield, SoftmaxConditional.study_people().can_yield
    (True, False)
    """

    name: ClassVar[str] = "softmax"

    human_weight: float = 2.0
    robot_weight: float = 3.0
    stay_weight: float = 1.0
    rationality: float = 0.5

    def __post_init__(self) -> None:
        for name in ("human_weight", "robot_weight", "stay_weight"):
            require_range(name, getattr(self, name), 0.0, LARGEST)
        require_range("rationality", self.rationality, 0.0, LARGEST, open_low=True)

    @classmethod
    def study_simulation(cls) -> SoftmaxConditional:
        """Return the weights that the study used in simulation: (2, 0.9, 2) and 0.5 per m. They cannot yield."""
        return cls(2.0, 0.9, 2.0, 0.5)

    @classmethod
    def study_people(cls) -> SoftmaxConditional:
        """Return the weights that the study used with people: (1, 3, 3) and 3 per m. They cannot yield."""
        return cls(1.0, 3.0, 3.0, 3.0)

    @property
    def can_yield(self) -> bool:
        """Whether a human whose nearest goal is the prior one can be taken to leave it to the robot: w2 > w3."""
        return self.robot_weight > self.stay_weight

    @property
    def yielding_share(self) -> float:
        """(w2 - w3) / w1, at least 0: a detour up to this share of the way between two goals is accepted."""
        gain = max(self.robot_weight - self.stay_weight, 0.0)
        return gain / self.human_weight if self.human_weight > 0 else (math.inf if gain > 0 else 0.0)

    def conditional(self, situation: GoalSituation) -> Distribution:
        """Return p(post_goal | goal, robot_goal)."""
        log_values = conditional_log_weights(
            situation.goals,
            situation.human_position,
            human_weight=self.human_weight,
            robot_weight=self.robot_weight,
            stay_weight=self.stay_weight,
            rationality=self.rationality,
            present=situation.present,
        )
        axes = goal_axes(situation.belief.axes[0])
        return Distribution._sound(axes, log_values, ("given", "given", "random"))

    def post(self, situation: GoalSituation) -> Distribution:
        """Return b_post(post_goal | robot_goal), without laying out the conditional where all goals are there.

        The exponent is A[j, i] + R[r, i], so that both sums, over post goals i for the normaliser and over prior goals
        j, are products of matrices of exponentials: with W = exp(A) and V = exp(R),

            b_post[r, i] = V[r, i] sum_j (b_j / (W V')[j, r]) W[j, i].

        Distances for which exponentials would not do go the long way, in log space.
        """
        if situation.present is None:
            goals, beta = situation.goals, self.rationality
            away = goals - situation.human_position
            between = _between(goals)
            to_prior = (-beta * self.stay_weight) * between
            to_prior -= (beta * self.human_weight) * np.sqrt((away * away).sum(axis=1))
            to_robot = (beta * self.robot_weight) * between
            # every exponent of a human lies in between: none is above 0 in one table, or below 0 in the other
            if float(to_robot.max() - to_prior.min()) < _WIDEST:
                kept, free = np.exp(to_prior), np.exp(to_robot - to_robot.max())
                weights = np.exp(situation.belief.log_values)[:, None] / (kept @ free.T)
                log_values = np.log(free * (weights.T @ kept))
                axes = goal_axes(situation.belief.axes[0])
                return Distribution._sound(axes[1:], log_values, ("given", "random"))
        return super().post(situation)


def conditional_log_weights(
    goals: Float[np.ndarray, "*#batch goal space"],
    human_position: Float[np.ndarray, "*#batch space"],
    *,
    human_weight: float = 2.0,
    robot_weight: float = 3.0,
    stay_weight: float = 1.0,
    rationality: float = 0.5,
    present: Bool[np.ndarray, "*#batch goal"] | None = None,
) -> Float[np.ndarray, "*batch goal goal goal"]:
    """Return log p(post goal | prior goal, robot's goal) of `SoftmaxConditional`, for many situations at once.

    Parameters
    ----------
    goals : (..., goal, space) float64
        Positions of the goals (m); anything where a goal is absent.
    human_position : (..., space) float64
        Position of the human (m). Leading axes broadcast.
    human_weight, robot_weight, stay_weight, rationality : float
        w1, w2, w3 and beta_c (1/m).
    present : (..., goal) bool, optional
        Goals that exist, at least one; default all. An absent goal is never a post goal (-inf). As a prior goal or the
        robot's it leaves its term out: nothing is near to, or far from, what is not there.

    Returns
    -------
    (..., goal, robot_goal, post_goal) float64
        Exponentials sum to one over the last axis.

    Examples
    --------
    The robot goes for goal 0, which the human is near and wants; then for goal 1.

    >>> log_weights = conditional_log_weights(np.array([[1.0, 0.0], [0.0, 2.0]]), np.zeros(2))
    >>> np.exp(log_weights[0]).round(2)
    array([[0.23, 0.77],
           [1.  , 0.  ]])
    """
    if present is not None and not present.all():
        goals = np.where(present[..., None], goals, 0.0)
    else:
        present = None
    away = goals - human_position[..., None, :]
    human_distance = np.sqrt((away * away).sum(axis=-1))
    between = _between(goals)
    if present is not None:
        # a row of the table of distances belongs to the prior goal, or the robot's, that may be absent
        between = np.where(present[..., None], between, 0.0)
    per_post = (-rationality * human_weight) * human_distance
    per_robot = (rationality * robot_weight) * between + per_post[..., None, :]
    log_weights = per_robot[..., None, :, :] - ((rationality * stay_weight) * between)[..., :, None, :]
    if present is not None:
        log_weights = np.where(present[..., None, None, :], log_weights, -np.inf)
    log_weights -= log_weights.max(axis=-1, keepdims=True)
    log_weights -= np.log(np.exp(log_weights).sum(axis=-1, keepdims=True))
    normalised: np.ndarray = log_weights
    return normalised


def _between(goals: Float[np.ndarray, "*batch goal space"]) -> Float[np.ndarray, "*batch goal goal"]:
    """Return the distances between goals."""
    apart = goals[..., :, None, :] - goals[..., None, :, :]
    distance: np.ndarray = np.sqrt((apart * apart).sum(axis=-1))
    return distance
