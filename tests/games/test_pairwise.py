"""Equilibria of many agents without the table of all profiles: exactly those that the table gives."""

from __future__ import annotations

import pickle
from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer.distributions import Axis, Factor
from ppinfer.errors import AxisError, GameError
from ppinfer.games import PairwiseGame, finite_profiles, pairwise_equilibria, pure_equilibria, undominated

INF = np.inf


@st.composite
def pairwise_games(draw, *, most_profiles=3000):
    """Draw games of 2 to 5 players of 1 to 6 plans: any density of collisions, ties, infinite plans, pairs left out."""
    players = draw(st.integers(2, 5))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    sizes = rng.integers(1, 7, players)
    while np.prod(sizes) > most_profiles:
        sizes[sizes.argmax()] -= 1
    density = draw(st.sampled_from([0.0, 0.1, 0.3, 0.6, 0.9, 1.0]))
    few_values = draw(st.booleans())
    costs = [rng.integers(0, 4, k).astype(float) if few_values else rng.uniform(1, 10, k) for k in sizes]
    if draw(st.booleans()):
        for cost in costs:
            cost[rng.random(len(cost)) < 0.2] = INF
    collisions = {}
    for one, other in combinations(range(players), 2):
        if rng.random() < 0.9:
            table = rng.random((sizes[one], sizes[other])) < density
            key, table = ((one, other), table) if rng.random() < 0.5 else ((other, one), table.T)
            collisions[key] = table
    return PairwiseGame(costs, collisions, [f"agent{i}" for i in range(players)])


def mask_of(found):
    mask = np.zeros(found.game.shape, bool)
    mask[tuple(found.profiles.T)] = True
    assert mask.sum() == len(found)
    return mask


@settings(max_examples=200)
@given(pairwise_games())
def test_the_search_gives_exactly_what_the_table_gives(game):
    dense = game.to_game()
    every = pure_equilibria(dense)
    finite = every * finite_profiles(dense)
    assert np.array_equal(mask_of(pairwise_equilibria(game)), finite.values > 0)
    assert np.array_equal(mask_of(pairwise_equilibria(game, collision_free=False)), every.values > 0)


@settings(max_examples=100)
@given(pairwise_games(), st.sampled_from(["weak", "strict"]), st.booleans())
def test_the_pareto_filter_agrees_with_that_of_the_table(game, dominance, collision_free):
    found = pairwise_equilibria(game, collision_free=collision_free)
    if not len(found):
        return
    dense = game.to_game()
    among = pure_equilibria(dense)
    if collision_free:
        among = among * finite_profiles(dense)
    kept = undominated(dense, among, dominance=dominance).values[tuple(found.profiles.T)]
    assert np.array_equal(found.undominated(dominance=dominance).values, kept)


@settings(max_examples=60)
@given(pairwise_games())
def test_costs_are_those_of_the_table_and_inf_only_to_who_collides(game):
    dense = game.to_game()
    everything = np.array(list(np.ndindex(game.shape)))
    paid = game.profile_costs(everything)
    assert np.array_equal(paid, dense.costs.reshape(len(game.players), -1).T)
    found = pairwise_equilibria(game)
    assert np.array_equal(found.costs, game.profile_costs(found.profiles))
    assert np.isfinite(found.costs).all()


def test_a_collision_between_two_others_costs_nothing():
    meet = np.array([[True]])
    costs = PairwiseGame([[1.0], [2.0], [3.0]], {(0, 1): meet}, ["a", "b", "c"]).to_game().costs
    assert costs.ravel().tolist() == [INF, INF, 3.0]


@given(pairwise_games())
def test_an_equilibrium_exists_wherever_some_profile_is_free_of_collisions(game):
    free = finite_profiles(game.to_game()).values > 0
    assert (len(pairwise_equilibria(game)) > 0) == free.any()


@settings(max_examples=40)
@given(pairwise_games(most_profiles=500), st.randoms(use_true_random=False))
def test_the_order_of_players_and_of_plans_permutes_the_answer_and_nothing_else(game, random):
    order = list(range(len(game.players)))
    random.shuffle(order)
    within = [random.sample(range(size), size) for size in game.shape]
    collisions = {
        (order.index(one), order.index(other)): table[np.ix_(within[one], within[other])]
        for (one, other), table in game.collisions.items()
    }
    moved = PairwiseGame(
        [game.costs[i][within[i]] for i in order], collisions, [game.players[i] for i in order]
    )
    found = pairwise_equilibria(game, collision_free=False)
    there = pairwise_equilibria(moved, collision_free=False)
    back = np.empty_like(there.profiles)
    for position, player in enumerate(order):
        back[:, player] = np.array(within[player])[there.profiles[:, position]]
    assert sorted(map(tuple, back.tolist())) == list(map(tuple, found.profiles.tolist()))


