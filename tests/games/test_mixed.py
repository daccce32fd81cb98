"""Mixed equilibria: all of them against exact arithmetic, none added, each with its certificate."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppinfer.distributions import Axis
from ppinfer.errors import GameError
from ppinfer.games import Game, mixed_equilibria, pure_equilibria

PLAYERS = ["robot", "human"]


def solve_exactly(matrix):
    """Solve a square system, its right-hand side in the last column, in fractions; None if it is singular."""
    rows = [[Fraction(int(value)) for value in row] for row in matrix]
    for column in range(len(rows)):
        pivot = next((row for row in range(column, len(rows)) if rows[row][column]), None)
        if pivot is None:
            return None
        rows[column], rows[pivot] = rows[pivot], rows[column]
        rows[column] = [value / rows[column][column] for value in rows[column]]
        for other in range(len(rows)):
            if other != column and rows[other][column]:
                factor = rows[other][column]
                rows[other] = [a - factor * b for a, b in zip(rows[other], rows[column], strict=True)]
    return [row[-1] for row in rows]


def mixture_making_indifferent(costs, replies, support):
    """Return the mixture on a support against which all of `replies` cost the same, and that cost."""
    size = len(support)
    system = [[*(costs[reply][plan] for plan in support), -1, 0] for reply in replies]
    return solve_exactly([*system, [*([1] * size), 0, 1]])


def support_enumeration(costs):
    """Return all equilibria of a nondegenerate game of integer costs, in fractions; None if it is degenerate."""
    mine, yours = costs[0].tolist(), costs[1].T.tolist()
    found = []
    for size in range(1, min(costs.shape[1:]) + 1):
        for rows in combinations(range(costs.shape[1]), size):
            for columns in combinations(range(costs.shape[2]), size):
                y = mixture_making_indifferent(mine, rows, columns)
                x = mixture_making_indifferent(yours, columns, rows)
                if x is None or y is None:
                    if size == 1:
                        raise AssertionError
                    return None
                if min(x[:-1]) < 0 or min(y[:-1]) < 0:
                    continue
                if min(x[:-1]) == 0 or min(y[:-1]) == 0:
                    return None
                mixed = []
                for table, weights, support, played in ((mine, y, columns, rows), (yours, x, rows, columns)):
                    slack = [
                        sum(w * table[reply][plan] for w, plan in zip(weights, support, strict=False))
                        - weights[-1]
                        for reply in range(len(table))
                        if reply not in played
                    ]
                    mixed.append(min(slack, default=1))
                if min(mixed) == 0:
                    return None
                if min(mixed) > 0:
                    p, q = np.zeros(costs.shape[1]), np.zeros(costs.shape[2])
                    p[list(rows)], q[list(columns)] = x[:-1], y[:-1]
                    found.append(np.append(p, q))
    return np.array(sorted(found, key=tuple))


def both(found):
    """Return the equilibria as rows of probabilities, both players' side by side, sorted."""
    rows = np.hstack([strategy.values for strategy in found.strategies])
    return np.array(sorted(rows, key=lambda row: tuple(row.round(9))))


def test_all_equilibria_of_nondegenerate_games_are_found_and_none_is_added():
    rng = np.random.default_rng(0)
    compared = with_mixed = 0
    for trial in range(260):
        shape = rng.integers(2, 4, 2) if trial < 245 else (4, 4)
        costs = rng.integers(0, 1000, (2, *shape))
        expected = support_enumeration(costs)
        if expected is None:
            continue
        found = mixed_equilibria(Game(costs, PLAYERS))
        assert not found.degenerate
        assert not found.rejected
        assert len(found) == len(expected)
        assert len(found) % 2 == 1
        np.testing.assert_allclose(
            both(found), np.array(sorted(expected, key=lambda row: tuple(row.round(9)))), atol=1e-10
        )
        compared += 1
        with_mixed += len(expected) > 1
    assert compared > 240
    assert with_mixed > 30


@given(st.integers(0, 10_000), st.integers(1, 5), st.integers(1, 5))
def test_pure_equilibria_are_among_them_and_ties_are_no_obstacle(seed, m, n):
    costs = np.random.default_rng(seed).integers(0, 4, (2, m, n)).astype(float)
    game = Game(costs, PLAYERS)
    found = mixed_equilibria(game)
    pure = np.zeros((m, n), bool)
    for p, q in zip(*(strategy.values for strategy in found.strategies), strict=True):
        if p.max() > 1 - 1e-9 and q.max() > 1 - 1e-9:
            pure[p.argmax(), q.argmax()] = True
    assert np.array_equal(pure, pure_equilibria(game).values > 0)


@given(st.integers(0, 10_000), st.integers(1, 5), st.integers(1, 5), st.sampled_from([1e-6, 1.0, 1e6]))
def test_each_carries_its_regret_whatever_the_unit(seed, m, n, unit):
    rng = np.random.default_rng(seed)
    costs = unit * (rng.integers(0, 6, (2, m, n)) if seed % 2 else rng.normal(size=(2, m, n)))
    found = mixed_equilibria(Game(costs, PLAYERS))
    x, y = (strategy.values for strategy in found.strategies)
    joint = x[:, :, None] * y[:, None, :]
    paid = np.einsum("emn,pmn->ep", joint, costs)
    best = np.column_stack([(y @ costs[0].T).min(axis=1), (x @ costs[1]).min(axis=1)])
    np.testing.assert_allclose(found.costs, paid, atol=1e-12 * unit)
    np.testing.assert_allclose(found.regret, paid - best, atol=1e-12 * unit)
    assert (found.regret <= 1e-9 * np.ptp(costs, axis=(1, 2)) + 1e-300).all()
    np.testing.assert_allclose(found.profile.values, joint, atol=1e-15)
    np.testing.assert_allclose(found.profile.marginal("robot_plan").values, x, atol=1e-12)


