"""Ragged rows: every scan restarts exactly at each row."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ppinfer import FactorError, Ragged


@st.composite
def ragged(draw, dtype=np.float64, min_size=0):
    sizes = draw(st.lists(st.integers(min_size, 5), min_size=1, max_size=5))
    shape = (sum(sizes), *draw(st.sampled_from([(), (1,), (2, 3)])))
    numbers = st.floats(-1e12, 1e12) if dtype is np.float64 else st.integers(-(2**40), 2**40)
    return Ragged(draw(arrays(dtype, shape, elements=numbers)), sizes)


@given(st.one_of(ragged(), ragged(np.int64)))
def test_running_sums_are_to_the_bit_those_of_each_row_alone(rows):
    for summed, row in zip(rows.cumsum(), rows, strict=True):
        assert np.array_equal(summed, np.cumsum(row, axis=0))


def test_running_sums_lose_no_digits_to_the_rows_before():
    rows = Ragged([1e300, 1e-300, 1e-300], [1, 2])
    assert rows.cumsum().last().tolist() == [1e300, 2e-300]


@given(ragged())
def test_differences_are_those_of_each_row_alone(rows):
    for difference, row in zip(rows.diff(), rows, strict=True):
        assert np.array_equal(difference[1:], np.diff(row, axis=0))
        assert np.isnan(difference[:1]).all()
    assert all((difference[:1] == 0.0).all() for difference in rows.diff(first=0.0))


@given(ragged())
def test_rows_samples_and_their_places_belong_together(rows):
    for row, size in enumerate(rows.row_size):
        mine = rows.row_of_sample == row
        assert mine.sum() == size
        assert np.array_equal(rows.values[mine], rows[row])
        assert rows.sample_in_row[mine].tolist() == list(range(size))
    assert len(rows) == len(rows.row_size)


@given(ragged())
def test_rows_split_and_laid_end_to_end_again_are_the_same(rows):
    again = Ragged.concat(rows.split())
    assert np.array_equal(again.values, rows.values)
    assert np.array_equal(again.row_size, rows.row_size)


@given(ragged(min_size=1))
def test_the_first_and_last_samples_are_those_of_each_row(rows):
    assert np.array_equal(rows.first(), np.array([row[0] for row in rows]))
    assert np.array_equal(rows.last(), np.array([row[-1] for row in rows]))


def test_an_empty_row_has_no_last_sample():
    with pytest.raises(FactorError, match="row 1 is empty and has no last sample"):
        Ragged([1.0], [1, 0]).last()


def test_sizes_that_do_not_fit_are_refused_with_the_sizes():
    with pytest.raises(FactorError, match="add up to 3 samples over 2 rows, but the values hold 4"):
        Ragged(np.zeros(4), [1, 2])
    with pytest.raises(FactorError, match="row 1 has a negative size, -1"):
        Ragged(np.zeros(4), [5, -1])
    with pytest.raises(FactorError, match="integers, got shape"):
        Ragged(np.zeros(4), [2.0, 2.0])
    with pytest.raises(FactorError, match="leading sample dimension"):
        Ragged(3.0, [1])
    with pytest.raises(FactorError, match="no rows"):
        Ragged.concat([])
    with pytest.raises(FactorError, match="agree in all dimensions"):
        Ragged.concat([np.zeros((2, 2)), np.zeros((2, 3))])
    with pytest.raises(FactorError, match="no running sum"):
        Ragged(["a"], [1]).cumsum()


def test_ragged_rows_are_frozen_and_share_nothing_with_their_input():
    values = np.zeros(3)
    rows = Ragged(values, [1, 2])
    values[0] = 7.0
    assert rows.values[0] == 0.0
    for array in (rows.values, rows.row_size, rows.row_start, rows.cumsum().values):
        assert not array.flags.writeable
    assert repr(pickle.loads(pickle.dumps(rows))) == "Ragged(2 rows, 3 samples of shape ())"
