"""Logit quantal response: certified fixed points on the branch from rationality 0, round turns and past crossings."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, root
from scipy.special import expit, log_softmax

from ppinfer.distributions import Axis
from ppinfer.errors import AxisError, GameError
from ppinfer.games import Game, logit_branch, logit_response, mixed_equilibria

NAMES = ["robot", "human", "guest", "cat"]
TURNING = np.array([[[97, 18], [23, 21]], [[89, 61], [36, 32]]]) / 10  # turns at rationalities 3.26 and 1.95


def expected_costs(costs, joint, player):
    """What each plan costs its player, the others drawn from their part of a joint distribution; by plain sums."""
    others = joint.sum(axis=player, keepdims=True)
    rest = tuple(axis for axis in range(joint.ndim) if axis != player)
    return (costs[player] * others).sum(axis=rest)


def assert_certified(game, profile, rationality, tolerance=1e-9):
    """Check that a joint distribution is a product, and that every player answers the others."""
    joint = profile.values
    marginals = [profile.marginal(axis.name) for axis in game.plans]
    product = sum(
        np.expand_dims(m.log_values, [i for i in range(joint.ndim) if i != k])
        for k, m in enumerate(marginals)
    )
    np.testing.assert_allclose(profile.log_values, product, atol=tolerance)
    for player, marginal in enumerate(marginals):
        answer = log_softmax(-rationality * expected_costs(game.costs, joint, player))
        np.testing.assert_allclose(marginal.log_values, answer, atol=tolerance)


def random_game(seed, players, most=4):
    rng = np.random.default_rng(seed)
    return Game(rng.normal(size=(players, *rng.integers(1, most + 1, players))), NAMES[:players])


@settings(max_examples=15)
@given(st.integers(0, 10_000), st.integers(2, 4), st.sampled_from([0.1, 1.0, 7.0, 300.0, 1e5]))
def test_every_player_answers_the_others_whatever_their_number(seed, players, rationality):
    game = random_game(seed, players, most=4 if players < 4 else 3)
    branch = logit_branch(game, [rationality])
    assert_certified(game, logit_response(game, rationality), rationality, 1e-9 + 1e-13 * rationality)
    assert branch.residual[0] <= 1e-9 + 1e-13 * rationality


@given(st.integers(0, 10_000), st.integers(1, 3))
def test_at_rationality_0_everybody_plays_at_random(seed, players):
    game = random_game(seed, players)
    np.testing.assert_allclose(
        logit_response(game, 0.0).values, 1 / np.prod(game.costs.shape[1:]), rtol=1e-14
    )


@settings(max_examples=8)
@given(st.integers(0, 10_000), st.integers(2, 3))
def test_regret_vanishes_as_rationality_grows(seed, players):
    branch = logit_branch(random_game(seed, players), [1e2, 1e4, 1e6])
    # a plan that loses d is played with probability at most exp(-rationality d), and x exp(-x) <= 1 / e
    bound = np.array([3 / np.e / rationality for rationality in (1e2, 1e4, 1e6)])
    assert (branch.regret <= bound[:, None]).all()


def test_the_limit_of_a_game_of_two_is_one_of_its_mixed_equilibria():
    rng = np.random.default_rng(5)
    for _ in range(8):
        game = Game(rng.normal(size=(2, 3, 3)), NAMES[:2])
        limit = logit_response(game, 1e7).values
        distance = np.abs(mixed_equilibria(game).profile.values - limit).max(axis=(1, 2)).min()
        assert distance < 1e-4


def test_probabilities_of_exp_minus_a_million_keep_their_digits():
    game = Game([[[0.0, 5.0], [1.0, 9.0]], [[0.0, 1.0], [3.0, 5.0]]], NAMES[:2])
    log_p = logit_response(game, 1e6).log_values
    # everybody plays the first plan; a deviation costs 1
    np.testing.assert_allclose(log_p, [[0.0, -1e6], [-1e6, -2e6]], rtol=1e-12)


def test_asymmetric_matching_pennies_has_its_closed_form():
    # the robot wants to match and gains 9 on heads; the human wants to differ
    game = Game(-np.array([[[9.0, 0.0], [0.0, 1.0]], [[0.0, 1.0], [1.0, 0.0]]]), NAMES[:2])
    for rationality in (0.3, 1.0, 4.0, 50.0):
        # p = logistic(r (10 q - 1)) rises in q, and q = logistic(r (1 - 2 p)) falls in p: they meet once
        def gap(q, r=rationality):
            return expit(r * (1 - 2 * expit(r * (10 * q - 1)))) - q

        q = brentq(gap, 0.0, 1.0, xtol=1e-15)
        p = expit(rationality * (10 * q - 1))
        response = logit_response(game, rationality)
        np.testing.assert_allclose(response.marginal("robot_plan").values, [p, 1 - p], atol=1e-12)
        np.testing.assert_allclose(response.marginal("human_plan").values, [q, 1 - q], atol=1e-12)
    # with perfect rationality p = 1/2, q = 1/10
    limit = logit_response(game, 1e8)
    np.testing.assert_allclose(limit.marginal("human_plan").values, [0.1, 0.9], atol=1e-7)
    np.testing.assert_allclose(limit.marginal("robot_plan").values, [0.5, 0.5], atol=1e-7)


def test_where_the_branch_never_turns_small_steps_with_scipy_lead_to_the_same_place():
    rng = np.random.default_rng(8)
    compared = 0
    for _ in range(8):
        game = Game(rng.normal(size=(3, 2, 3, 2)), NAMES[:3])
        branch = logit_branch(game, [3.0])
        if branch.turns:
            continue
        logits = np.zeros(7)

        def gap(logits, rationality, game=game):
            own = [log_softmax(part) for part in np.split(logits, [2, 5])]
            joint = np.exp(own[0][:, None, None] + own[1][None, :, None] + own[2])
            answers = [log_softmax(-rationality * expected_costs(game.costs, joint, i)) for i in range(3)]
            return logits - np.concatenate(answers)

        for rationality in np.linspace(0.0, 3.0, 61):
            logits = root(gap, logits, args=(rationality,), tol=1e-13).x
        found = np.concatenate([strategy.log_values[0] for strategy in branch.strategies])
        np.testing.assert_allclose(found, logits, atol=1e-9)
        compared += 1
    assert compared >= 5


def equilibria_of_two_plans(costs, rationality):
    """All logit equilibria of a 2x2 game as probabilities of the robot's first plan, by scanning a line."""

    def gap(p):
        q = expit(
            rationality
            * (p * (costs[1, 0, 1] - costs[1, 0, 0]) + (1 - p) * (costs[1, 1, 1] - costs[1, 1, 0]))
        )
        return (
            expit(
                rationality
                * (q * (costs[0, 1, 0] - costs[0, 0, 0]) + (1 - q) * (costs[0, 1, 1] - costs[0, 0, 1]))
            )
            - p
        )

    # even in the logit, so that equilibria near 0 and 1 are seen
    line = expit(np.linspace(-120.0, 120.0, 24_001))
    value = gap(line)
    return np.array(
        [brentq(gap, line[i], line[i + 1], xtol=1e-15) for i in np.flatnonzero(np.diff(value < 0))]
    )