@given(st.integers(0, 10_000), st.integers(2, 4), st.integers(2, 4))
def test_relabelling_the_plans_permutes_the_equilibria_and_nothing_else(seed, m, n):
    rng = np.random.default_rng(seed)
    costs = rng.normal(size=(2, m, n))
    rows, columns = rng.permutation(m), rng.permutation(n)
    plain = mixed_equilibria(Game(costs, PLAYERS))
    moved = mixed_equilibria(Game(costs[:, rows][:, :, columns], PLAYERS))
    x, y = (strategy.values for strategy in plain.strategies)
    expected = np.hstack([x[:, rows], y[:, columns]])
    np.testing.assert_allclose(
        both(moved), np.array(sorted(expected, key=lambda row: tuple(row.round(9)))), atol=1e-9
    )


def test_a_degenerate_game_gives_the_extreme_equilibria_and_says_so():
    # the human is indifferent throughout; the robot goes along with whatever is more probable
    game = Game([[[0.0, 1.0], [1.0, 0.0]], [[3.0, 3.0], [3.0, 3.0]]], PLAYERS)
    found = mixed_equilibria(game)
    assert found.degenerate
    assert both(found).round(9).tolist() == [[0, 1, 0, 1], [0, 1, 0.5, 0.5], [1, 0, 0.5, 0.5], [1, 0, 1, 0]]
    assert "degenerate" in repr(found)
    constant = mixed_equilibria(Game(np.full((2, 3, 2), 7.0), PLAYERS))
    assert constant.degenerate
    assert len(constant) == 6


def test_near_ties_are_told_apart_from_ties():
    # nearer than nashpy's own tolerance for what is a best reply
    costs = np.array([[[0.0, 1.0], [1e-6, 1.0 - 1e-6]], [[0.0, 1.0], [1.0, 0.0]]])
    found = mixed_equilibria(Game(costs, PLAYERS))
    assert not found.degenerate
    assert both(found).round(6).tolist() == [[0, 1, 0, 1], [0.5, 0.5, 0.5, 0.5], [1, 0, 1, 0]]


def test_an_infinite_cost_is_refused_by_its_cell_or_counts_as_what_is_said():
    costs = np.array([[[np.inf, 1.0], [2.0, 2.0]], [[np.inf, 2.0], [1.0, 2.0]]])
    game = Game(costs, PLAYERS)
    with pytest.raises(GameError, match=r"inf at player='robot', robot_plan=0, human_plan=0.*infinite_as="):
        mixed_equilibria(game)
    found = mixed_equilibria(game, infinite_as=5.0)
    assert np.array_equal(
        both(found), both(mixed_equilibria(Game(np.where(np.isinf(costs), 5.0, costs), PLAYERS)))
    )
    for wrong in (1.5, np.inf, np.nan):
        with pytest.raises(GameError, match=r"at least the largest finite cost, 2\.0"):
            mixed_equilibria(game, infinite_as=wrong)


def test_plans_that_are_absent_are_never_played():
    rng = np.random.default_rng(3)
    costs = rng.normal(size=(2, 3, 3))
    there = np.outer([True, False, True], [True, True, False])
    found = mixed_equilibria(Game(costs, PLAYERS, present=there))
    small = mixed_equilibria(Game(costs[:, [0, 2]][:, :, :2], PLAYERS))
    assert len(found) == len(small)
    np.testing.assert_allclose(found.profile.values[:, [0, 2]][:, :, :2], small.profile.values)
    assert not found.profile.values[:, 1].any()
    assert not found.profile.values[:, :, 2].any()
    there[0, 0] = False
    with pytest.raises(GameError, match="robot_plan=0, human_plan=0 is absent"):
        mixed_equilibria(Game(costs, PLAYERS, present=there))
    with pytest.raises(GameError, match="no profile present"):
        mixed_equilibria(Game(costs, PLAYERS, present=np.zeros((3, 3), bool)))


def test_what_has_no_answer_is_refused_with_what_to_do():
    with pytest.raises(GameError, match=r"this game has 3 .*logit_response"):
        mixed_equilibria(Game(np.zeros((3, 2, 2, 2)), ["a", "b", "c"]))
    with pytest.raises(GameError, match=r"restrict\(trial="):
        mixed_equilibria(Game(np.zeros((4, 2, 2, 2)), PLAYERS, batch=[Axis("trial", 4)]))
    with pytest.raises(GameError, match="0 <= tolerance < 1; got -1"):
        mixed_equilibria(Game(np.zeros((2, 2, 2)), PLAYERS), tolerance=-1.0)
    # a mixture of thirds has no exact digits
    with pytest.raises(GameError, match=r"none of 1 candidates .* raise tolerance"):
        mixed_equilibria(Game([[[0.0, 0.3], [0.1, 0.0]], [[0.3, 0.0], [0.0, 0.7]]], PLAYERS), tolerance=0.0)
