import math

import numpy as np
import pytest
from hypothesis import given, settings
from scipy.stats import ttest_rel

from ppinfer.studies.statistics import pairwise_tests

from .designs import ATTITUDES, BUSHTUCKER, design, whole_numbers


def test_fields_pairs_come_out_as_spss_prints_them():
    tests = {(test.a, test.b): test for test in pairwise_tests(BUSHTUCKER, "bonferroni")}
    assert len(tests) == 6
    for pair, printed in {
        ("a0", "a1"): (3.875, 0.925, 6.825, 0.012),
        ("a0", "a2"): (4.000, 1.339, 6.661, 0.006),
        ("a0", "a3"): (2.375, -4.141, 8.891, 1.000),
    }.items():
        test = tests[pair]
        told = (test.mean_difference, test.low_simultaneous, test.high_simultaneous, test.p_bonferroni)
        assert tuple(round(value, 3) for value in told) == printed
        assert test.p_adjusted == test.p_bonferroni
        assert test.low_simultaneous < test.low < test.mean_difference < test.high < test.high_simultaneous


# statsmodels collects garbage at every adjustment, which takes long where much is loaded
@settings(max_examples=12)
@given(whole_numbers(factors=(1, 1), levels=(2, 4), subjects=(2, 7)))
def test_pairs_are_scipys_paired_tests_adjusted_by_hand(values):
    tests = pairwise_tests(design(values), "holm")
    pairs = len(tests)
    known = [1.0 if math.isnan(test.p) else test.p for test in tests]
    steps, holm = sorted(range(pairs), key=lambda index: known[index]), np.zeros(pairs)
    for rank, index in enumerate(steps):
        before = holm[steps[rank - 1]] if rank else 0.0
        holm[index] = max(before, min(1.0, (pairs - rank) * known[index]))
    for index, test in enumerate(tests):
        a, b = (values[:, int(name[1:])] for name in (test.a, test.b))
        if np.ptp(a - b) == 0:
            assert test.to_json()["t"] is None
            assert test.to_json()["credible_low"] is None
            assert test.p == 0.0 if (a - b).any() else math.isnan(test.p_holm)
            continue
        told = ttest_rel(a, b)
        assert test.t == pytest.approx(told.statistic, rel=1e-9, abs=1e-12)
        assert test.p == pytest.approx(told.pvalue, rel=1e-9)
        interval = told.confidence_interval(0.95)
        assert (test.low, test.high) == pytest.approx((interval.low, interval.high), rel=1e-9, abs=1e-9)
        assert test.effect_size == pytest.approx(np.mean(a - b) / np.std(a - b, ddof=1))
        assert test.p_bonferroni == pytest.approx(min(1.0, pairs * test.p))
        assert test.p_adjusted == test.p_holm == pytest.approx(holm[index])
        # an interval excludes zero just where its p is below 5 %
        assert (test.low > 0 or test.high < 0) == (test.p < 0.05)
        assert (test.low_simultaneous > 0 or test.high_simultaneous < 0) == (test.p_bonferroni < 0.05)


def test_with_several_factors_others_are_averaged_and_each_factor_is_a_family():
    tests = pairwise_tests(ATTITUDES, "bonferroni")
    assert [test.effect for test in tests] == ["drink"] * 3 + ["imagery"] * 3
    beer, wine = ATTITUDES.values.mean(axis=2)[:, :2].T
    assert tests[0].p == pytest.approx(ttest_rel(beer, wine).pvalue)
    assert tests[0].p_bonferroni == pytest.approx(min(1.0, 3 * tests[0].p))
    # published: imagery, all pairs p < .001
    assert all(test.p_bonferroni < 0.001 for test in tests[3:])


def test_differences_of_rounding_size_are_none():
    (test,) = pairwise_tests(design([[0.1 + 0.2, 0.3], [0.7, 0.7], [1e3, 1e3]]))
    assert (test.mean_difference, test.low, test.high) == (0.0, 0.0, 0.0)
    assert math.isnan(test.t)
    assert test.to_json()["bf10"] is None
