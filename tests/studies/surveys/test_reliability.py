"""Cronbach's alpha: against exact arithmetic, published numbers, and its laws."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import stats

from ppinfer.studies.surveys.reliability import (
    Alpha,
    alphas_if_dropped,
    centred_within,
    cronbach_alpha,
    feldt_interval,
    item_rest_correlations,
    standardized_alpha,
    why_no_alpha,
)

# 30 departments rated on 7 items (Chatterjee and Price 1977); R's psych::alpha prints what is expected below
ATTITUDE = """
43 51 30 39 61 92 45  63 64 51 54 63 73 47  71 70 68 69 76 86 48  61 63 45 47 54 84 35  81 78 56 66 71 83 47
43 55 49 44 54 49 34  58 67 42 56 66 68 35  71 75 50 55 70 66 41  72 82 72 67 71 83 31  67 61 45 47 62 80 41
64 53 53 58 58 67 34  67 60 47 39 59 74 41  69 62 57 42 55 63 25  68 83 83 45 59 77 35  77 77 54 72 79 77 46
81 90 50 72 60 54 36  74 85 64 69 79 79 63  65 60 65 75 55 80 60  65 70 46 57 75 85 46  50 58 68 54 64 78 52
50 40 33 34 43 64 33  64 61 52 62 66 80 41  53 66 52 50 63 80 37  40 37 42 58 50 57 49  63 54 42 48 66 75 33
66 77 66 63 88 76 72  78 75 58 74 80 78 49  48 57 44 45 51 83 38  85 85 71 71 77 74 55  82 82 39 59 64 78 39
"""

answers = st.integers(2, 8).flatmap(
    lambda n: st.integers(2, 5).flatmap(
        lambda k: st.lists(st.lists(st.integers(1, 7), min_size=k, max_size=k), min_size=n, max_size=n)
    )
)


def exact_alpha(rows):
    def variance(values):
        mean = Fraction(sum(values), len(values))
        return sum((value - mean) ** 2 for value in values) / (len(values) - 1)

    k = len(rows[0])
    total = variance([sum(row) for row in rows])
    return (
        None if total == 0 else Fraction(k, k - 1) * (1 - sum(map(variance, zip(*rows, strict=True))) / total)
    )


@given(answers)
def test_alpha_is_that_of_exact_arithmetic(rows):
    values = np.array(rows, np.float64)
    wanted = exact_alpha(rows)
    assert (Alpha.of(values).alpha is None) == (wanted is None) == bool(why_no_alpha(values))
    if wanted is not None:
        np.testing.assert_allclose(cronbach_alpha(values), float(wanted), rtol=1e-9, atol=1e-12)


def test_published_numbers_come_out():
    values = np.array(ATTITUDE.split(), np.float64).reshape(30, 7)
    whole = Alpha.of(values)
    assert (round(whole.alpha, 2), round(whole.standardized, 2)) == (0.84, 0.84)
    assert [round(alpha, 2) for alpha in alphas_if_dropped(values)] == [
        0.81,
        0.80,
        0.83,
        0.80,
        0.80,
        0.86,
        0.84,
    ]
    rest = [round(r, 2) for r in item_rest_correlations(values)]
    assert rest == [0.67, 0.74, 0.56, 0.71, 0.79, 0.27, 0.46]


@given(answers, st.randoms(use_true_random=False))
def test_reversing_all_items_or_permuting_anything_leaves_alpha_alone(rows, random):
    values = np.array(rows, np.float64)
    assume(not why_no_alpha(values))
    alpha = cronbach_alpha(values)
    np.testing.assert_allclose(cronbach_alpha(8 - values), alpha, atol=1e-9)
    order, columns = list(range(len(values))), list(range(values.shape[1]))
    random.shuffle(order)
    random.shuffle(columns)
    np.testing.assert_allclose(cronbach_alpha(values[order][:, columns]), alpha, atol=1e-9)
    # changing the unit of all items changes neither
    np.testing.assert_allclose(cronbach_alpha(3 * values + 2), alpha, atol=1e-9)


@given(st.lists(st.integers(1, 7), min_size=2, max_size=8), st.integers(2, 6))
def test_items_that_say_the_same_have_alpha_one(column, k):
    assume(len(set(column)) > 1)
    values = np.tile(np.array(column, np.float64)[:, None], (1, k))
    assert cronbach_alpha(values) == pytest.approx(1.0)
    assert standardized_alpha(values) == pytest.approx(1.0)


@given(answers)
def test_standardized_alpha_is_alpha_of_standardized_items(rows):
    values = np.array(rows, np.float64)
    if (np.ptp(values, axis=0) == 0).any():
        assert standardized_alpha(values) is None
        return
    scaled = (values - values.mean(axis=0)) / values.std(axis=0)
    found = standardized_alpha(values)
    if found is None:
        assert np.ptp(scaled.sum(axis=1)) < 1e-5
    else:
        np.testing.assert_allclose(found, cronbach_alpha(scaled), rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ([[1.0], [2.0]], "two items or more"),
        ([[1.0, 2.0]], "two responses or more that answered every item, here 1"),
        ([[2.0, 2.0], [2.0, 2.0]], "the sum of the items is the same"),
        ([[1.0, 3.0], [3.0, 1.0]], "the sum of the items is the same"),
        ([[0.1, 0.2], [0.2, 0.1]], "the sum of the items is the same"),
        (np.empty((0, 3)), "here 0"),
    ],
)
def test_where_there_is_no_alpha_it_says_why(values, reason):
    found = Alpha.of(np.array(values))
    assert (found.alpha, found.standardized, found.low, found.high) == (None, None, None, None)
    assert reason in found.reason


def test_an_item_that_never_varies_leaves_alpha_but_no_standardized_one():
    found = Alpha.of(np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 3.0], [5.0, 4.0, 3.0]]))
    assert found.alpha is not None
    assert found.standardized is None
    assert "no standardized alpha" in found.reason
    assert "same answer everywhere" in found.reason
    assert item_rest_correlations(np.array([[1.0, 3.0], [2.0, 3.0]])) == (None, None)


def test_items_that_cancel_out_once_standardized_say_so():
    found = Alpha.of(np.array([[1.0, 5.0], [2.0, 3.0], [3.0, 1.0]]))
    assert found.alpha == pytest.approx(-8.0)
    assert found.standardized is None
    assert found.reason == "no standardized alpha: standardized items cancel out"


def test_feldts_interval_is_where_the_f_distribution_says():
    low, high = feldt_interval(0.8, 41, 5)
    for bound, share in ((low, 0.975), (high, 0.025)):
        assert stats.f.cdf((1 - bound) / (1 - 0.8), 40, 160) == pytest.approx(share)
    assert low < 0.8 < high


def test_feldts_interval_holds_alpha_as_often_as_it_says():
    rng = np.random.default_rng(0)
    true = 4 * 0.5 / (1 + 3 * 0.5)
    held = 0
    for _ in range(2000):
        values = np.sqrt(0.5) * (rng.normal(size=(20, 1)) + rng.normal(size=(20, 4)))
        low, high = feldt_interval(cronbach_alpha(values), 20, 4)
        held += low <= true <= high
    assert 0.935 < held / 2000 < 0.965


def test_responses_that_are_not_independent_have_no_interval():
    values = np.array([[1.0, 2.0], [2.0, 2.0], [5.0, 4.0]])
    found = Alpha.of(values, independent=False)
    assert (found.low, found.high) == (None, None)
    assert found.alpha == Alpha.of(values).alpha


@given(answers)
def test_what_differs_between_participants_is_gone_within_them(rows):
    values = np.array(rows, np.float64)
    who = np.arange(len(values)) % 2
    shifted = values + 10.0 * who[:, None]
    np.testing.assert_allclose(centred_within(values, who), centred_within(shifted, who), atol=1e-9)
