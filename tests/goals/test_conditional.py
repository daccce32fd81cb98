"""The conditional of Algorithm 1: what it is, what weights can do, and what goals that are absent do."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from ppinfer.distributions import Axis, Distribution
from ppinfer.errors import AxisError, ModelError
from ppinfer.goals import (
    GoalConditional,
    SoftmaxConditional,
    conditional_log_weights,
    overall_post,
    post_goals,
)
from ppinfer.goals.conditional import goal_axes, unmoved_post
from ppinfer.testing import check_goal_conditional, example_goal_situation, goal_situations

CASES = 4000


def nearest_first(rng, cases, goals):
    """Draw humans at the origin and goals about them, the nearest one first."""
    positions = rng.uniform(-10.0, 10.0, (cases, goals, 2))
    order = np.argsort(np.linalg.norm(positions, axis=2), axis=1)
    return np.take_along_axis(positions, order[..., None], axis=1)


def leaving(positions, conditional):
    """Return how many leave their prior goal 0, the nearest, for some goal of the robot, and for their own."""
    log_weights = conditional_log_weights(
        positions,
        np.zeros((len(positions), 2)),
        human_weight=conditional.human_weight,
        robot_weight=conditional.robot_weight,
        stay_weight=conditional.stay_weight,
        rationality=conditional.rationality,
    )
    mode = log_weights[:, 0].argmax(axis=-1)
    return int((mode != 0).any(axis=1).sum()), int((mode[:, 0] != 0).sum())


@given(goal_situations())
def test_the_conditional_is_the_softmax_of_the_paper_term_by_term(situation):
    weights = SoftmaxConditional(1.3, 2.1, 0.7, 0.4)
    answer = weights.conditional(situation).values
    goals, x_H = situation.goals, situation.human_position
    there = [i for i in range(len(goals)) if situation.present is None or situation.present[i]]
    for j in there:
        for r in there:
            terms = [
                1.3 * np.linalg.norm(goals[i] - x_H)
                - 2.1 * np.linalg.norm(goals[i] - goals[r])
                + 0.7 * np.linalg.norm(goals[i] - goals[j])
                for i in there
            ]
            expected = np.exp(-0.4 * (np.array(terms) - min(terms)))
            assert_allclose(answer[j, r, there], expected / expected.sum(), rtol=1e-9)


@pytest.mark.parametrize(
    "weights",
    [
        SoftmaxConditional(),
        SoftmaxConditional.study_people(),
        SoftmaxConditional.study_simulation(),
        SoftmaxConditional(0.0, 0.0, 0.0, 1.0),
    ],
)
def test_the_conditional_obeys_the_laws_of_conditionals(weights):
    check_goal_conditional(weights)


@pytest.mark.parametrize("rationality", [0.01, 0.5, 3.0])
@pytest.mark.parametrize("goals", [3, 5])
def test_weights_that_cannot_yield_never_leave_the_nearest_prior_goal(goals, rationality):
    positions = nearest_first(np.random.default_rng(goals), CASES, goals)
    for human, robot, stay in ((2.0, 0.9, 2.0), (1.0, 3.0, 3.0), (0.5, 1.0, 1.0), (3.0, 0.0, 0.0)):
        weights = SoftmaxConditional(human, robot, stay, rationality)
        assert not weights.can_yield
        assert weights.yielding_share == 0.0
        assert leaving(positions, weights) == (0, 0)


def test_weights_that_can_yield_leave_it_whenever_the_detour_is_small_enough():
    positions = nearest_first(np.random.default_rng(1), CASES, 3)
    for weights in (SoftmaxConditional(2.0, 2.0, 1.0), SoftmaxConditional(1.0, 1.2, 1.0)):
        assert weights.can_yield
        share = weights.yielding_share
        distance = np.linalg.norm(positions, axis=2)
        between = np.linalg.norm(positions - positions[:, :1], axis=2)
        accepted = (distance - distance[:, :1] < share * between)[:, 1:].any(axis=1)
        assert leaving(positions, weights)[1] == accepted.sum()
        assert 0 < accepted.sum() < CASES


def test_with_the_default_weights_the_human_always_leaves_the_robot_its_goal():
    assert SoftmaxConditional().yielding_share == 1.0
    positions = nearest_first(np.random.default_rng(2), CASES, 3)
    assert leaving(positions, SoftmaxConditional())[1] == CASES


def test_a_human_to_whom_distance_is_nothing_yields_at_any_detour():
    assert SoftmaxConditional(human_weight=0.0).yielding_share == np.inf
    assert SoftmaxConditional(human_weight=0.0, robot_weight=1.0).yielding_share == 0.0


def test_the_study_used_two_sets_of_weights():
    simulated, people = SoftmaxConditional.study_simulation(), SoftmaxConditional.study_people()
    assert (simulated.human_weight, simulated.robot_weight, simulated.stay_weight) == (2.0, 0.9, 2.0)
    assert (people.human_weight, people.robot_weight, people.stay_weight, people.rationality) == (1, 3, 3, 3)
    assert not simulated.can_yield
    assert not people.can_yield


def test_many_situations_at_once_are_what_each_is_alone():
    rng = np.random.default_rng(0)
    goals, human = rng.normal(size=(2, 7, 4, 2)), rng.normal(size=(7, 2))
    present = rng.random((2, 7, 4)) < 0.7
    present[..., 0] = True
    together = conditional_log_weights(goals, human, present=present)
    assert together.shape == (2, 7, 4, 4, 4)
    for i, j in np.ndindex(2, 7):
        alone = conditional_log_weights(goals[i, j], human[j], present=present[i, j])
        assert_allclose(together[i, j], alone, atol=1e-12)


def test_where_absent_goals_lie_does_not_matter():
    goals, present = np.array([[1.0, 0.0], [0.0, 2.0], [np.nan, np.inf]]), np.array([True, True, False])
    whole = np.exp(conditional_log_weights(goals, np.zeros(2), present=present))
    assert_allclose(whole[:2, :2, :2], np.exp(conditional_log_weights(goals[:2], np.zeros(2))))
    assert (whole[..., 2] == 0).all()
    assert_allclose(whole.sum(axis=-1), 1.0)


def test_great_distances_and_rationalities_are_no_trouble():
    log_weights = conditional_log_weights(np.array([[1e6, 0.0], [0.0, 1.0]]), np.zeros(2), rationality=100.0)
    assert np.isfinite(log_weights).all()
    assert_allclose(np.exp(log_weights).sum(axis=-1), 1.0)


@given(goal_situations())
def test_the_belief_after_the_reaction_is_the_sum_over_prior_goals(situation):
    conditional = SoftmaxConditional().conditional(situation)
    post = post_goals(conditional, situation.belief)
    assert_allclose(
        post.values, np.einsum("j,jri->ri", situation.belief.values, conditional.values), rtol=1e-9
    )
    assert post.conditions == ("robot_goal",)
    overall = overall_post(post, situation.mental_model)
    assert_allclose(overall.values, situation.mental_model.values @ post.values, rtol=1e-9)
    turned = conditional.align("robot_goal", "post_goal", "goal")
    assert_allclose(post_goals(turned, situation.belief).values, post.values, rtol=1e-9)


@given(goal_situations(), st.sampled_from([0.01, 0.5, 3.0, 40.0, 1e4]))
def test_the_short_way_to_the_belief_after_the_reaction_is_the_long_one(situation, rationality):
    weights = SoftmaxConditional(1.3, 2.1, 0.7, rationality)
    long_way = post_goals(weights.conditional(situation), situation.belief).log_values
    assert_allclose(weights.post(situation).log_values, long_way, rtol=1e-9, atol=1e-9)


@given(st.sampled_from([(), ("goal",), ("robot_goal",), ("robot_goal", "goal")]))
def test_a_conditional_may_be_given_less(given_axes):
    axes = dict(
        zip(("goal", "robot_goal", "post_goal"), goal_axes(Axis("goal", ["a", "b", "c"])), strict=True)
    )
    rng = np.random.default_rng(len(given_axes))
    values = rng.dirichlet(np.ones(3), size=(3,) * len(given_axes))
    conditional = Distribution.from_probabilities(
        [*(axes[name] for name in given_axes), axes["post_goal"]], values, given=given_axes
    )
    belief = Distribution.from_probabilities([axes["goal"]], [0.5, 0.3, 0.2])
    whole = np.broadcast_to(values, (3,) * (3 - values.ndim) + values.shape)
    if given_axes == ("goal",):
        whole = np.broadcast_to(values, (3, 3, 3))
        expected = np.einsum("j,rji->ri", belief.values, whole)
    elif "goal" in given_axes:
        expected = np.einsum("j,rji->ri", belief.values, whole)
    else:
        expected = np.broadcast_to(values, (3, 3))
    post = post_goals(conditional, belief)
    assert post.axes == (axes["robot_goal"], axes["post_goal"])
    assert_allclose(post.values, expected, rtol=1e-12)


def test_what_is_no_conditional_over_goals_is_refused():
    goal, robot_goal, post_goal = goal_axes(Axis("goal", ["a", "b"]))
    belief = Distribution.uniform(goal)
    with pytest.raises(ModelError, match="random in post_goal"):
        post_goals(Distribution.uniform(robot_goal, post_goal), belief)
    with pytest.raises(ModelError, match="batch"):
        post_goals(
            Distribution.uniform(Axis("sample", 2), goal, post_goal, given=["goal"], batch=["sample"]), belief
        )
    other = Axis("goal", ["a", "c"])
    with pytest.raises(AxisError, match="differs"):
        post_goals(Distribution.uniform(other, post_goal, given=["goal"]), belief)
    with pytest.raises(ModelError, match="p\\(robot_goal\\)"):
        overall_post(unmoved_post(belief), belief)


@pytest.mark.parametrize(
    "weights",
    [{"human_weight": -1.0}, {"robot_weight": np.nan}, {"stay_weight": np.inf}, {"rationality": 0.0}],
)
def test_weights_out_of_range_are_refused(weights):
    with pytest.raises(ModelError, match=next(iter(weights))):
        SoftmaxConditional(**weights)


class Sticky(GoalConditional):
    """Gives what is absent a chance."""

    def conditional(self, situation):
        goal, _, post_goal = goal_axes(situation.belief.axes[0])
        return Distribution.uniform(goal, post_goal, given=["goal"])


class FirstIsBest(GoalConditional):
    """Looks at the number of a goal."""

    def conditional(self, situation):
        whole = SoftmaxConditional().conditional(situation)
        tilted = whole.log_values + np.arange(len(situation.goals))
        tilted -= np.logaddexp.reduce(tilted, axis=-1, keepdims=True)
        return Distribution(whole.axes, tilted, given=["goal", "robot_goal"])


class Deaf(GoalConditional):
    """Minds nobody; what it says of goals that are absent is theirs."""

    def conditional(self, situation):
        goal, _, post_goal = goal_axes(situation.belief.axes[0])
        return Distribution.from_probabilities([goal, post_goal], np.eye(len(goal)), given=["goal"])


def test_who_minds_nobody_obeys_the_laws_whatever_is_absent():
    check_goal_conditional(Deaf())


def test_a_conditional_that_breaks_a_law_is_told_which():
    with pytest.raises(AssertionError, match="absent goal is a post goal"):
        check_goal_conditional(Sticky())
    with pytest.raises(AssertionError, match="order in which goals are listed"):
        check_goal_conditional(FirstIsBest())
    check_goal_conditional(FirstIsBest(), symmetric=False)


def test_a_situation_without_goals_is_refused():
    with pytest.raises(ModelError, match="one at least"):
        replace(example_goal_situation(), present=np.zeros(3, dtype=bool))
