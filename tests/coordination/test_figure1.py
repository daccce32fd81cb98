"""Figure 1 of the paper: two equilibria, each letting another agent reach its goal first; who goes first?"""

from __future__ import annotations

import numpy as np
import pytest

from ppinfer.coordination import (
    BayesNash,
    Defensive,
    MinNorm,
    Motion,
    NormNash,
    OracleNash,
    Personality,
    PlanSet,
    Selfish,
    Situation,
    coordination_equilibria,
)
from ppinfer.games import pure_equilibria, undominated

ROBOT_FIRST, HUMAN_FIRST = (0, 1), (1, 0)


def table(motion=None):
    """Return the robot 6 s and the human 7.5 s from its place across the other's way; each can go, or wait first.

    The second plan of each waits 5 s at its start and goes then; the third never moves.
    """
    plans = [
        PlanSet(
            agent,
            [2, 3, 1],
            [0.0, duration, 0.0, 5.0, 5.0 + duration, 0.0],
            [[0.0], [1.0], [0.0], [0.0], [1.0], [0.0]],
            static=2,
        )
        for agent, duration in (("robot", 6.0), ("human", 7.5))
    ]
    # who sets out together collides, at once or after having waited together
    collides = np.full((3, 3), np.inf)
    collides[0, 0], collides[1, 1] = 2.0, 7.0
    return Situation.from_contacts(plans, collides, motion=motion)


def seen(human):
    """Return the motion of 0.8 s in which the robot waited and the human moved so far, rad."""
    moved = np.linspace([[0.0], [0.0]], [[0.0], [human]], 9)
    return Motion(moved, np.zeros_like(moved), np.zeros(9, bool))


def test_there_are_two_equilibria_each_favouring_one_agent():
    game = table().game
    found = coordination_equilibria(game).values
    assert {tuple(cell) for cell in np.argwhere(found).tolist()} == {ROBOT_FIRST, HUMAN_FIRST}
    assert game.costs[:, 0, 1].tolist() == [6.0, 12.5]
    assert game.costs[:, 1, 0].tolist() == [11.0, 7.5]


def test_a_collision_is_no_equilibrium_because_each_would_rather_wait():
    assert pure_equilibria(table().game).values[0, 0] == 0.0
    assert undominated(table().game, pure_equilibria(table().game)).values.sum() == 2.0


def test_the_norm_lets_the_robot_go_first_which_is_closer():
    p = MinNorm(rationality=1.0).probabilities(table().game, coordination_equilibria(table().game)).values
    assert p[ROBOT_FIRST] == pytest.approx(1 / (1 + np.exp(-1.5)), abs=1e-12)
    assert p[HUMAN_FIRST] == pytest.approx(1 / (1 + np.exp(1.5)), abs=1e-12)


@pytest.mark.parametrize(
    ("policy", "ego", "plan"),
    [
        (Selfish(), "robot", 0), (Selfish(), "human", 0),
        (NormNash(), "robot", 0), (NormNash(), "human", 1),
        # nothing that moves is safe whatever the other does: static costs 12 s and 13.5 s
        (Defensive(), "robot", 2), (Defensive(), "human", 2),
        (OracleNash(other=Selfish()), "robot", 1), (OracleNash(other=NormNash()), "robot", 0),
        (OracleNash(other=Defensive()), "robot", 0), (OracleNash(other=Selfish()), "human", 1),
    ],
)  # fmt: skip
def test_each_policy_plays_its_part(policy, ego, plan):
    assert policy.decide(table(), ego).plan == plan


def test_at_first_the_robot_goes_and_a_human_who_does_not_wait_is_given_way():
    policy = BayesNash()
    first = policy.decide(table(), "robot")
    assert first.profile == ROBOT_FIRST
    assert first.belief.values.tolist() == [0.5, 0.5]
    pushing = waiting = first
    for _ in range(2):
        pushing = policy.decide(table(seen(human=0.8 / 7.5)), "robot", pushing.memory)
        waiting = policy.decide(table(seen(human=0.0)), "robot", waiting.memory)
    assert pushing.profile == HUMAN_FIRST
    assert waiting.profile == ROBOT_FIRST
    assert waiting.belief.prob(theta="robot") == pytest.approx(pushing.belief.prob(theta="human"), abs=1e-12)


def test_the_belief_is_what_one_gets_by_hand():
    state = Personality().observe(table(), "robot", None)
    state = Personality().observe(table(seen(human=0.8 / 7.5)), "robot", state)
    waits, goes = np.exp(-10 * 0.8 / 7.5), 1.0
    likelihood = 0.96 * np.array([waits, goes]) / (waits + goes) + 0.02
    np.testing.assert_allclose(state.belief.values, likelihood / likelihood.sum(), rtol=1e-12)


def test_p_of_a_is_the_product_of_norm_and_personality():
    policy = BayesNash()
    state = policy.personality.observe(table(), "robot", None)
    decision = policy.decide(table(seen(human=0.02)), "robot", state)
    later = policy.personality.observe(table(seen(human=0.02)), "robot", state)
    p_n = policy.norm.probabilities(table().game, coordination_equilibria(table().game))
    expected = (p_n * later.p_alpha).normalize("robot_plan", "human_plan")
    np.testing.assert_allclose(decision.distribution.values, expected.values, rtol=1e-12)
