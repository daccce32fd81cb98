from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy.optimize import lsq_linear

from ppinfer.errors import SafetyError
from ppinfer.safety import Body, body_gap, segment_distance

# whole numbers among them: parallel, touching and crossing segments, and points
COORDINATE = st.sampled_from([-2.0, -1.0, 0.0, 1.0, 2.0]) | st.floats(-5, 5)


@given(st.sampled_from([1, 2, 3]).flatmap(lambda space: arrays(float, (4, space), elements=COORDINATE)))
def test_the_distance_is_the_least_between_any_two_points_of_the_segments(ends):
    a, b, c, d = ends
    found = segment_distance(a, b, c, d)
    # bounded least squares over both shares, and a grid that no minimum is below
    solved = lsq_linear(np.stack([b - a, c - d], axis=1), c - a, bounds=(0, 1), tol=1e-14)
    assert_allclose(found, np.sqrt(2 * solved.cost), atol=2e-5)
    s, t = np.meshgrid(np.linspace(0, 1, 21), np.linspace(0, 1, 21))
    points = a + s[..., None] * (b - a) - c - t[..., None] * (d - c)
    assert found <= np.linalg.norm(points, axis=-1).min() + 1e-9


@given(arrays(float, (4, 2), elements=COORDINATE))
def test_it_does_not_matter_which_is_first_or_which_end_is_which(ends):
    a, b, c, d = ends
    found = segment_distance(a, b, c, d)
    for other in ((b, a, c, d), (a, b, d, c), (c, d, a, b)):
        assert_allclose(segment_distance(*other), found, atol=1e-7)


def test_many_segments_are_measured_at_once():
    rng = np.random.default_rng(0)
    one, other = rng.normal(size=(5, 1, 2, 3)), rng.normal(size=(1, 7, 2, 3))
    table = segment_distance(one[..., 0, :], one[..., 1, :], other[..., 0, :], other[..., 1, :])
    assert table.shape == (5, 7)
    alone = segment_distance(one[3, 0, 0], one[3, 0, 1], other[0, 2, 0], other[0, 2, 1])
    assert_allclose(table[3, 2], alone)


def test_surfaces_are_nearer_than_axes_and_overlap_is_negative():
    disc, rod = Body([[0.0, 0.0]], [[0.0, 0.0]], [0.5]), Body([[-1.0, 0.0]], [[1.0, 0.0]], [0.25])
    assert_allclose(body_gap(disc, np.array([0.0, 2.0]), rod, np.zeros(2)), 1.25)
    assert_allclose(body_gap(disc, np.array([0.0, 0.5]), rod, np.zeros(2)), -0.25)
    both = Body([[-1.0, 0.0], [0.0, 3.0]], [[1.0, 0.0], [0.0, 4.0]], [0.25, 0.1])
    assert_allclose(body_gap(both, np.zeros(2), Body.point(2), np.array([0.0, 2.0])), 0.9)


@pytest.mark.parametrize(
    "wrong",
    [
        ([[0.0, 0.0]], [[0.0]], [0.1]),
        ([[0.0, 0.0]], [[0.0, 1.0]], [0.1, 0.1]),
        ([[0.0, 0.0]], [[0.0, np.inf]], [0.1]),
        ([[0.0, 0.0]], [[0.0, 1.0]], [-0.1]),
    ],
)
def test_a_body_that_cannot_be_is_refused(wrong):
    with pytest.raises(SafetyError, match="a body needs"):
        Body(*wrong)
