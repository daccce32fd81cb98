"""Norms against their formulas, and mixtures against what made the choices."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ppinfer.coordination import (
    Egalitarian,
    MinNorm,
    MixtureNorm,
    RiskDominant,
    UniformNorm,
    Utilitarian,
    coordination_equilibria,
)
from ppinfer.distributions import Axis, Factor
from ppinfer.errors import ImpossibleEvidenceError, ModelError
from ppinfer.games import Game, pure_equilibria
from ppinfer.testing import example_situation

PLAYERS = ["robot", "human"]


def exactly(weights):
    """Normalise weights with Python's exact sums."""
    total = math.fsum(weights.values())
    return {profile: weight / total for profile, weight in weights.items()}


@pytest.mark.parametrize(
    ("norm", "of"),
    [
        (MinNorm(rationality=3.0), lambda costs: math.exp(-3.0 * min(costs))),
        (MinNorm(rationality=50.0, cost_unit=50.0), lambda costs: math.exp(-min(costs))),
        (Utilitarian(rationality=0.7), lambda costs: math.exp(-0.7 * sum(costs))),
        (Egalitarian(rationality=0.7), lambda costs: math.exp(-0.7 * max(costs))),
        (UniformNorm(), lambda costs: 1.0),
        (MinNorm(rationality=0.0), lambda costs: 1.0),
    ],
)
@pytest.mark.parametrize("seed", range(5))
def test_a_norm_is_its_formula(norm, of, seed):
    game = example_situation(np.random.default_rng(seed), plans=(5, 4), colliding=0.6).game
    among = coordination_equilibria(game)
    cells = [tuple(cell) for cell in np.argwhere(among.values).tolist()]
    expected = exactly({cell: of(game.costs[(slice(None), *cell)].tolist()) for cell in cells})
    p = norm.probabilities(game, among).values
    assert p.sum() == pytest.approx(1.0, abs=1e-12)
    for cell in cells:
        assert p[cell] == pytest.approx(expected[cell], rel=1e-9, abs=1e-15)


def test_costs_of_a_million_seconds_do_not_underflow():
    game = Game([[[1e6, 1e6 + 0.01]], [[1e7, 1e7]]], PLAYERS)
    p = MinNorm().probabilities(game, Factor.from_mask(game.axes, np.ones((1, 2), bool)))
    assert p.values[0, 0] == pytest.approx(1 / (1 + math.exp(-0.5)), rel=1e-6)


def test_a_profile_that_costs_everybody_infinitely_much_is_impossible_among_others_and_refused_alone():
    game = Game([[[np.inf, 1.0]], [[np.inf, 1.0]]], PLAYERS)
    everything = Factor.from_mask(game.axes, np.ones((1, 2), bool))
    for norm in (MinNorm(), Utilitarian(), Egalitarian()):
        assert norm.probabilities(game, everything).values.tolist() == [[0.0, 1.0]]
        with pytest.raises(ImpossibleEvidenceError):
            norm.probabilities(game, Factor.from_mask(game.axes, np.array([[True, False]])))


def test_risk_dominance_is_the_product_of_deviation_losses_in_a_two_by_two_game():
    # losses at (0, 0): 4 and 2; at (1, 1): 1 and 3
    game = Game([[[0.0, 3.0], [4.0, 2.0]], [[0.0, 2.0], [5.0, 2.0]]], PLAYERS)
    p = RiskDominant(rationality=1.0).probabilities(game, pure_equilibria(game)).values
    assert p[0, 0] > p[1, 1]
    assert p[0, 0] == pytest.approx(math.e / (1 + math.e), abs=1e-12)


def test_risk_dominance_counts_pairs_won_and_halves_of_draws():
    # the diagonal is free, all else collides: every deviation loses the same
    costs = np.full((2, 3, 3), np.inf)
    costs[:, range(3), range(3)] = 5.0
    game = Game(costs, PLAYERS)
    p = RiskDominant().probabilities(
        game, pure_equilibria(game) * Factor.from_mask(game.axes, np.eye(3, dtype=bool))
    )
    np.testing.assert_allclose(np.diag(p.values), 1 / 3)


def test_the_weights_of_a_mixture_are_recovered_from_choices():
    rng = np.random.default_rng(0)
    games = [example_situation(rng, plans=(5, 5), colliding=0.7).game for _ in range(300)]
    batch = Game(np.stack([game.costs for game in games]), PLAYERS, games[0].plans, [Axis("trial", 300)])
    among = coordination_equilibria(batch)
    norms = [MinNorm(), Egalitarian(rationality=5.0), UniformNorm()]
    truth = MixtureNorm(norms, [0.5, 0.3, 0.2])
    drawn = truth.probabilities(batch, among).sample(rng)
    chosen = np.stack([drawn["robot_plan"], drawn["human_plan"]], axis=1)
    found = MixtureNorm.fit(norms, batch, among, chosen)
    np.testing.assert_allclose(found.weights, truth.weights, atol=0.12)
    cell = (np.arange(300), *chosen.T)

    def log_likelihood(weights):
        return MixtureNorm(norms, weights).probabilities(batch, among).log_values[cell].sum()

    best = log_likelihood(found.weights)
    for change in ((0.02, -0.02, 0.0), (-0.02, 0.0, 0.02), (0.0, 0.02, -0.02)):
        assert log_likelihood(np.add(found.weights, change).tolist()) < best
    assert found.of_whom().prob(norm="min") == pytest.approx(found.weights[0])


def test_a_choice_that_no_norm_allows_is_named():
    game = Game([[[[1.0, 9.0]], [[1.0, 9.0]]]], PLAYERS, batch=[Axis("trial", 1)])
    among = coordination_equilibria(game)
    with pytest.raises(ImpossibleEvidenceError, match=r"choice 0 .*\(0, 1\)"):
        MixtureNorm.fit([MinNorm()], game, among, [[0, 1]])


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: MinNorm(rationality=-1.0),
        lambda: MinNorm(rationality=math.nan),
        lambda: MinNorm(cost_unit=0.0),
        lambda: RiskDominant(collision_loss=math.inf),
        lambda: MixtureNorm([MinNorm()], [0.5]),
        lambda: MixtureNorm([], []),
        lambda: MixtureNorm([MinNorm(), UniformNorm()], [1.5, -0.5]),
    ],
)
def test_parameters_out_of_range_are_refused(wrong):
    with pytest.raises(ModelError):
        wrong()
