"""A certificate says whether a game has a potential, and both answers can be checked by hand."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ppinfer import Axis
from ppinfer.errors import GameError
from ppinfer.games import Game, finite_profiles, potential, pure_equilibria
from ppinfer.testing import games

INF = np.inf
PRISONERS = Game([[[1.0, 10.0], [0.0, 9.0]], [[1.0, 0.0], [10.0, 9.0]]], ["a", "b"])
PENNIES = Game([[[0.0, 1.0], [1.0, 0.0]], [[1.0, 0.0], [0.0, 1.0]]], ["even", "odd"])


def mover(profile, other):
    """Return the one player whose plan differs."""
    moved = [player for player, (a, b) in enumerate(zip(profile, other, strict=True)) if a != b]
    assert len(moved) == 1
    return moved[0]


def change(game, profile, other):
    player = mover(profile, other)
    return game.costs[player][other] - game.costs[player][profile]


def deviations(game):
    """Yield every pair of profiles that exist and differ in one player's plan."""
    shape = game.costs.shape[1:]
    for profile in np.ndindex(shape):
        for player, plans in enumerate(shape):
            for plan in range(plans):
                other = (*profile[:player], plan, *profile[player + 1 :])
                exist = game.present is None or (game.present[profile] and game.present[other])
                if other != profile and exist:
                    yield player, profile, other


def check_certificate(game, certificate):
    """Check what a certificate claims, whichever it is."""
    if certificate.kind == "exact":
        assert certificate.discrepancy == ()
        values = certificate.values
        finite = finite_profiles(game).values == 1.0
        exists = np.ones(values.shape, bool) if game.present is None else game.present
        assert np.array_equal(np.isfinite(values), finite)
        assert np.array_equal(np.isnan(values), ~exists)
        scale = np.abs(game.costs[:, finite]).max(initial=0.0)
        for player, profile, other in deviations(game):
            if finite[profile] and finite[other]:
                moved = game.costs[player][other] - game.costs[player][profile]
                assert abs(values[other] - values[profile] - moved) <= 1e-9 * scale
        return
    check_discrepancy(game, certificate)
    if certificate.kind == "ordinal":
        for player, profile, other in deviations(game):
            if game.costs[player][other] < game.costs[player][profile]:
                assert certificate.values[other] < certificate.values[profile]
        rest = certificate.values == 0.0
        assert np.array_equal(rest, pure_equilibria(game).values == 1.0)
        return
    assert certificate.kind == "none"
    assert not certificate.improvements_end
    cycle = certificate.improvement_cycle
    assert len(set(cycle)) == len(cycle) >= 3
    for profile, other in pairwise([*cycle, cycle[0]]):
        player = mover(profile, other)
        assert game.costs[player][other] < game.costs[player][profile]
        assert game.present is None or game.present[profile]


def check_discrepancy(game, certificate):
    path = certificate.discrepancy
    if len(path) == 1:
        infinite = np.isinf(game.costs[(slice(None), *path[0])])
        assert infinite.any()
        assert not infinite.all()
        return
    total = sum(change(game, profile, other) for profile, other in pairwise([*path, path[0]]))
    assert abs(total) == pytest.approx(certificate.defect, rel=1e-6, abs=1e-300)
    assert total != 0.0


def random_games(seed, count, players):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        sizes = rng.integers(1, 4, players)
        costs = rng.integers(0, 4, (players, *sizes)).astype(float)
        if rng.random() < 0.5:
            costs[:, rng.random(sizes) < 0.3] = INF
        elif rng.random() < 0.5:
            costs[rng.random(costs.shape) < 0.2] = INF
        present = rng.random(sizes) < 0.8 if rng.random() < 0.3 else None
        yield Game(costs, list("abc")[:players], present=present)


@pytest.mark.parametrize("players", [1, 2, 3])
def test_whatever_is_certified_of_random_games_holds(players):
    kinds = set()
    for game in random_games(players, 400, players):
        certificate = potential(game)
        check_certificate(game, certificate)
        kinds.add(certificate.kind)
    assert kinds == ({"exact"} if players == 1 else {"exact", "ordinal", "none"})


@given(games(max_batch=0))
def test_whatever_is_certified_of_awkward_games_holds(game):
    certificate = potential(game)
    if certificate.kind != "exact":
        return
    assert certificate.improvements_end
    assert np.array_equal(np.isfinite(certificate.values), finite_profiles(game).values == 1.0)


@st.composite
def plans_that_collide(draw, players=None):
    """Draw what plans take and which profiles collide: durations depend on the own plan only, collisions are joint."""
    players = draw(st.integers(2, 3)) if players is None else players
    sizes = [draw(st.integers(1, 5)) for _ in range(players)]
    durations = [draw(arrays(np.float64, size, elements=st.floats(0.1, 60.0))) for size in sizes]
    return durations, draw(arrays(np.bool_, sizes))


