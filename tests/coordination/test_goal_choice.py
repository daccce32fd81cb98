"""Goals as plans of a game: its equilibria by brute force, and what they make of the first paper's personality."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal

from ppinfer import Axis, Distribution
from ppinfer.coordination import GoalChoiceGame, coordination_equilibria
from ppinfer.coordination.classes import favoured_classes, log_p_alpha
from ppinfer.errors import ModelError

PLACE = st.floats(-10.0, 10.0).map(lambda value: round(value, 3))


@settings(max_examples=60, deadline=None)
@given(st.integers(2, 4).flatmap(lambda count: arrays(np.float64, (count + 2, 2), elements=PLACE)))
def test_it_is_uniform_over_the_equilibria_that_favour_theta(places):
    *goals, human, robot = places
    goals = np.array(goals)
    count = len(goals)
    time = [[np.linalg.norm(goal - agent) for goal in goals] for agent in (robot, human)]
    pairs = [(r, h) for r in range(count) for h in range(count) if r != h]
    stable = [
        (r, h)
        for r, h in pairs
        if all(time[0][r] <= time[0][other] for other in range(count) if other != h)
        and all(time[1][h] <= time[1][other] for other in range(count) if other != r)
    ]

    def better(one, other):
        costs = [(time[0][r], time[1][h]) for r, h in (one, other)]
        return all(a <= b for a, b in zip(*costs, strict=True)) and costs[0] != costs[1]

    left = [pair for pair in stable if not any(better(other, pair) for other in stable)]
    best = [min(time[0][r] for r, _ in left), min(time[1][h] for _, h in left)]
    found = GoalChoiceGame().goals_given_theta(goals, human, robot)
    for theta in range(2):
        loss = [(time[0][r] - best[0], time[1][h] - best[1]) for r, h in left]
        favour = [
            pair for pair, paid in zip(left, loss, strict=True) if paid[theta] <= min(paid) + 1e-9
        ] or left
        expected = np.zeros((count, count))
        for pair in favour:
            expected[pair] = 1 / len(favour)
        assert_allclose(found.values[theta], expected, atol=1e-12)


def test_many_games_at_once_are_the_games_one_by_one():
    rng = np.random.default_rng(0)
    goals, human, robot = (
        rng.uniform(-5, 5, (6, 4, 2)),
        rng.uniform(-5, 5, (6, 2)),
        rng.uniform(-5, 5, (6, 2)),
    )
    present = rng.random((6, 4)) < 0.8
    present[:, :2] = True
    choice = GoalChoiceGame()
    all_at_once = choice.goals_given_theta(goals, human, robot, present)
    reaction = choice.log_reaction(goals.reshape(2, 3, 4, 2), human.reshape(2, 3, 2), robot.reshape(2, 3, 2))
    assert reaction.shape == (2, 3, 2, 4, 4, 4)
    for row in range(6):
        one = choice.goals_given_theta(goals[row], human[row], robot[row], present[row])
        assert_array_equal(all_at_once.values[row], one.values)
        assert_array_equal(
            reaction.reshape(6, 2, 4, 4, 4)[row], choice.log_reaction(goals[row], human[row], robot[row])
        )


def test_a_personality_and_the_equilibria_of_goals_compose_to_p_alpha_of_the_first_paper():
    goals = np.array([[0.0, 0.0], [0.0, 4.0], [5.0, 5.0]])
    human, robot = np.array([1.0, 0.0]), np.array([-1.0, -0.5])
    choice = GoalChoiceGame()
    theta = Distribution.from_probabilities([Axis("theta", ["robot", "human"])], [0.2, 0.8])
    joint = theta * choice.goals_given_theta(goals, human, robot)
    profiles = joint.marginal("robot_goal", "human_goal").align("robot_goal", "human_goal")
    game = choice.game(goals, human, robot)
    among = coordination_equilibria(game).log_values > -np.inf
    classes = favoured_classes(game.costs, among, favour_by="loss")
    p_alpha = np.exp(log_p_alpha(theta.log_values, classes.reshape(2, -1), among.reshape(-1)))
    assert_allclose(profiles.values.reshape(-1), p_alpha, atol=1e-12)
    # and the other way round: a choice that was seen tells whom the human favours
    assert joint.given(human_goal=0).marginal("theta").prob(theta="human") == pytest.approx(1.0)


def test_with_one_goal_there_is_no_equilibrium_and_who_reacts_keeps_it():
    choice = GoalChoiceGame()
    goals = np.array([[0.0, 0.0], [1.0, 0.0]])
    alone = np.array([True, False])
    with pytest.raises(ModelError, match="too few"):
        choice.goals_given_theta(goals, np.ones(2), np.zeros(2), alone)
    reaction = np.exp(choice.log_reaction(goals, np.ones(2), np.zeros(2), alone))
    assert_array_equal(reaction[:, 0, 0], [[1.0, 0.0], [1.0, 0.0]])
    with pytest.raises(ModelError, match="speed"):
        GoalChoiceGame(speed=0.0)
