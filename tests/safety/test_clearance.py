"""The probability that a plan stays clear, against distances and sums computed otherwise."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import lsq_linear
from scipy.stats import norm

from ppinfer import Axis, Distribution
from ppinfer.errors import SafetyError
from ppinfer.safety.clearance import PlanBodies, clear_probability, plan_distances

# coordinates of walls and tables: exact ties, parallels and touching ends among them
PLACE = st.sampled_from([-1.0, -0.5, 0.0, 0.5, 1.0]) | st.floats(-3.0, 3.0)


def segment_distance(one, two):
    """Return the distance of two segments: least squares of two shares within bounds, by active sets."""
    (a, b), (c, d) = one, two
    directions = np.column_stack([b - a, c - d])
    found = lsq_linear(directions, c - a, bounds=(0, 1), method="bvls", tol=1e-15)
    ends = [[0, 0], [0, 1], [1, 0], [1, 1]]  # it cannot be further than ends are, whatever rounding does
    return min(np.linalg.norm(directions @ shares - (c - a)) for shares in [found.x, *ends])


def body(*segments, radius=0.0):
    """Return one plan of one step."""
    return PlanBodies(np.array(segments, float)[None, None], radius)


@settings(max_examples=60, deadline=None)
@given(st.sampled_from([2, 3]).flatmap(lambda space: arrays(np.float64, (2, 2, space), elements=PLACE)))
def test_the_distance_of_two_capsules_is_that_of_their_axes_less_their_radii(ends):
    expected = segment_distance(*ends)
    found = plan_distances(body(ends[0], radius=0.1), body(ends[1], radius=0.3))[0, 0]
    assert_allclose(found, expected - 0.4, atol=2e-6)
    assert_allclose(plan_distances(body(ends[1]), body(ends[0]))[0, 0], expected, atol=2e-6)
    # an end and the other are the same capsule
    assert_allclose(plan_distances(body(ends[0][::-1]), body(ends[1]))[0, 0], expected, atol=2e-6)


def test_segments_that_cross_touch_or_lie_along_each_other_are_at_no_distance():
    cross = body([[-1, 0], [1, 0]])
    for other in ([[0, -1], [0, 1]], [[1, 0], [1, 1]], [[0.5, 0], [3, 0]], [[0, 0], [0, 0]]):
        assert plan_distances(cross, body(other))[0, 0] == pytest.approx(0.0, abs=1e-9)
    assert plan_distances(cross, body([[-1, 2], [1, 2]]))[0, 0] == pytest.approx(2.0)


def test_all_plans_all_steps_and_all_capsules_at_once_are_the_pairs_one_by_one():
    rng = np.random.default_rng(0)
    own = PlanBodies(rng.normal(size=(3, 4, 2, 2, 2)), [0.1, 0.2], [4, 2, 0])
    other = PlanBodies(rng.normal(size=(2, 4, 3, 2, 2)), 0.05, [3, 4])
    found = plan_distances(own, other)
    for i, j in np.ndindex(found.shape):
        distances = [
            segment_distance(own.ends[i, t, a], other.ends[j, t, b]) - own.radius[a] - 0.05
            for t in range(min(own.steps[i], other.steps[j]))
            for a in range(2)
            for b in range(3)
        ]
        assert_allclose(found[i, j], min(distances, default=np.inf), atol=2e-6)
    assert_array_equal(found[2], [np.inf, np.inf])
    assert_array_equal(plan_distances(own.take([2, 0]), other), found[[2, 0]])


def random_bodies(rng, plans, capsules=2):
    return PlanBodies(rng.normal(size=(plans, 5, capsules, 2, 2)), 0.1)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 1.5))
def test_without_noise_it_is_the_belief_in_plans_that_stay_clear(seed, margin):
    rng = np.random.default_rng(seed)
    own, others = random_bodies(rng, 3), [random_bodies(rng, count) for count in (4, 2)]
    beliefs = [rng.dirichlet(np.ones(count)) for count in (4, 2)]
    wall = PlanBodies.still(rng.normal(size=(1, 2, 2)), 0.05, steps=5)
    found = clear_probability(own, list(zip(others, beliefs, strict=True)), margin=margin, obstacles=wall)
    for plan in range(3):
        expected = float(plan_distances(own, wall)[plan, 0] > margin)
        for other, belief in zip(others, beliefs, strict=True):
            expected *= sum(
                p for p, d in zip(belief, plan_distances(own, other)[plan], strict=True) if d > margin
            )
        assert_allclose(found.clear[plan], expected, atol=1e-12)
    assert_array_equal(found.standard_error, np.zeros(3))
    assert_array_equal(found.distance[0], plan_distances(own, others[0]))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_larger_margin_and_one_more_other_never_make_a_plan_clearer(seed):
    rng = np.random.default_rng(seed)
    own, one, two = (random_bodies(rng, 3) for _ in range(3))
    even = np.full(3, 1 / 3)
    clear = clear_probability(own, [(one, even)], margin=0.1).clear
    assert (clear_probability(own, [(one, even)], margin=0.4).clear <= clear).all()
    assert (clear_probability(own, [(one, even), (two, even)], margin=0.1).clear <= clear + 1e-12).all()


def test_with_noise_it_agrees_with_the_closed_form():
    # a point passes a wall at a distance of 1: clear while the offset towards it is below that
    own = PlanBodies.points(np.array([[[0.0, 1.0], [1.0, 1.0]], [[0.0, 0.7], [1.0, 0.7]]]))
    wall = PlanBodies.still([[[-100.0, 0.0], [100.0, 0.0]]], 0.0, steps=2)
    found = clear_probability(
        own, [(wall, [1.0])], margin=0.2, noise=[0.2, 0.4], rollouts=20000, rng=np.random.default_rng(0)
    )
    # the wall may also be carried past the point
    expected = []
    for height in (1.0, 0.7):
        z = np.linspace(-8, 8, 200_001)
        clear = (np.abs(height - 0.2 * z) > 0.2) & (np.abs(height - 0.4 * z) > 0.2)
        expected.append(np.sum(norm.pdf(z) * clear) * (z[1] - z[0]))
    assert (np.abs(found.clear - expected) < 4 * found.standard_error).all()
    assert (found.standard_error < 0.004).all()


def test_a_distribution_over_plans_is_a_belief_and_decides_with_rounding_in_mind():
    own = PlanBodies.points(np.zeros((1, 1, 2)))
    other = PlanBodies.points(np.array([[[0.0, 0.0]], [[1.0, 0.0]], [[2.0, 0.0]]]))
    belief = Distribution.from_probabilities([Axis("human_plan", 3)], [0.05, 0.65, 0.3])
    found = clear_probability(own, [(other, belief)])
    assert found.clear[0] == pytest.approx(0.95)
    assert found.is_clear(eps=0.05)[0]
    assert not found.is_clear(eps=0.04)[0]


def test_what_makes_no_sense_is_refused():
    own = PlanBodies.points(np.zeros((1, 2, 2)))
    for wrong, message in (
        (lambda: PlanBodies(np.zeros((1, 2, 2)), 0.1), "shape"),
        (lambda: PlanBodies.points(np.zeros((1, 2))), "shape"),
        (lambda: PlanBodies.points(np.full((1, 1, 2), np.nan)), "finite"),
        (lambda: PlanBodies.points(np.zeros((1, 1, 2)), radius=-1.0), "negative"),
        (lambda: PlanBodies(np.zeros((1, 2, 3, 2, 2)), [0.1, 0.2]), "3 capsules"),
        (lambda: PlanBodies.points(np.zeros((1, 2, 2)), steps=[3]), "from 0 to 2"),
        (lambda: plan_distances(own, PlanBodies.points(np.zeros((1, 3, 2)))), "same steps"),
        (lambda: plan_distances(own, own, shift=np.zeros((1, 1, 2))), "shift"),
        (lambda: clear_probability(own, [(own, [0.5])]), "sum to 1"),
        (lambda: clear_probability(own, [(own, [0.5, 0.5])]), "over 1 plans"),
        (lambda: clear_probability(own, [(own, [1.0])], margin=np.inf), "margin"),
        (lambda: clear_probability(own, [(own, [1.0])], noise=-1.0), "noise"),
        (lambda: clear_probability(own, [(own, [1.0])], noise=0.1), "generator"),
        (lambda: clear_probability(own, [], obstacles=PlanBodies.points(np.zeros((2, 2, 2)))), "one plan"),
    ):
        with pytest.raises(SafetyError, match=message):
            wrong()
