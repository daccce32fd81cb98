"""What the human will do, given what the robot is about to do (Algorithm 1)."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Axis, Distribution
from ppinfer.distributions.logspace import log_sum_exp
from ppinfer.errors import ModelError
from ppinfer.goals.model import LARGEST, require_range

if TYPE_CHECKING:
    from ppinfer.goals.choice.chooser import GoalSituation


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
        return Distribution._sound(
            goal_axes(situation.belief.axes[0]), log_values, ("given", "given", "random")
        )


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
    apart = goals[..., :, None, :] - goals[..., None, :, :]
    between = np.sqrt((apart * apart).sum(axis=-1))
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


def post_goals(conditional: Distribution, belief: Distribution) -> Distribution:
    """Return b_post(post_goal | robot_goal) = sum_j p(post_goal | goal j, robot_goal) b_prior(goal j) (Algorithm 1).

    Parameters
    ----------
    conditional : Distribution
        Random in ``post_goal``, given a subset of ``goal`` and ``robot_goal``. One that is not given ``robot_goal`` (a
        human who does not react) answers the same for each.
    belief : Distribution
        b_prior, over ``goal``.

    Raises
    ------
    ModelError
        Where the conditional is over other axes.
    AxisError
        Where the labels of ``goal`` differ between the two.

    Examples
    --------
    >>> goal, robot_goal, post_goal = goal_axes(Axis("goal", ["cup", "bowl"]))
    >>> leaves_it = [[[0.1, 0.9], [1.0, 0.0]], [[0.0, 1.0], [0.9, 0.1]]]
    >>> reaction = Distribution.from_probabilities(
    ...     [goal, robot_goal, post_goal], leaves_it, given=["goal", "robot_goal"]
    ... )
    >>> post_goals(reaction, Distribution.uniform(goal)).values.round(2)
    array([[0.05, 0.95],
           [0.95, 0.05]])
    """
    goal, robot_goal, post_goal = goal_axes(belief.axes[0])
    kinds = dict(zip(conditional.axes, conditional._kinds, strict=True))
    if kinds == {goal: "given", robot_goal: "given", post_goal: "random"} and conditional.axes[0] == goal:
        # the common layout, in every step of a control loop
        log_values = log_sum_exp(conditional.log_values + belief.log_values[:, None, None], (0,))
        if conditional.axes[1] != robot_goal:
            log_values = log_values.T
        return Distribution._sound((robot_goal, post_goal), log_values, ("given", "random"))
    if conditional.random != ("post_goal",) or not set(conditional.conditions) <= {"goal", "robot_goal"}:
        raise ModelError(
            f"a goal conditional is random in post_goal and given goal, robot_goal, both or neither; got "
            f"{conditional!r}"
        )
    if conditional.batch:
        raise ModelError(
            f"a goal conditional is of one situation, without batch axes; got {conditional.batch}"
        )
    post = conditional
    if "goal" in conditional.conditions:
        joint = belief * conditional
        assert isinstance(joint, Distribution)
        post = joint.marginal("post_goal")
    if "robot_goal" in post.names:
        return post.align("robot_goal", "post_goal")
    return unmoved_post(post.rename(post_goal="goal"))


def unmoved_post(belief: Distribution) -> Distribution:
    """Return b_post of a human who does not mind the robot: the belief itself, for each goal of the robot.

    Parameters
    ----------
    belief : Distribution
        b_prior, over ``goal``.

    Examples
    --------
    >>> unmoved_post(Distribution.from_probabilities([Axis("goal", ["cup", "bowl"])], [0.9, 0.1])).values
    array([[0.9, 0.1],
           [0.9, 0.1]])
    """
    _, robot_goal, post_goal = goal_axes(belief.axes[0])
    everywhere = np.tile(belief.log_values, (len(robot_goal), 1))
    return Distribution._sound((robot_goal, post_goal), everywhere, ("given", "random"))


def overall_post(post: Distribution, mental_model: Distribution) -> Distribution:
    """Return p(post_goal) = sum_R b_H(robot_goal R) b_post(post_goal | robot_goal R) (Algorithm 1).

    Parameters
    ----------
    post : Distribution
        b_post, random in ``post_goal`` and given ``robot_goal``.
    mental_model : Distribution
        Over ``robot_goal``: what the human takes to be the robot's goal, as the robot sees it.

    Raises
    ------
    ModelError
        Where the two are over other axes.

    Examples
    --------
    >>> goal, robot_goal, post_goal = goal_axes(Axis("goal", ["cup", "bowl"]))
    >>> post = Distribution.from_probabilities([robot_goal, post_goal], [[0.0, 1.0], [1.0, 0.0]], given=["robot_goal"])
    >>> overall_post(post, Distribution.from_probabilities([robot_goal], [0.7, 0.3])).values.round(2)
    array([0.3, 0.7])
    """
    joint = mental_model * post
    if not isinstance(joint, Distribution) or set(joint.random) != {"robot_goal", "post_goal"}:
        raise ModelError(
            f"the overall prediction needs p(post_goal | robot_goal) and p(robot_goal); got {post!r} and "
            f"{mental_model!r}"
        )
    return joint.marginal("post_goal")


@lru_cache(maxsize=256)
def goal_axes(axis: Axis) -> tuple[Axis, Axis, Axis]:
    """Return the axes ``goal``, ``robot_goal`` and ``post_goal``, with the labels of one of them.

    Examples
    --------
    >>> [axis.name for axis in goal_axes(Axis("goal", ["cup", "bowl"]))]
    ['goal', 'robot_goal', 'post_goal']
    """
    return axis.rename("goal"), axis.rename("robot_goal"), axis.rename("post_goal")
