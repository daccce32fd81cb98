"""Every pure equilibrium and nothing else: against brute force, one game or many, ties and infinities included."""

from __future__ import annotations

import inspect
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer import Axis, AxisError, Factor
from ppinfer.errors import GameError
from ppinfer.games import Game, finite_profiles, pure_equilibria, regret, undominated
from ppinfer.testing import (
    check_game_batch_equals_loop,
    check_game_relabelling,
    check_player_order,
    check_pure_equilibria,
    games,
)

INF = np.inf


def random_games(seed, count, players, *, low=1, high=4):
    """Yield small games whose costs tie often, are infinite often, and of which profiles may be absent."""
    rng = np.random.default_rng(seed)
    names = ["robot", "human", "guest", "cat"][:players]
    for _ in range(count):
        sizes = rng.integers(low, high + 1, players)
        costs = rng.integers(0, 4, (players, *sizes)).astype(float)
        costs[costs == 3.0] = INF if rng.random() < 0.7 else 3.0
        if rng.random() < 0.5:  # collisions cost everybody the same
            costs[:, rng.random(sizes) < 0.3] = INF
        present = rng.random(sizes) < 0.8 if rng.random() < 0.3 else None
        yield Game(costs, names, present=present)


def literal_equilibria(game):
    """Mark the profiles of one game at which nobody has a better reply, one deviation after another."""
    shape = game.costs.shape[1:]
    exists = np.ones(shape, bool) if game.present is None else game.present
    mask = exists.copy()
    for profile in np.ndindex(shape):
        for player, plans in enumerate(shape):
            for plan in range(plans):
                other = (*profile[:player], plan, *profile[player + 1 :])
                if exists[other] and game.costs[player][other] < game.costs[player][profile]:
                    mask[profile] = False
    return mask


def literal_undominated(game, among, *, strict):
    """Mark what no other marked profile dominates, one pair after another."""
    mask = among.copy()
    for profile, other in product(np.argwhere(among), repeat=2):
        mine, theirs = game.costs[(slice(None), *profile)], game.costs[(slice(None), *other)]
        if (theirs < mine).all() if strict else ((theirs <= mine).all() and (theirs < mine).any()):
            mask[tuple(profile)] = False
    return mask


def marked(factor):
    assert set(np.unique(factor.values)) <= {0.0, 1.0}
    return factor.values == 1.0


@pytest.mark.parametrize(("players", "count"), [(1, 300), (2, 4000), (3, 700), (4, 100)])
def test_of_thousands_of_random_games_no_equilibrium_is_missed_and_none_is_added(players, count):
    found = 0
    for game in random_games(players, count, players):
        expected = literal_equilibria(game)
        assert np.array_equal(marked(pure_equilibria(game)), expected)
        found += expected.sum()
    assert found > count / 2


@given(games(max_batch=2))
def test_equilibria_are_those_of_the_definition(game):
    check_pure_equilibria(game)


@given(games(max_batch=2))
def test_equilibria_are_where_all_regrets_are_zero(game):
    regrets = regret(game)
    assert regrets.shape == game.costs.shape
    none = (regrets == 0.0).all(axis=len(game.batch))
    assert np.array_equal(marked(pure_equilibria(game)), none)
    exists = np.ones(none.shape, bool) if game.present is None else game.present
    assert np.array_equal(~np.isnan(regrets).any(axis=len(game.batch)), exists)
    assert (regrets[~np.isnan(regrets)] >= 0.0).all()


def test_regret_is_own_cost_less_that_of_the_best_reply():
    game = Game([[[5.0, INF], [2.0, INF], [INF, INF]], [[1.0, 4.0], [INF, 3.0], [INF, INF]]], ["a", "b"])
    assert np.array_equal(
        regret(game),
        [[[3.0, 0.0], [0.0, 0.0], [INF, 0.0]], [[0.0, 3.0], [INF, 0.0], [0.0, 0.0]]],
    )


@pytest.mark.parametrize(
    ("own", "best", "expected"), [(INF, INF, 0.0), (INF, 1.0, INF), (3.0, 1.0, 2.0), (1.0, 1.0, 0.0)]
)
def test_infinite_costs_leave_no_regret_unless_a_finite_reply_is_there(own, best, expected):
    assert regret(Game([[own, best]], ["robot"]))[0, 0] == expected


def test_regrets_tell_the_smallest_differences_apart():
    costs = np.array([[1.0, 1.0 + 2**-52, 1.0]])
    assert marked(pure_equilibria(Game(costs, ["a"]))).tolist() == [True, False, True]
    assert regret(Game([[0.0, 5e-324, -0.0]], ["a"])).tolist() == [[0.0, 5e-324, 0.0]]


def test_a_game_of_collisions_only_has_vacuous_equilibria_which_finite_profiles_leave_out():
    game = Game(np.full((2, 2, 2), INF), ["robot", "human"])
    assert marked(pure_equilibria(game)).all()
    assert not marked(finite_profiles(game)).any()
    assert not marked(pure_equilibria(game) * finite_profiles(game)).any()


@given(games(max_batch=2))
def test_finite_profiles_cost_everybody_a_finite_amount(game):
    exists = True if game.present is None else game.present
    expected = np.isfinite(game.costs).all(axis=len(game.batch)) & exists
    assert np.array_equal(marked(finite_profiles(game)), expected)


