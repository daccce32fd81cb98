import numpy as np
import pytest

from ppinfer.errors import ModelError
from ppsim.reaching import ChangingMind, NearestGoal, NearGoal, Observation, RandomGoal
from ppsim.reaching.goal_choice import GOAL_CHOICES

GOALS = np.array([[1.0, 0.0], [5.0, 0.0], [0.0, 9.0]])


def seen_by_human(robot=(50.0, 50.0)):
    at_rest = {"human": np.zeros(2), "robot": np.zeros(2)}
    return Observation(
        agent="human",
        time=0.0,
        position={"human": np.zeros(2), "robot": np.array(robot)},
        velocity=at_rest,
        state=np.zeros(4),
        goals=GOALS,
        drawn=0,
        score=0,
    )


@pytest.mark.parametrize("kind", GOAL_CHOICES.values())
def test_a_goal_is_kept_while_it_is_free(kind):
    rng = np.random.default_rng(0)
    assert {kind().choose(seen_by_human(), 2, rng) for _ in range(50)} == {2}


@pytest.mark.parametrize("kind", GOAL_CHOICES.values())
def test_only_those_who_yield_leave_a_goal_that_another_agent_is_at(kind):
    rng = np.random.default_rng(0)
    robot_there = seen_by_human(robot=(1.0, 0.4))
    assert 0 not in {kind(yields=True).choose(robot_there, current, rng) for current in (0, None) * 50}
    assert {kind(yields=False).choose(robot_there, 0, rng) for _ in range(50)} == {0}


def test_the_nearest_goal_is_the_nearest():
    assert NearestGoal().choose(seen_by_human(), None, np.random.default_rng(0)) == 0


def test_random_goals_are_drawn_evenly_and_near_ones_by_their_distance():
    rng = np.random.default_rng(1)
    drawn = [RandomGoal().choose(seen_by_human(), None, rng) for _ in range(3000)]
    np.testing.assert_allclose(np.bincount(drawn) / 3000, 1 / 3, atol=0.03)
    near = [NearGoal(scale=4.0).choose(seen_by_human(), None, rng) for _ in range(3000)]
    weight = np.exp(-np.array([1.0, 5.0, 9.0]) / 4.0)
    np.testing.assert_allclose(np.bincount(near) / 3000, weight / weight.sum(), atol=0.03)


def test_a_mind_changes_as_often_as_it_should_and_to_any_other_goal():
    rng = np.random.default_rng(2)
    choice = ChangingMind(NearestGoal(yields=False), stay=0.9)
    drawn = np.bincount([choice.choose(seen_by_human(), 1, rng) for _ in range(4000)]) / 4000
    np.testing.assert_allclose(drawn, [0.05, 0.9, 0.05], atol=0.015)


def test_a_probability_of_staying_lies_between_0_and_1():
    with pytest.raises(ModelError, match="stay"):
        ChangingMind(NearestGoal(), stay=1.5)
