import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer.coordination import PlanPrediction, PlanSet, Situation
from ppinfer.coordination.scans import plan_frequencies
from ppinfer.errors import ModelError


def plan_set(agent, durations):
    """Return plans of one joint with these durations, and the static one last."""
    sizes = [2] * len(durations) + [1]
    time = [moment for duration in durations for moment in (0.0, duration)] + [0.0]
    position = [[where] for duration in durations for where in (0.0, duration)] + [[0.0]]
    return PlanSet(agent, sizes, time, position, static=len(durations))


def random_situation(seed, own=6, other=5, density=0.3):
    rng = np.random.default_rng(seed)
    plans = [
        plan_set("robot", np.round(rng.uniform(1, 9, own), 1)),
        plan_set("human", np.round(rng.uniform(1, 9, other), 1)),
    ]
    contact = np.where(
        rng.random((own + 1, other + 1)) < density, rng.uniform(0.1, 8, (own + 1, other + 1)), np.inf
    )
    contact[-1, -1] = np.inf
    return Situation.from_contacts(plans, contact, seed=seed)


def played_by_hand(own_cost, other_cost, own, other, rationality, hold):
    """Return the frequencies of one sub-game, by the definitions."""
    cells = [(i, j) for i in own for j in other]
    equilibria = [
        (i, j)
        for i, j in cells
        if math.isfinite(own_cost[i, j])
        and math.isfinite(other_cost[i, j])
        and own_cost[i, j] == min(own_cost[k, j] for k in own)
        and other_cost[i, j] == min(other_cost[i, k] for k in other)
    ]
    kept = [
        a
        for a in equilibria
        if not any(
            own_cost[b] <= own_cost[a]
            and other_cost[b] <= other_cost[a]
            and (own_cost[b], other_cost[b]) != (own_cost[a], other_cost[a])
            for b in equilibria
        )
    ]
    played = np.zeros((2, own_cost.shape[1]))
    if not kept:
        played[:, hold] = 1.0
        return played
    for theta in range(2):
        favoured = [
            a for a in kept if (own_cost[a] <= other_cost[a], other_cost[a] <= own_cost[a])[theta]
        ] or kept
        least = min(min(own_cost[a], other_cost[a]) for a in favoured)
        weights = [math.exp(-rationality * (min(own_cost[a], other_cost[a]) - least)) for a in favoured]
        for (_, j), weight in zip(favoured, weights, strict=True):
            played[theta, j] += weight / sum(weights)
    return played


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 2**32), st.floats(0.0, 0.9), st.sampled_from([0.0, 0.7, 50.0]))
def test_frequencies_are_those_of_the_sub_games_played_by_hand(seed, density, rationality):
    rng = np.random.default_rng(seed)
    m, n = rng.integers(1, 7, 2)
    collides = rng.random((m, n)) < density
    # whole seconds, so that ties happen
    own = np.where(collides, np.inf, rng.integers(1, 5, (m, 1)).astype(float))
    other = np.where(collides, np.inf, rng.integers(1, 5, (1, n)).astype(float))
    drawn_own = np.array([rng.permutation(m)[: max(1, m - 1)] for _ in range(5)])
    drawn_other = np.array([rng.permutation(n)[: max(1, n - 1)] for _ in range(5)])
    for costs in (own, other):
        costs.setflags(write=False)  # as those of a game are
    frequencies = plan_frequencies(own, other, drawn_own, drawn_other, rationality, n - 1)
    by_hand = np.mean(
        [
            played_by_hand(own, other, a, b, rationality, n - 1)
            for a, b in zip(drawn_own, drawn_other, strict=True)
        ],
        axis=0,
    )
    np.testing.assert_allclose(frequencies, by_hand, atol=1e-12)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32), st.sampled_from(["robot", "human"]))
def test_the_prediction_is_a_distribution_over_the_other_agents_plans_for_each_theta(seed, ego):
    situation = random_situation(seed)
    predictive = PlanPrediction(games=6, plans=3).predict(situation, ego)
    other = "human" if ego == "robot" else "robot"
    assert predictive.random == (f"{other}_plan",)
    assert predictive.conditions == ("theta",)
    assert predictive.axis("theta").labels == ("robot", "human")
    np.testing.assert_allclose(predictive.values.sum(axis=1), 1.0, atol=1e-12)


def test_the_prediction_is_the_same_for_either_agent_with_the_roles_exchanged():
    situation = random_situation(4, own=5, other=5)
    turned = Situation.from_contacts(situation.plans[::-1], situation.contact_time.T, seed=4)
    # all plans are in every sub-game: nothing is left to chance
    everything = PlanPrediction(games=2, plans=5)
    one = everything.predict(situation, "robot").values
    two = everything.predict(turned, "robot").values
    np.testing.assert_allclose(one, two[::-1], atol=1e-12)


def test_the_seed_of_the_situation_decides_what_is_drawn():
    situation = random_situation(8, own=12, other=12)
    again = Situation(situation.plans, situation.game, situation.contact_time, seed=8)
    other = Situation(situation.plans, situation.game, situation.contact_time, seed=9)
    prediction = PlanPrediction(games=4, plans=3)
    np.testing.assert_array_equal(
        prediction.predict(situation, "robot").values, prediction.predict(again, "robot").values
    )
    assert not np.array_equal(
        prediction.predict(situation, "robot").values, prediction.predict(other, "robot").values
    )


def test_who_has_left_is_predicted_to_stay_so():
    robot = plan_set("robot", [2.0, 3.0])
    situation = Situation.from_contacts([robot, PlanSet.holding("human", [0.0])], np.full((3, 1), np.inf))
    assert PlanPrediction().predict(situation, "robot").values.tolist() == [[1.0], [1.0]]


def test_parameters_and_agents_out_of_range_are_refused():
    with pytest.raises(ModelError, match="games must be at least 1; got 0"):
        PlanPrediction(games=0)
    with pytest.raises(ModelError, match="norm_rationality must lie in"):
        PlanPrediction(norm_rationality=-1.0)
    three = Situation.from_contacts(
        [plan_set(name, [1.0]) for name in ("robot", "human", "child")], np.full((2, 2, 2), np.inf)
    )
    with pytest.raises(ModelError, match="for two agents; there are 3"):
        PlanPrediction().predict(three, "robot")