@given(games(min_players=2, max_batch=1), st.data())
def test_the_order_of_plans_and_players_makes_no_difference(game, data):
    def best(some):
        return undominated(some, pure_equilibria(some) * finite_profiles(some))

    axis = data.draw(st.sampled_from(game.axes))
    labels = data.draw(st.permutations(list(axis.labels)))
    order = data.draw(st.permutations(range(len(game.players))))
    for operation in (pure_equilibria, finite_profiles, best):
        check_game_relabelling(operation, game, axis.name, labels)
        check_player_order(operation, game, order)


@given(games(max_batch=2))
def test_a_batch_of_games_is_a_loop_over_them(game):
    for axis in game.batch:
        for operation in (
            pure_equilibria,
            finite_profiles,
            lambda some: undominated(some, finite_profiles(some)),
        ):
            check_game_batch_equals_loop(operation, game, axis.name)


def test_games_are_many_in_one_call():
    rng = np.random.default_rng(5)
    costs = rng.integers(0, 40, (20_000, 2, 8, 8)).astype(float)
    costs[rng.random(costs.shape) < 0.1] = INF
    game = Game(costs, ["robot", "human"], batch=[Axis("scene", 20_000)])
    best = (costs <= costs.min(axis=(2), keepdims=True))[:, 0] & (costs <= costs.min(axis=3, keepdims=True))[
        :, 1
    ]
    equilibria = pure_equilibria(game)
    assert np.array_equal(marked(equilibria), best)
    left = marked(undominated(game, equilibria))
    for scene in range(0, 20_000, 500):
        one = game.restrict(scene=scene)
        assert np.array_equal(left[scene], literal_undominated(one, best[scene], strict=False))


@pytest.mark.parametrize("dominance", ["weak", "strict"])
@pytest.mark.parametrize("players", [1, 2, 3])
def test_dominated_profiles_are_dropped_and_no_others(players, dominance):
    rng = np.random.default_rng(players)
    for game in random_games(10 + players, 300, players):
        exists = True if game.present is None else game.present
        among = (rng.random(game.costs.shape[1:]) < 0.7) & exists
        factor = Factor.from_mask(game.axes, among)
        expected = literal_undominated(game, among, strict=dominance == "strict")
        assert np.array_equal(marked(undominated(game, factor, dominance=dominance)), expected)


@given(games(min_players=2, max_batch=1))
def test_weak_dominance_drops_what_strict_dominance_drops(game):
    among = pure_equilibria(game)
    weak = marked(undominated(game, among, dominance="weak"))
    strict = marked(undominated(game, among, dominance="strict"))
    assert (weak <= strict).all()
    assert (strict <= marked(among)).all()
    # something is left wherever there was something
    over = tuple(range(len(game.batch), weak.ndim))
    assert np.array_equal(weak.any(axis=over), marked(among).any(axis=over))


def test_profiles_are_compared_where_a_factor_is_positive_whatever_its_axes_order():
    game = Game([[[1.0, 2.0], [3.0, 4.0]], [[1.0, 2.0], [3.0, 4.0]]], ["a", "b"])
    weights = Factor.from_values([game.plans[1], game.plans[0]], [[0.0, 0.3], [2.0, 0.0]])
    assert marked(undominated(game, weights)).tolist() == [[False, True], [False, False]]


def test_what_is_constant_in_the_batch_is_compared_in_every_game():
    costs = np.arange(8.0).reshape(2, 2, 1, 2)
    costs[1] = costs[1, :, :, ::-1]
    game = Game(costs, ["a", "b"], batch=[Axis("trial", 2)])
    everywhere = Factor.from_mask(game.plans, np.ones((1, 2), bool))
    assert marked(undominated(game, everywhere)).tolist() == [[[True, False]], [[False, True]]]


def test_absent_profiles_are_never_compared():
    game = Game([[1.0, 2.0]], ["a"], present=[False, True])
    everything = Factor.from_mask(game.axes, np.ones(2, bool))
    assert marked(undominated(game, everything)).tolist() == [False, True]


def test_what_is_compared_must_be_over_the_games_axes():
    game = Game(np.zeros((2, 2, 2)), ["a", "b"])
    with pytest.raises(AxisError):
        undominated(game, Factor.from_values([Axis("goal", 2)], [1.0, 1.0]))
    with pytest.raises(GameError, match="'weak' or 'strict', not 'strong'"):
        # without the checks of annotations, which see to it while tests run
        inspect.unwrap(undominated)(game, pure_equilibria(game), dominance="strong")


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.integers(2, 3), st.sampled_from(["weak", "strict"]))
def test_a_large_game_is_filtered_as_a_small_one(seed, players, dominance):
    rng = np.random.default_rng(seed)
    game = Game(rng.integers(0, 30, (players, *([6] * players))).astype(float), list("abc")[:players])
    among = np.ones(game.costs.shape[1:], bool)
    expected = literal_undominated(game, among, strict=dominance == "strict") if players == 2 else None
    left = marked(undominated(game, finite_profiles(game), dominance=dominance))
    if expected is not None:
        assert np.array_equal(left, expected)
        return
    flat = game.costs.reshape(players, -1).T
    worse, cheaper = (flat[:, None] >= flat[None]), (flat[:, None] > flat[None])
    dropped = cheaper.all(-1).any(1) if dominance == "strict" else (worse.all(-1) & cheaper.any(-1)).any(1)
    assert np.array_equal(left.ravel(), ~dropped)