def eight_agents(seed, density=0.1):
    rng = np.random.default_rng(seed)
    pairs = {pair: rng.random((8, 8)) < density for pair in combinations(range(8), 2)}
    return PairwiseGame(rng.uniform(2.0, 15.0, (8, 8)), pairs, [f"agent{i}" for i in range(8)])


@pytest.mark.parametrize("density", [0.1, 0.3])
def test_eight_agents_of_eight_plans_each_are_all_found(density):
    game = eight_agents(0, density)
    assert game.profiles == 8**8
    found = pairwise_equilibria(game)
    # an independent count: all collision-free profiles, extended one agent at a time, then the definition itself
    tables = np.zeros((8, 8, 8, 8), bool)
    for (one, other), table in game.collisions.items():
        tables[one, other], tables[other, one] = table, table.T
    free = np.arange(8)[:, None]
    for player in range(1, 8):
        grown = np.column_stack([np.repeat(free, 8, axis=0), np.tile(np.arange(8), len(free))])
        hits = np.zeros(len(grown), bool)
        for other in range(player):
            hits |= tables[other, player][grown[:, other], grown[:, player]]
        free = grown[~hits]
    for player in range(8):
        blocked = np.zeros((len(free), 8), bool)
        for other in range(8):
            if other != player:
                blocked |= tables[other, player][free[:, other]]
        best = np.where(blocked, INF, game.costs[player]).min(axis=1)
        free = free[game.costs[player][free[:, player]] <= best]
    assert np.array_equal(found.profiles, free)
    assert len(found) > 10


def test_whoever_goes_first_in_any_order_leads_to_an_equilibrium():
    game = eight_agents(1)
    found = set(map(tuple, pairwise_equilibria(game).profiles.tolist()))
    for order in list(permutations(range(8)))[::800]:
        chosen = {}
        for player in order:
            free = np.ones(8, bool)
            for other, plan in chosen.items():
                table = game.collisions[min(player, other), max(player, other)]
                free &= ~(table[plan] if other < player else table[:, plan])
            chosen[player] = int(np.where(free, game.costs[player], INF).argmin())
        assert tuple(chosen[player] for player in range(8)) in found


def test_more_plans_than_one_machine_word_holds_make_no_difference():
    rng = np.random.default_rng(2)
    pairs = {pair: rng.random((40, 40)) < 0.4 for pair in combinations(range(3), 2)}
    game = PairwiseGame(rng.integers(0, 30, (3, 40)).astype(float), pairs, ["a", "b", "c"])
    dense = game.to_game()
    found = pairwise_equilibria(game)
    assert np.array_equal(mask_of(found), (pure_equilibria(dense) * finite_profiles(dense)).values > 0)
    assert len(found) == 10


def test_the_equilibria_label_one_sparse_axis_on_which_the_algebra_runs():
    game = eight_agents(3)
    found = pairwise_equilibria(game)
    assert found.axis.name == "profile"
    assert len(found.axis) == len(found)
    assert np.array_equal(found.axis.label_array(), np.ravel_multi_index(tuple(found.profiles.T), game.shape))
    norm = found.factor(-50.0 * found.costs.min(axis=1)).normalize("profile")
    p = (norm * found.undominated()).normalize("profile")
    plan = (p * found.plan_of("agent2")).marginal("agent2_plan")
    by_hand = np.bincount(found.profiles[:, 2], weights=p.values, minlength=8)
    np.testing.assert_allclose(plan.values, by_hand, atol=1e-12)
    assert np.array_equal(found.factor().values, np.ones(len(found)))
    # equilibria of different games do not line up by accident
    other = pairwise_equilibria(eight_agents(4))
    with pytest.raises(AxisError):
        norm * Factor([other.axis], np.zeros(len(other)))


def test_games_with_more_profiles_than_64_bits_count_have_labels_all_the_same():
    game = PairwiseGame(
        np.tile(np.arange(10.0), (25, 1)), {(3, 20): np.eye(10, dtype=bool)}, [f"a{i}" for i in range(25)]
    )
    found = pairwise_equilibria(game)
    assert found.profiles.sum(axis=1).tolist() == [1, 1]
    assert list(found.axis.labels) == [10**4, 10**21]


