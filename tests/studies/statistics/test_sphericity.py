import math

import numpy as np
import pytest
from hypothesis import given
from scipy.stats import chi2

from ppinfer.studies.statistics import sphericity
from ppinfer.studies.statistics.contrasts import effect_scores, orthonormal_contrasts

from .designs import ATTITUDES, BUSHTUCKER, TUTORS, whole_numbers
from .exact import exact_epsilon


@pytest.mark.parametrize(
    ("measures", "effect", "published"),
    [
        (BUSHTUCKER, (0,), (0.136, 11.406, 5, 0.047)),
        (TUTORS, (0,), (0.131, 11.628, 5, 0.043)),
        (ATTITUDES, (0,), (0.267, 23.753, 2, 0.000)),
        (ATTITUDES, (1,), (0.662, 7.422, 2, 0.024)),
        (ATTITUDES, (0, 1), (0.595, 9.041, 9, 0.436)),
    ],
)
def test_mauchlys_test_comes_out_as_published(measures, effect, published):
    judged = sphericity(effect_scores(measures.values, effect))
    told = (judged.mauchly_w, judged.mauchly_chi2, judged.mauchly_df, judged.mauchly_p)
    assert tuple(round(value, 3) for value in told) == published


@given(whole_numbers(factors=(1, 1), levels=(3, 4), subjects=(2, 7)))
def test_epsilon_is_that_of_the_covariances_of_levels(values):
    exact = exact_epsilon(values)
    judged = sphericity(effect_scores(values.astype(float), (0,)))
    if exact is None:
        # nothing but rounding varies here, which the analysis of variance has put to zero before
        return
    assert judged.epsilon == pytest.approx(float(exact), rel=1e-9)
    p = values.shape[1] - 1
    assert 1 / p - 1e-12 <= judged.epsilon <= judged.epsilon_hf + 1e-12 <= 1 + 2e-12


@given(whole_numbers(factors=(2, 2), levels=(2, 3), subjects=(4, 8)))
def test_which_orthonormal_contrasts_are_taken_does_not_matter(values):
    scores = effect_scores(values.astype(float), (0, 1))
    scores = scores - scores.mean(axis=0)
    if np.abs(scores).max() < 1e-9:
        return
    turn = np.linalg.qr(np.random.default_rng(len(values)).normal(size=(scores.shape[1],) * 2))[0]
    one, other = sphericity(scores), sphericity(scores @ turn)
    assert other.epsilon == pytest.approx(one.epsilon, rel=1e-9)
    if not math.isnan(one.mauchly_w):
        assert other.mauchly_w == pytest.approx(one.mauchly_w, rel=1e-6, abs=1e-12)


def test_mauchlys_p_is_uniform_where_sphericity_holds():
    rng = np.random.default_rng(5)
    judged = [sphericity(rng.normal(size=(12, 3))) for _ in range(4000)]
    p = np.array([each.mauchly_p for each in judged])
    # the standard errors are 0.35 % and 0.8 %
    assert (p < 0.05).mean() == pytest.approx(0.05, abs=0.01)
    assert (p < 0.5).mean() == pytest.approx(0.5, abs=0.03)
    first = judged[0]
    assert chi2.sf(first.mauchly_chi2, first.mauchly_df) == pytest.approx(first.mauchly_p, abs=0.02)


@pytest.mark.parametrize("contrasts", [3, 49, 98, 103])
def test_two_subjects_leave_the_epsilon_of_huynh_and_feldt_at_one_however_numbers_round(contrasts):
    judged = sphericity(np.random.default_rng(0).normal(size=(2, contrasts)))
    assert judged.epsilon == pytest.approx(1 / contrasts)
    assert judged.epsilon_hf == 1.0


def test_contrasts_without_variance_leave_w_zero():
    scores = np.column_stack([np.arange(6.0), np.zeros(6)])
    judged = sphericity(scores)
    assert (judged.mauchly_w, judged.mauchly_chi2, judged.mauchly_p) == (0.0, math.inf, 0.0)
    assert judged.epsilon == 0.5


@pytest.mark.parametrize("levels", [2, 3, 7])
def test_contrasts_are_orthonormal_and_add_up_to_zero(levels):
    C = orthonormal_contrasts(levels)
    assert np.allclose(C.T @ C, np.eye(levels - 1), atol=1e-14)
    assert np.allclose(C.sum(axis=0), 0, atol=1e-14)
