from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy import stats

from ppinfer.errors import SafetyError
from ppinfer.safety import (
    SafeProbabilities,
    SafeProbability,
    clopper_pearson_lower,
    clopper_pearson_upper,
    least_safe,
)

from .literal import printed_accepts


@given(
    rollouts=st.integers(1, 2000),
    share=st.floats(0, 1),
    confidence=st.sampled_from([0.9, 0.95, 0.99, 0.9999]),
)
def test_bounds_are_those_of_scipy(rollouts, share, confidence):
    safe = round(share * rollouts)
    interval = stats.binomtest(safe, rollouts, alternative="greater").proportion_ci(confidence, "exact")
    assert_allclose(clopper_pearson_lower(safe, rollouts, confidence), interval.low, atol=1e-9)
    interval = stats.binomtest(safe, rollouts, alternative="less").proportion_ci(confidence, "exact")
    assert_allclose(clopper_pearson_upper(safe, rollouts, confidence), interval.high, atol=1e-9)


@given(
    p=st.floats(0.01, 0.99),
    rollouts=st.sampled_from([10, 100, 1000]),
    confidence=st.sampled_from([0.9, 0.99]),
)
def test_whatever_is_true_the_bound_exceeds_it_no_more_often_than_stated(p, rollouts, confidence):
    counts = np.arange(rollouts + 1)
    exceeds = clopper_pearson_lower(counts, rollouts, confidence) > p
    assert stats.binom.pmf(counts, rollouts, p)[exceeds].sum() <= 1 - confidence + 1e-12


def test_a_thousand_rollouts_must_be_safe_966_times_and_974_among_fifty_candidates():
    assert least_safe(1000) == 966
    assert least_safe(1000, among=50) == 974
    assert SafeProbability(966, 1000).is_safe()
    assert not SafeProbability(965, 1000).is_safe()
    assert SafeProbabilities(np.array([973, 974] * 25), 1000).is_safe().tolist() == [False, True] * 25


@given(st.integers(1, 500), st.sampled_from([0.01, 0.05, 0.2]), st.sampled_from([1, 7, 100]))
def test_enough_is_where_the_lower_bound_reaches_what_is_claimed(rollouts, eps, among):
    enough = least_safe(rollouts, eps, 0.99, among)
    for safe in range(max(0, enough - 1), min(rollouts, enough) + 1):
        found = SafeProbability(safe, rollouts)
        assert found.is_safe(eps, 0.99, among) == (found.lower(0.99, among) >= 1 - eps) == (safe >= enough)


def test_the_printed_estimator_passes_what_is_not_safe():
    # exactly: a true .94 passes mean(F) > 1 - eps in 7.8 % of cases, the best of 50 in 98 %
    passes = stats.binom.sf(950, 1000, 0.94)
    assert_allclose([passes, 1 - (1 - passes) ** 50], [0.078, 0.98], atol=0.005)
    ours = stats.binom.sf(least_safe(1000) - 1, 1000, 0.94)
    among = stats.binom.sf(least_safe(1000, among=50) - 1, 1000, 0.94)
    assert ours <= 0.01
    assert 1 - (1 - among) ** 50 <= 0.01
    # and as drawn
    F = np.random.default_rng(0).random((2000, 1000)) < 0.94
    assert np.mean([printed_accepts(row, 0.05) for row in F]) > 0.05
    assert np.mean([SafeProbability(int(row.sum()), 1000).is_safe() for row in F]) <= 0.01


def test_a_certificate_of_many_candidates_holds_for_all_of_them_by_default():
    found = SafeProbabilities(np.array([960, 970, 980]), 1000)
    assert len(found) == 3
    assert found[1] == SafeProbability(970, 1000)
    assert_allclose(found.lower(), [found[i].lower(among=3) for i in range(3)])
    assert_allclose(found.lower(among=1), [found[i].lower() for i in range(3)])
    assert_allclose(found.estimate, [0.96, 0.97, 0.98])


@pytest.mark.parametrize("wrong", [{"rollouts": 0}, {"eps": 0.0}, {"confidence": 1.0}, {"among": 0}])
def test_a_claim_that_makes_no_sense_is_refused(wrong):
    with pytest.raises(SafetyError, match="rollouts and among must be at least 1"):
        least_safe(**{"rollouts": 100} | wrong)
