"""Classes of theta, and (7)-(10) over them, against plain Python."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer.coordination.classes import favoured_classes, log_class_likelihood, log_p_alpha


@st.composite
def weighted_classes(draw):
    """Draw log weights of profiles, which of them are equilibria, and of which classes."""
    thetas, profiles = draw(st.integers(2, 3)), draw(st.integers(1, 6))
    among = np.array(draw(st.lists(st.booleans(), min_size=profiles, max_size=profiles)))
    member = np.array(draw(st.lists(st.booleans(), min_size=thetas * profiles, max_size=thetas * profiles)))
    log_profile = np.array(draw(st.lists(st.integers(-40, 0), min_size=profiles, max_size=profiles))) / 4
    return log_profile, member.reshape(thetas, profiles) & among, among


def by_hand(log_profile, classes, among, *, average, skip_empty, contamination):
    """Follow the equations term by term in exact arithmetic on the rounded weights."""
    weight = [Fraction(math.exp(value)) for value in log_profile]
    thetas, profiles = classes.shape
    size = [int(count) for count in classes.sum(axis=1)]
    found = []
    for theta in range(thetas):
        total = Fraction(0)
        for a in range(profiles):
            if not among[a]:
                continue
            given_theta = [
                Fraction(int(classes[t, a]), size[t]) if size[t] else Fraction(0) for t in range(thetas)
            ]
            if average:
                total += given_theta[theta] * weight[a]
            elif sum(given_theta):
                total += weight[a] * given_theta[theta] / sum(given_theta)
            else:
                total += weight[a] / thetas
        found.append(total)
    if skip_empty:
        said = [found[t] for t in range(thetas) if size[t]]
        mean = sum(said, Fraction(0)) / max(1, len(said))
        found = [found[t] if size[t] else mean for t in range(thetas)]
    if not sum(found):
        found = [Fraction(1)] * thetas
    share = Fraction(contamination)
    return [float(((1 - share) * one / sum(found) + share / thetas) * thetas) for one in found]


@settings(max_examples=150)
@given(weighted_classes(), st.booleans(), st.booleans(), st.sampled_from([0.0, 0.04, 1.0]))
def test_the_likelihood_of_a_class_is_what_the_equations_give_in_exact_arithmetic(
    drawn, average, skip_empty, contamination
):
    log_profile, classes, among = drawn
    found = log_class_likelihood(
        log_profile[None], classes[:, None], among[None],
        average=average, skip_empty=skip_empty, contamination=contamination,
    )[0]  # fmt: skip
    expected = by_hand(
        log_profile, classes, among, average=average, skip_empty=skip_empty, contamination=contamination
    )
    np.testing.assert_allclose(np.exp(found), expected, rtol=1e-12, atol=1e-15)


def test_a_class_that_is_a_million_nats_worse_keeps_its_log():
    classes, among = np.array([[[True, False]], [[False, True]]]), np.ones((1, 2), bool)
    for average in (True, False):
        found = log_class_likelihood(
            np.array([[0.0, -1e6]]), classes, among, average=average, skip_empty=True, contamination=0.0
        )
        np.testing.assert_allclose(found, [[math.log(2), math.log(2) - 1e6]], rtol=1e-12)


def test_with_two_classes_an_empty_one_means_no_update_at_all():
    classes, among = np.array([[[True, True]], [[False, False]]]), np.ones((1, 2), bool)
    found = log_class_likelihood(
        np.array([[-1.0, -5.0]]), classes, among, average=True, skip_empty=True, contamination=0.04
    )
    np.testing.assert_allclose(found, 0.0, atol=1e-15)


@settings(max_examples=100)
@given(weighted_classes(), st.integers(1, 9))
def test_p_alpha_is_7_and_8_in_exact_arithmetic(drawn, share):
    _, classes, among = drawn
    if not among.any():
        return
    belief = [Fraction(share, 10 * (len(classes) - 1))] * (len(classes) - 1)
    belief.append(1 - sum(belief))
    size = [int(count) for count in classes.sum(axis=1)]
    weight = [
        sum(belief[t] / size[t] for t in range(len(classes)) if classes[t, a])
        for a in range(classes.shape[1])
    ]
    if not sum(weight):
        weight = [Fraction(int(one)) for one in among]
    expected = [float(one / sum(weight)) for one in weight]
    found = np.exp(log_p_alpha(np.log([float(one) for one in belief]), classes, among))
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-15)


def test_a_certain_belief_in_an_empty_class_leaves_every_equilibrium_as_likely():
    classes = np.array([[True, True, False], [False, False, False]])
    found = np.exp(log_p_alpha(np.array([-math.inf, 0.0]), classes, np.array([True, True, False])))
    np.testing.assert_allclose(found, [0.5, 0.5, 0.0])


def test_ties_belong_to_the_class_of_each_or_to_none():
    costs, among = np.array([[1.0, 2.0, 3.0], [2.0, 2.0, 1.0], [2.0, 2.0, 1.0]]), np.ones(3, bool)
    assert favoured_classes(costs, among).astype(int).tolist() == [[1, 1, 0], [0, 1, 1], [0, 1, 1]]
    assert favoured_classes(costs, among, ties=False).astype(int).tolist() == [
        [1, 0, 0],
        [0, 0, 0],
        [0, 0, 0],
    ]


def test_what_is_no_equilibrium_belongs_to_no_class():
    costs = np.array([[np.inf, 1.0], [np.inf, 2.0]])
    among = np.array([False, True])
    found = favoured_classes(costs, among, fair_within=0.5)
    assert found.astype(int).tolist() == [[0, 1], [0, 0], [0, 0]]


@pytest.mark.parametrize("within", [0.0, 1.0, 2.0])
def test_fair_equilibria_favour_nobody(within):
    costs = np.array([[1.0, 2.0, 5.0], [2.0, 2.0, 3.0]])
    found = favoured_classes(costs, np.ones(3, bool), fair_within=within)
    apart = np.abs(costs[0] - costs[1])
    np.testing.assert_array_equal(found[2], apart <= within)
    np.testing.assert_array_equal(found[:2].any(axis=0), apart > within)


@settings(max_examples=100)
@given(st.integers(0, 2**32), st.integers(2, 3))
def test_by_loss_each_agent_is_favoured_by_its_own_best_equilibrium(seed, players):
    rng = np.random.default_rng(seed)
    costs = rng.integers(1, 6, (players, *[3] * players)).astype(float)
    among = rng.random([3] * players) < 0.4
    classes = favoured_classes(costs, among, favour_by="loss")
    assert not (classes & ~among).any()
    cells = [tuple(cell) for cell in np.argwhere(among)]
    if not cells:
        return
    best = [min(costs[(player, *cell)] for cell in cells) for player in range(players)]
    for cell in cells:
        loss = [costs[(player, *cell)] - best[player] for player in range(players)]
        assert classes[(slice(None), *cell)].tolist() == [one == min(loss) for one in loss]
    for player in range(players):
        assert classes[player].any()


def test_by_loss_a_batch_of_games_is_classified_game_by_game():
    rng = np.random.default_rng(3)
    costs, among = rng.uniform(1, 9, (2, 5, 4, 3)), rng.random((5, 4, 3)) < 0.4
    together = favoured_classes(costs, among, favour_by="loss")
    for game in range(5):
        np.testing.assert_array_equal(
            together[:, game], favoured_classes(costs[:, game], among[game], favour_by="loss")
        )


def test_by_loss_what_a_constant_adds_to_one_agents_costs_changes_nothing():
    rng = np.random.default_rng(4)
    costs, among = rng.integers(1, 9, (2, 4, 4)).astype(float), rng.random((4, 4)) < 0.5
    later = costs + np.array([32.0, 0.0])[:, None, None]
    np.testing.assert_array_equal(
        favoured_classes(costs, among, favour_by="loss"), favoured_classes(later, among, favour_by="loss")
    )


def test_costs_that_differ_by_rounding_only_are_ties():
    costs = np.array([[0.1 + 0.2], [0.3]])
    assert favoured_classes(costs, np.ones(1, bool)).all()