def game_of(durations, collide):
    costs = np.stack(np.broadcast_arrays(*np.ix_(*durations)))
    costs[:, collide] = INF
    return Game(costs, ["robot", "human", "guest"][: len(durations)])


@given(plans_that_collide())
def test_wherever_a_profile_is_free_of_collisions_the_free_one_of_least_summed_duration_is_an_equilibrium(
    drawn,
):
    durations, collide = drawn
    game = game_of(durations, collide)
    free = finite_profiles(game).values == 1.0
    assert np.array_equal(free, ~collide)
    if free.any():
        total = np.where(free, game.costs.sum(axis=0), INF)
        best = np.unravel_index(np.argmin(total), total.shape)
        assert pure_equilibria(game).values[best] == 1.0


@given(plans_that_collide())
def test_collisions_that_are_joint_make_a_potential_game_whose_potential_is_the_summed_duration(drawn):
    durations, collide = drawn
    certificate = potential(game_of(durations, collide))
    assert certificate.kind == "exact"
    assert certificate.improvements_end
    if not collide.any():
        total = np.stack(np.broadcast_arrays(*np.ix_(*durations))).sum(axis=0)
        assert np.allclose(certificate.values, total - total.min(), atol=1e-9)


def test_the_prisoners_have_an_exact_potential():
    certificate = potential(PRISONERS)
    assert certificate.kind == "exact"
    assert certificate.values.tolist() == [[2.0, 1.0], [1.0, 0.0]]
    assert certificate.defect == 0.0
    with pytest.raises(ValueError, match="read-only"):
        certificate.values[0, 0] = 1.0


def test_matching_pennies_go_round_in_a_circle():
    certificate = potential(PENNIES)
    assert certificate.kind == "none"
    assert certificate.values is None
    assert len(certificate.improvement_cycle) == 4
    assert len(certificate.discrepancy) == 4
    assert certificate.defect == 4.0
    check_certificate(PENNIES, certificate)


def test_a_game_without_an_exact_potential_may_still_come_to_rest():
    battle = Game([[[1.0, 3.0], [3.0, 2.0]], [[2.0, 3.0], [3.0, 0.5]]], ["a", "b"])
    certificate = potential(battle)
    assert certificate.kind == "ordinal"
    assert certificate.improvements_end
    assert certificate.values.tolist() == [[0.0, 1.0], [1.0, 0.0]]
    check_certificate(battle, certificate)


def test_a_cost_that_is_infinite_for_one_player_only_leaves_no_exact_potential():
    certificate = potential(Game([[[1.0, INF]], [[1.0, 1.0]]], ["a", "b"]))
    assert certificate.kind == "ordinal"
    assert certificate.discrepancy == ((0, 1),)
    assert certificate.defect == INF


def test_going_from_an_infinite_cost_to_a_finite_one_is_an_improvement_and_between_infinite_ones_is_none():
    game = Game([[INF, INF, 5.0]], ["a"])
    assert potential(game).kind == "exact"
    assert potential(game).values.tolist() == [INF, INF, 0.0]
    chase = Game(
        [[[INF, 1.0], [1.0, INF]], [[1.0, INF], [INF, 1.0]]],
        ["a", "b"],
    )
    certificate = potential(chase)
    assert certificate.kind == "none"
    check_certificate(chase, certificate)


def test_parts_of_the_grid_that_no_deviation_connects_have_potentials_of_their_own():
    costs = np.array([[[3.0, INF], [INF, 7.0]], [[4.0, INF], [INF, 1.0]]])
    assert potential(Game(costs, ["a", "b"])).values.tolist() == [[0.0, INF], [INF, 0.0]]


def test_a_discrepancy_may_need_more_than_four_deviations_where_profiles_collide():
    collide = ~np.array([[True, True, False], [False, True, True], [True, False, True]])
    costs = np.random.default_rng(0).integers(0, 9, (2, 3, 3)).astype(float)
    costs[:, collide] = INF
    game = Game(costs, ["a", "b"])
    certificate = potential(game)
    assert len(certificate.discrepancy) == 6
    check_certificate(game, certificate)


def test_rounding_is_no_discrepancy():
    rng = np.random.default_rng(1)
    common, own = rng.random((6, 7)), [rng.random((1, 7)), rng.random((6, 1))]
    certificate = potential(Game([common + own[0], common + own[1]], ["a", "b"]))
    assert certificate.kind == "exact"
    assert 0.0 < certificate.defect < 1e-14


def test_one_game_at_a_time():
    with pytest.raises(GameError, match=r"batch axes \(trial\); restrict\(trial=...\)"):
        potential(Game(np.zeros((3, 2, 2, 2)), ["a", "b"], batch=[Axis("trial", 3)]))
