"""A reaction is only expected of who does not know the robot's goal yet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from numpy.testing import assert_allclose

from ppinfer.distributions import Axis, Distribution
from ppinfer.goals.choice import GoalSituation
from ppinfer.goals.conditional import GoalConditional, SoftmaxConditional, goal_axes, post_goals
from ppinfer.goals.reacted import ReactedConditional
from ppinfer.testing import check_goal_conditional, example_goal_situation, goal_situations


class Restless(GoalConditional):
    """A human who goes anywhere, whatever it wanted and whatever the robot wants."""

    def conditional(self, situation: GoalSituation) -> Distribution:
        return Distribution.uniform(goal_axes(situation.belief.axes[0])[2])


def test_it_obeys_the_laws_of_every_conditional() -> None:
    check_goal_conditional(ReactedConditional())


def test_post_goals_are_a_mixture_of_the_belief_and_the_reaction() -> None:
    situation = example_goal_situation()
    knows = np.array([0.8, 0.15, 0.05])
    axis = situation.mental_model.axes[0]
    situation = replace(situation, mental_model=Distribution.from_probabilities([axis], knows))
    before = SoftmaxConditional().post(situation).values
    expected = knows[:, None] * situation.belief.values + (1 - knows[:, None]) * before
    assert_allclose(ReactedConditional().post(situation).values, expected, rtol=1e-12)


@pytest.mark.parametrize("reaction", [SoftmaxConditional(), Restless()], ids=["softmax", "restless"])
def test_it_takes_a_reaction_that_depends_on_less(reaction: GoalConditional) -> None:
    situation = example_goal_situation()
    post = post_goals(ReactedConditional(reaction).conditional(situation), situation.belief)
    before = reaction.post(situation).values
    expected = situation.belief.values / 3 + before * 2 / 3
    assert_allclose(post.values, expected, rtol=1e-12)


@given(goal_situations())
def test_post_goals_at_once_are_those_by_way_of_the_conditional(situation: GoalSituation) -> None:
    reacted = ReactedConditional()
    by_way = post_goals(reacted.conditional(situation), situation.belief)
    at_once = reacted.post(situation)
    assert at_once.axes == by_way.axes
    there = slice(None) if situation.present is None else situation.present
    # what follows a goal of the robot that is absent is of no use to anybody
    assert_allclose(at_once.values[there], by_way.values[there], rtol=1e-9, atol=1e-12)


def test_a_human_who_stands_at_its_goal_and_knows_is_not_expected_to_leave() -> None:
    goal = Axis("goal", ["here", "there", "yonder"])
    human, robot = np.zeros(4), np.array([1.5, 0.0, 0.0, 0.0])
    situation = GoalSituation(
        goals=np.array([[0.0, 0.0], [20.0, 0.0], [0.0, 20.0]]),
        human=human,
        robot=robot,
        human_position=human[[0, 2]],
        robot_position=robot[[0, 2]],
        belief=Distribution.from_probabilities([goal], [1.0, 0.0, 0.0]),
        mental_model=Distribution.from_probabilities([goal.rename("robot_goal")], [1.0, 0.0, 0.0]),
    )
    # the softmax is of three minds about it, however long the two stand there
    assert_allclose(SoftmaxConditional().post(situation).values[0], 1 / 3, rtol=1e-12)
    assert_allclose(ReactedConditional().post(situation).values[0], [1.0, 0.0, 0.0], atol=1e-12)