def test_round_a_turn_the_first_passage_is_returned_and_past_it_what_the_branch_comes_to():
    game = Game(TURNING, NAMES[:2])
    last, first = logit_branch(game, [10.0]).turns
    assert 1.9 < first < 2.0 < 3.2 < last < 3.3
    at = np.array([0.5, 1.5, 2.5, 3.2, last - 1e-9, last + 1e-9, 3.5, 8.0])
    branch = logit_branch(game, at)
    p = branch.strategies[0].values[:, 0]
    numbers = []
    for rationality, own in zip(at, p, strict=True):
        every = equilibria_of_two_plans(TURNING, rationality)
        numbers.append(len(every))
        if abs(rationality - last) > 1e-6:  # nearer than that, the scan does not tell two of them apart
            assert np.abs(every - own).min() < 1e-9
    # in small steps from 0, the equilibrium that moves least
    known = {0.0: 0.5}
    for rationality in np.arange(1, 161) / 50:
        every = equilibria_of_two_plans(TURNING, rationality)
        known[rationality] = every[np.abs(every - known[max(known)]).argmin()]
    np.testing.assert_allclose(p[:4], [known[rationality] for rationality in at[:4]], atol=1e-9)
    assert numbers[:4] == [1, 1, 3, 3]
    assert numbers[-2:] == [1, 1]
    # the answer jumps at the turn
    assert abs(p[5] - p[4]) > 0.3
    assert branch.residual.max() < 1e-9
    # equilibria that the branch passes later are not returned, whatever is asked for besides
    assert np.allclose(
        logit_branch(game, [2.5]).strategies[0].values, branch.strategies[0].values[2], atol=1e-12
    )


def test_a_branch_that_bends_away_from_another_is_not_mistaken_for_it():
    # at 0 two branches cross; an unequal stake bends ours away, ever more sharply as it vanishes
    for stake in (1e-2, 1e-4, 1e-6):
        game = Game(-np.array([[[1.0 + stake, 0.0], [0.0, 1.0]]] * 2), NAMES[:2])
        branch = logit_branch(game, [200.0])
        assert branch.strategies[0].values[0, 0] > 0.999, stake
        assert not branch.crossings


def test_a_crossing_is_gone_straight_over_and_told():
    coordination = Game(-np.array([np.eye(2)] * 2), NAMES[:2])
    branch = logit_branch(coordination, [1.0, 5.0, 1e4])
    np.testing.assert_allclose(branch.profile.values, 0.25, atol=1e-12)
    assert branch.crossings == pytest.approx((2.0,), abs=1e-4)


