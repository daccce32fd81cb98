"""Beliefs about the human's goal after the reaction: b_post, and p(theta_post) (Algorithm 1)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ppinfer.distributions import Axis, Distribution
from ppinfer.distributions.logspace import log_sum_exp
from ppinfer.errors import ModelError


@lru_cache(maxsize=256)
def goal_axes(axis: Axis) -> tuple[Axis, Axis, Axis]:
    """Return the axes ``goal``, ``robot_goal`` and ``post_goal``, with the labels of one of them.

    Examples
    --------
    >>> [axis.name for axis in goal_axes(Axis("goal", ["cup", "bowl"]))]
    ['goal', 'robot_goal', 'post_goal']
    """
    return axis.rename("goal"), axis.rename("robot_goal"), axis.rename("post_goal")


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
