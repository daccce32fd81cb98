"""Among which equilibria agents coordinate."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given, settings

from ppinfer.coordination import coordination_equilibria
from ppinfer.distributions import Axis
from ppinfer.games import Game
from ppinfer.testing import example_situation, situations


def by_definition(costs, strict):
    """Find them profile by profile."""
    sizes = costs.shape[1:]
    free = []
    for profile in itertools.product(*map(range, sizes)):
        own = [costs[(player, *profile)] for player in range(len(sizes))]
        replies = [
            min(costs[(player, *profile[:player], plan, *profile[player + 1 :])] for plan in range(size))
            for player, size in enumerate(sizes)
        ]
        if all(np.isfinite(own)) and all(mine <= best for mine, best in zip(own, replies, strict=True)):
            free.append((profile, own))

    def dominates(one, other):
        if strict:
            return all(x < y for x, y in zip(one, other, strict=True))
        return all(x <= y for x, y in zip(one, other, strict=True)) and one != other

    return {profile for profile, own in free if not any(dominates(other, own) for _, other in free)}


@settings(max_examples=30)
@given(situations())
def test_they_are_what_the_definition_says_profile_by_profile(situation):
    for dominance in ("weak", "strict"):
        found = coordination_equilibria(situation.game, dominance).values
        cells = {tuple(cell) for cell in np.argwhere(found).tolist()}
        assert cells == by_definition(situation.game.costs, dominance == "strict")


@settings(max_examples=40)
@given(situations())
def test_wherever_some_profile_is_free_of_collisions_there_is_one(situation):
    free = np.isfinite(situation.game.costs).all(axis=0)
    assert coordination_equilibria(situation.game).values.any() == free.any()


@settings(max_examples=40)
@given(situations())
def test_the_free_profile_with_the_least_summed_duration_is_an_equilibrium(situation):
    total = situation.game.costs.sum(axis=0)
    if not np.isfinite(total.min()):
        return
    found = coordination_equilibria(situation.game, "strict").values
    best = total <= total.min()
    # with less in sum, it is not dominated by anything either; sums that tie do so up to rounding
    assert (found[best] == 1.0).any()


def test_many_games_at_once_give_what_each_gives_alone():
    games = [example_situation(np.random.default_rng(seed), plans=(4, 3)).game for seed in range(20)]
    together = Game(
        np.stack([game.costs for game in games]), games[0].players, games[0].plans, [Axis("trial", 20)]
    )
    alone = np.stack([coordination_equilibria(game).values for game in games])
    np.testing.assert_array_equal(coordination_equilibria(together).values, alone)