def test_where_everybody_collides_there_is_nothing_to_coordinate_on():
    game = PairwiseGame(
        np.ones((3, 4)), {p: np.ones((4, 4), bool) for p in combinations(range(3), 2)}, ["a", "b", "c"]
    )
    found = pairwise_equilibria(game)
    assert len(found) == 0
    assert found.profiles.shape == (0, 3)
    with pytest.raises(GameError, match="no collision-free equilibrium"):
        found.factor()
    assert "0 collision-free equilibria" in repr(found)
    assert "<table>" in found._repr_html_()
    assert len(pairwise_equilibria(game, collision_free=False)) == 4**3


def test_too_many_equilibria_are_refused_before_they_fill_the_memory():
    game = PairwiseGame(np.ones((12, 12)), {}, [f"a{i}" for i in range(12)])
    with pytest.raises(GameError, match=r"more than 1000 collision-free equilibria among 8.92e\+12"):
        pairwise_equilibria(game, limit=1000)
    with pytest.raises(GameError, match="at least 1; got 0"):
        pairwise_equilibria(game, limit=0)
    with pytest.raises(GameError, match="GB; pairwise_equilibria works without it"):
        game.to_game()


def test_a_game_survives_pickling_and_cannot_be_written_to():
    game = eight_agents(5)
    again = pickle.loads(pickle.dumps(game))
    assert np.array_equal(pairwise_equilibria(again).profiles, pairwise_equilibria(game).profiles)
    for array in (game.costs[0], game.collisions[0, 1], pairwise_equilibria(game).profiles):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


TABLE = [[True, False], [False, False]]


@pytest.mark.parametrize(
    ("costs", "collisions", "names", "message"),
    [
        ([[1.0, 2.0]], {}, ["a", "b"], r"2 players \(a, b\) and costs for 1"),
        ([[1.0], []], {}, ["a", "b"], r"the costs of b's plans .* got shape \(0,\)"),
        ([[1.0], ["x"]], {}, ["a", "b"], "b's plans must be real numbers"),
        ([[1.0], [2.0, np.nan]], {}, ["a", "b"], "the cost is nan at b_plan=1"),
        ([[1.0, 2.0]] * 2, {("a", "c"): TABLE}, ["a", "b"], "no player 'c'; there are a, b"),
        ([[1.0, 2.0]] * 2, {(0, 2): TABLE}, ["a", "b"], "no player 2; there are a, b"),
        ([[1.0, 2.0]] * 2, {(0, 0): TABLE}, ["a", "b"], "collisions of a with itself"),
        ([[1.0, 2.0]] * 2, {"ab": TABLE}, ["a", "b"], "pairs of players, not for 'ab'"),
        ([[1.0, 2.0]] * 2, {(0, 1): [[1, 0], [0, 0]]}, ["a", "b"], r"bool of shape \(2, 2\); got int64"),
        (
            [[1.0, 2.0]] * 2,
            {(0, 1): TABLE, (1, 0): [[False] * 2] * 2},
            ["a", "b"],
            "differ at a_plan=0, b_plan=0",
        ),
        ([[1.0, 2.0]] * 2, {}, ["a", "a"], "two players are called 'a'"),
    ],
)
def test_what_does_not_fit_is_refused_saying_where(costs, collisions, names, message):
    with pytest.raises(GameError, match=message):
        PairwiseGame(costs, collisions, names)


def test_plan_axes_and_profiles_that_do_not_fit_are_refused():
    with pytest.raises(GameError, match=r"plan axes have \(3,\) labels"):
        PairwiseGame([[1.0, 2.0]], {}, ["a"], [Axis("a_plan", 3)])
    with pytest.raises(AxisError, match="two axes of the game are called 'plan'"):
        PairwiseGame([[1.0], [2.0]], {}, ["a", "b"], [Axis("plan", 1), Axis("plan", 1)])
    game = PairwiseGame([[1.0], [2.0, 3.0]], {}, ["a", "b"])
    with pytest.raises(GameError, match="profile 1 has plan 2 of b, who has 2"):
        game.profile_costs([[0, 0], [0, 2]])
    with pytest.raises(GameError, match=r"shape \(profile, 2\)"):
        game.profile_costs([0, 0])
    with pytest.raises(GameError, match="no player 'c'"):
        pairwise_equilibria(game).plan_of("c")
    with pytest.raises(GameError, match="'weak' or 'strict'"):
        pairwise_equilibria(game).undominated(dominance="paper")