def test_a_dominant_plan_is_played_ever_more():
    dilemma = Game([[[2.0, 10.0], [1.0, 6.0]], [[2.0, 1.0], [10.0, 6.0]]], NAMES[:2])
    p = logit_response(dilemma, np.linspace(0.0, 6.0, 25)).marginal("robot_plan").values[:, 1]
    assert (np.diff(p) > 0.0).all()
    assert p[0] == 0.5
    assert p[-1] > 0.999999


@settings(max_examples=4)
@given(st.integers(0, 10_000))
def test_a_batch_is_what_a_loop_gives_and_several_rationalities_what_one_gives(seed):
    rng = np.random.default_rng(seed)
    costs = rng.normal(size=(3, 2, 2, 3))
    batch = Game(costs, NAMES[:2], batch=[Axis("trial", 3)])
    path = [4.0, 0.5, 0.0]
    together = logit_response(batch, path)
    assert together.batch == ("trial", "rationality")
    assert together.random == ("robot_plan", "human_plan")
    for trial in range(3):
        alone = Game(costs[trial], NAMES[:2])
        for rationality in path:
            one = logit_response(alone, rationality)
            np.testing.assert_allclose(
                together.given(trial=trial, rationality=rationality).log_values, one.log_values, atol=1e-11
            )
    assert logit_response(batch, 2.0).names == ("trial", "robot_plan", "human_plan")


@settings(max_examples=6)
@given(st.integers(0, 10_000))
def test_relabelling_and_common_offsets_change_nothing_and_units_cancel(seed):
    rng = np.random.default_rng(seed)
    costs = rng.normal(size=(2, 3, 2))
    rows, columns = rng.permutation(3), rng.permutation(2)
    plain = logit_response(Game(costs, NAMES[:2]), 3.0)
    moved = logit_response(Game(costs[:, rows][:, :, columns], NAMES[:2]), 3.0)
    np.testing.assert_allclose(moved.log_values, plain.log_values[rows][:, columns], atol=1e-11)
    shifted = costs + np.stack(
        [np.broadcast_to(rng.normal(size=2), (3, 2)), np.broadcast_to(rng.normal(size=(3, 1)), (3, 2))]
    )
    np.testing.assert_allclose(
        logit_response(Game(shifted, NAMES[:2]), 3.0).log_values, plain.log_values, atol=1e-11
    )
    np.testing.assert_allclose(
        logit_response(Game(costs * 1e5, NAMES[:2]), 3e-5).log_values, plain.log_values, atol=1e-11
    )


def test_costs_that_never_differ_leave_everybody_at_random_at_any_rationality():
    np.testing.assert_allclose(logit_response(Game(np.full((2, 2, 3), 4.0), NAMES[:2]), 1e9).values, 1 / 6)


def test_plans_that_are_absent_are_never_played():
    rng = np.random.default_rng(3)
    costs = rng.normal(size=(2, 3, 3))
    there = np.outer([True, False, True], [True, True, False])
    response = logit_response(Game(costs, NAMES[:2], present=there), 2.0)
    small = logit_response(Game(costs[:, [0, 2]][:, :, :2], NAMES[:2]), 2.0)
    np.testing.assert_allclose(response.log_values[[0, 2]][:, :2], small.log_values, atol=1e-12)
    assert (response.log_values[~there] == -np.inf).all()


def test_what_has_no_answer_is_refused_with_what_to_do():
    collide = Game([[[np.inf, 1.0], [2.0, 2.0]], [[np.inf, 2.0], [1.0, 2.0]]], NAMES[:2])
    with pytest.raises(GameError, match=r"inf at player='robot', robot_plan=0, human_plan=0.*infinite_as="):
        logit_response(collide, 1.0)
    assert logit_response(collide, 1.0, infinite_as=30.0).prob(robot_plan=0, human_plan=0) < 0.05
    game = random_game(0, 2)
    for wrong in (-1.0, np.nan, np.inf):
        with pytest.raises(GameError, match="finite and >= 0"):
            logit_response(game, wrong)
    with pytest.raises(GameError, match="mixed_equilibria"):
        logit_response(game, np.inf)
    with pytest.raises(GameError, match="a number"):
        logit_response(game, "high")
    with pytest.raises(GameError, match="one-dimensional"):
        logit_response(game, [[1.0]])
    with pytest.raises(AxisError, match="repeated"):
        logit_response(game, [1.0, 1.0])
    with pytest.raises(GameError, match=r"write \[1.0\]"):
        logit_branch(game, 1.0)
    with pytest.raises(GameError, match=r"restrict\(trial="):
        logit_branch(Game(np.zeros((4, 2, 2, 2)), NAMES[:2], batch=[Axis("trial", 4)]), [1.0])
