"""The baselines are the formulas they are called by."""

import numpy as np
import pytest
from hypothesis import given
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.special import softmax
from scipy.stats import vonmises

from ppinfer.errors import ModelError
from ppinfer.goals import Heading, NearestGoal, infer_goals
from ppinfer.goals.motion import previous_seen
from ppinfer.testing import goal_evidences


@given(goal_evidences())
def test_the_nearest_goal_is_a_softmax_of_distances(evidence):
    belief = np.exp(infer_goals(NearestGoal(scale=2.5), evidence).log_posterior)
    for sample in np.flatnonzero(evidence.seen):
        row = evidence.row_of_sample[sample]
        there = evidence.goal_present[row]
        distance = np.linalg.norm(evidence.goals[row, there] - evidence.position[sample], axis=1)
        assert_allclose(belief[sample, there], softmax(-distance / 2.5), atol=1e-12)


@given(goal_evidences())
def test_the_heading_is_a_softmax_of_cosines(evidence):
    belief = np.exp(infer_goals(Heading(concentration=1.7), evidence).log_posterior)
    before = previous_seen(evidence)
    for sample in np.flatnonzero(evidence.seen & (before >= 0)):
        row = evidence.row_of_sample[sample]
        there = evidence.goal_present[row]
        step = evidence.position[sample] - evidence.position[before[sample]]
        towards = evidence.goals[row, there] - evidence.position[before[sample]]
        size = np.linalg.norm(step) * np.linalg.norm(towards, axis=1)
        cosine = np.where(size > 0, towards @ step / np.where(size > 0, size, 1), 0.0)
        assert_allclose(belief[sample, there], softmax(1.7 * cosine), atol=1e-12)


def test_the_density_about_a_goal_integrates_to_one(one_sample):
    evidence = one_sample([0.0, 0.0])

    def ring(radius):
        log_density = NearestGoal(scale=0.7).log_likelihood(one_sample([radius, 0.0])).log_values[0, 0]
        return 2 * np.pi * radius * np.exp(log_density)

    assert evidence.samples == 1
    assert_allclose(quad(ring, 0, 60)[0], 1.0, atol=1e-8)


def test_the_heading_density_is_von_mises(two_samples):
    for angle in (0.0, 1.0, np.pi):
        log_density = Heading(concentration=2.2).log_likelihood(two_samples(angle)).log_values[1, 0]
        assert_allclose(log_density, vonmises.logpdf(angle, 2.2), atol=1e-12)


@pytest.mark.parametrize("concentration", [0.0, 1e3, 1e6])
def test_extreme_concentrations_stay_finite(two_samples, concentration):
    assert np.isfinite(Heading(concentration=concentration).log_likelihood(two_samples(2.0)).log_values).all()


def test_parameters_out_of_range_are_refused():
    with pytest.raises(ModelError, match="scale must lie in"):
        NearestGoal(scale=0.0)
    with pytest.raises(ModelError, match="concentration must lie in"):
        Heading(concentration=-1.0)
