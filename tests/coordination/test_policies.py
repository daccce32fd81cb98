"""What each policy does in games where the answer is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer.coordination import (
    BayesNash,
    Defensive,
    LiteralBayesNash,
    LiteralPersonality,
    MinNorm,
    NormNash,
    OracleNash,
    PlanSet,
    Selfish,
    Situation,
    coordination_equilibria,
)
from ppinfer.coordination.choice import best_profile
from ppinfer.errors import ModelError
from ppinfer.testing import example_situation, situations


def of_durations(robot, human, collides):
    """Return a situation of straight plans that last so long, and a static one each."""

    def plans(agent, durations):
        return PlanSet(
            agent,
            [2] * len(durations) + [1],
            [time for duration in durations for time in (0.0, duration)] + [0.0],
            [[0.0], [1.0]] * len(durations) + [[0.0]],
            static=len(durations),
        )

    sets = [plans("robot", robot), plans("human", human)]
    return Situation.from_contacts(sets, np.where(collides, 1.0, np.inf))


NOWHERE = np.zeros((3, 3), bool)
EVERYWHERE = np.ones((3, 3), bool)


def test_defensive_takes_the_plan_that_is_safe_whatever_the_other_does():
    collides = NOWHERE.copy()
    collides[0, 1] = True
    assert Defensive().decide(of_durations([2.0, 5.0], [3.0, 3.0], collides), "robot").plan == 1


def test_defensive_takes_the_quickest_of_the_safe_plans_and_the_lowest_number_of_those():
    decision = Defensive().decide(of_durations([4.0, 4.0], [3.0, 3.0], NOWHERE), "robot")
    assert decision.plan == 0
    assert decision.profile is None
    np.testing.assert_allclose(decision.distribution.values, [0.5, 0.5, 0.0])


def test_defensive_takes_the_plan_that_collides_with_the_fewest_where_none_is_safe():
    collides = EVERYWHERE.copy()
    collides[1, :2] = False
    assert Defensive().decide(of_durations([2.0, 5.0], [3.0, 3.0], collides), "robot").plan == 1


def test_defensive_stays_where_staying_collides_no_more_than_moving():
    for collides in (EVERYWHERE, np.eye(3, dtype=bool)):
        assert Defensive().decide(of_durations([2.0, 5.0], [3.0, 3.0], collides), "robot").plan == 2


@settings(max_examples=30)
@given(situations())
def test_defensive_is_the_maximin_of_11(situation):
    decision = Defensive().decide(situation, "human")
    worst = np.moveaxis(situation.game.costs[1], 1, 0).reshape(len(situation.plans[1]), -1).max(axis=1)
    if np.isfinite(worst).any():
        assert worst[decision.plan] == worst.min()


@settings(max_examples=30)
@given(situations(agents=(2,)), st.sampled_from(["robot", "human"]))
def test_selfish_and_norm_play_the_best_equilibrium_of_12_and_13(situation, ego):
    found = coordination_equilibria(situation.game).values > 0
    player = situation.player(ego)
    for policy, cost in (
        (Selfish(), situation.game.costs[player]),
        (NormNash(), situation.game.costs.min(axis=0)),
    ):
        decision = policy.decide(situation, ego)
        if not found.any():
            assert decision.profile is None
            assert decision.plan == situation.plans[player].static
            continue
        assert found[decision.profile]
        assert cost[decision.profile] == cost[found].min()


def test_selfish_is_uniform_over_the_equilibria_that_it_likes_best():
    decision = Selfish().decide(of_durations([2.0, 2.0], [3.0, 3.0], NOWHERE), "robot")
    np.testing.assert_allclose(decision.distribution.values[:2, :2], 0.25)
    assert decision.profile == (0, 0)


def test_ties_go_to_the_lowest_own_cost_then_the_lowest_own_plan_then_the_others_lowest():
    value, cost = np.zeros((2, 3)), np.array([[5.0, 4.0, 4.0], [4.0, 5.0, 4.0]])
    assert best_profile(value, cost, 0) == (0, 1)
    assert best_profile(value, cost, 1) == (1, 0)
    value[1, 2] = 1e-12
    assert best_profile(value, cost, 0) == (0, 1)
    value[1, 2] = 1e-6
    assert best_profile(value, cost, 0) == (1, 2)


@pytest.mark.parametrize("policy", [Selfish(), NormNash(), BayesNash(), LiteralBayesNash(), OracleNash()])
def test_where_every_profile_collides_everybody_holds_and_goes_on_learning(policy):
    situation = of_durations([2.0, 5.0], [3.0, 3.0], EVERYWHERE)
    for ego in ("robot", "human"):
        decision = policy.decide(situation, ego)
        assert decision.plan == 2
        assert decision.distribution.values.tolist() == [0.0, 0.0, 1.0]
        if isinstance(policy, BayesNash):
            assert policy.decide(situation, ego, decision.memory).belief is not None


def test_a_policy_says_who_there_is_when_asked_for_somebody_else():
    with pytest.raises(ModelError, match="robot, human"):
        NormNash().decide(of_durations([2.0, 5.0], [3.0, 3.0], NOWHERE), "guest")


def test_commitment_is_asked_for_and_named():
    assert NormNash().commits is False
    assert NormNash(commits=True).commits is True


def test_the_literal_policy_is_uniform_in_p_alpha_at_first_and_counts_costs_in_seconds():
    situation = example_situation(np.random.default_rng(3))
    literal = LiteralBayesNash()
    assert isinstance(literal.personality, LiteralPersonality)
    p_n = MinNorm(rationality=50.0, cost_unit=1.0).probabilities(
        situation.game, coordination_equilibria(situation.game)
    )
    np.testing.assert_allclose(literal.decide(situation, "robot").distribution.values, p_n.values, atol=1e-12)


def test_the_oracle_is_told_the_class_and_ties_belong_to_both():
    # each of two equilibria lets one agent take its quick plan
    one_at_a_time = np.zeros((3, 3), bool)
    one_at_a_time[0, 0] = True
    crossing = of_durations([4.0, 6.0], [4.5, 6.0], one_at_a_time)
    assert NormNash().decide(crossing, "robot").profile == (0, 1)
    told = OracleNash(other=Selfish()).decide(crossing, "robot")
    assert told.profile == (1, 0)
    assert told.belief.values.tolist() == [0.0, 1.0]
    even = OracleNash(other=Selfish()).decide(of_durations([4.0], [4.0], np.zeros((2, 2), bool)), "robot")
    assert even.belief.values.tolist() == [0.5, 0.5]


def test_the_oracle_remembers_for_the_policy_that_it_asks():
    situation = example_situation(np.random.default_rng(1))
    oracle = OracleNash(other=BayesNash())
    first = oracle.decide(situation, "robot")
    assert set(first.memory) == {"human"}
    np.testing.assert_allclose(first.memory["human"].belief.values, 0.5)
