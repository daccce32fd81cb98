"""Factors: arithmetic against rational numbers, zeros, refusals, faces."""

import math
import pickle

import numpy as np
import pytest
import xarray as xr
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.special import logsumexp

from ppinfer import Axis, AxisError, Factor, FactorError, ImpossibleEvidenceError
from ppinfer.testing import axis_sets, factors, relabellings
from ppinfer.testing.laws import check_relabelling

from .exact import Exact

GOAL = Axis("goal", ["cup", "bowl", "mug"])
TRIAL = Axis("trial", 2)


@st.composite
def exact_pairs(draw):
    """Two factors of small whole numbers over overlapping axes, each with its exact twin."""
    axes = draw(axis_sets(max_axes=3))
    pair = []
    for _ in range(2):
        some = [axis for axis in draw(st.permutations(axes)) if draw(st.booleans())]
        weights = draw(arrays(np.int64, [len(axis) for axis in some], elements=st.integers(0, 6)))
        pair.append((Factor.from_values(some, weights), Exact.of(some, weights)))
    return pair


@given(exact_pairs())
def test_products_agree_with_rational_arithmetic(pair):
    (f, exact_f), (g, exact_g) = pair
    assert (exact_f * exact_g).agrees_with(f * g)


@given(exact_pairs())
def test_quotients_agree_with_rational_arithmetic_or_name_the_division_by_zero(pair):
    (f, exact_f), (g, exact_g) = pair
    try:
        exact = exact_f / exact_g
    except ZeroDivisionError:
        with pytest.raises(FactorError, match="division by zero at"):
            f / g
    else:
        assert exact.agrees_with(f / g)


@given(exact_pairs(), st.data())
def test_sums_and_maxima_agree_with_rational_arithmetic(pair, data):
    ((f, exact), _) = pair
    names = data.draw(st.sets(st.sampled_from(f.names))) if f.names else set()
    if not names:
        return
    assert exact.sum(*names).agrees_with(f.sum(*names))
    assert exact.max(*names).agrees_with(f.max(*names))


@given(exact_pairs(), st.data())
def test_normalising_agrees_with_rational_arithmetic_or_names_the_cell_without_support(pair, data):
    ((f, exact), _) = pair
    if not f.names:
        return
    names = data.draw(st.sets(st.sampled_from(f.names), min_size=1))
    if any(value == 0 for value in exact.sum(*names).table.values()):
        with pytest.raises(ImpossibleEvidenceError, match="no hypothesis over"):
            f.normalize(*names)
    else:
        assert exact.normalize(*names).agrees_with(f.normalize(*names))


@given(exact_pairs(), st.data())
def test_any_order_of_axes_gives_the_same_factor(pair, data):
    ((f, _), (g, _)) = pair
    turned = f.align(*data.draw(st.permutations(f.names)))
    assert turned == f
    assert turned * g == f * g
    assert (g * turned).allclose(f * g)


@given(factors())
def test_sums_survive_what_scipys_logsumexp_survives(f):
    with np.errstate(divide="ignore"):
        expected = logsumexp(f.log_values)
    assert np.allclose(f.sum().log_values, expected, rtol=1e-15, atol=1e-14)


@given(factors(zeros=False))
def test_dividing_undoes_multiplying(f):
    assert (f * f / f).allclose(f, rtol=1e-15)


@given(factors(), st.floats(0.0, 4.0, allow_subnormal=False))
def test_powers_multiply_logs_and_keep_zeros(f, t):
    power = f**t
    zero = f.log_values == -math.inf
    assert np.array_equal(power.log_values[~zero], f.log_values[~zero] * t)
    assert np.all(power.log_values[zero] == (0.0 if t == 0.0 else -math.inf))


@given(factors(zeros=False), st.data())
def test_relabelling_an_axis_relabels_sums_and_products_and_nothing_else(f, data):
    labels = data.draw(relabellings(f.axes[0]))
    check_relabelling(lambda g: g * g, f.names[0], labels, f)
    for name in f.names[1:]:
        check_relabelling(lambda g, name=name: g.sum(name), f.names[0], labels, f)


@given(factors())
def test_picking_every_label_in_turn_takes_the_factor_apart(f):
    name = f.names[-1]
    for label in f.axes[-1].labels:
        single, shorter = f.restrict(**{name: label}), f.restrict(**{name: [label]})
        assert name not in single.names
        assert np.array_equal(shorter.log_values[..., 0], single.log_values)
        assert np.array_equal(single.log_values, f.log_values[..., f.axes[-1].index(label)])


@given(factors())
def test_xarray_and_back_is_the_same_factor(f):
    assert Factor.from_xarray(f.to_xarray()) == f


@given(factors())
def test_pickled_and_back_is_the_same_read_only_factor(f):
    again = pickle.loads(pickle.dumps(f))
    assert again == f
    assert not again.log_values.flags.writeable


@given(factors())
def test_masks_as_arrays_and_as_factors_do_the_same(f):
    mask = f.log_values > -1.0
    assert f.where(mask) == f.where(Factor.from_mask(f.axes, mask)) == f * Factor.from_mask(f.axes, mask)


@given(factors())
def test_no_operation_makes_a_nan(f):
    assume((f.log_values > -math.inf).any())
    for result in (f * f, f**0.5, f**0, f.sum(), f.max(f.names[0]), f / f, f.normalize(*f.names)):
        assert (result.log_values < math.inf).all()


def test_zero_to_the_zero_is_one():
    assert (Factor.from_values([GOAL], [0, 1, 2]) ** 0).values.tolist() == [1.0, 1.0, 1.0]


def test_zero_over_zero_is_zero():
    f = Factor.from_values([GOAL], [0, 1, 2])
    assert (f / Factor.from_values([GOAL], [0, 1, 1])).values.tolist() == pytest.approx([0.0, 1.0, 2.0])


def test_dividing_by_zero_names_the_cell():
    f = Factor.from_values([GOAL, TRIAL], [[1, 1], [1, 1], [1, 1]])
    with pytest.raises(FactorError, match=r"goal='bowl', trial=0 \(and 1 other cell\)"):
        f / Factor.from_values([GOAL], [1, 0, 1])


def test_a_negative_power_of_zero_names_the_cell():
    with pytest.raises(FactorError, match="undefined, at goal='mug'"):
        Factor.from_values([GOAL], [1, 2, 0]) ** -1


@pytest.mark.parametrize("t", [math.nan, math.inf])
def test_powers_must_be_finite(t):
    with pytest.raises(FactorError, match="finite"):
        Factor.from_values([GOAL], [1, 2, 0]) ** t


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_nan_and_infinity_are_refused_by_cell(bad):
    with pytest.raises(FactorError, match=f"{bad} at goal='bowl', trial=1"):
        Factor([GOAL, TRIAL], [[0, 0], [0, bad], [0, 0]])
    with pytest.raises(FactorError, match=f"{bad} at goal='bowl'"):
        Factor.from_values([GOAL], [0, bad, 0])


def test_negative_values_are_refused_by_cell():
    with pytest.raises(FactorError, match=r"-1.0 at goal='mug'"):
        Factor.from_values([GOAL], [0, 1, -1])


def test_a_wrong_shape_is_refused_with_both_shapes():
    with pytest.raises(FactorError, match=r"shape \(2,\), but the axes \(goal 3\) call for \(3,\)"):
        Factor([GOAL], [0.0, 0.0])
    with pytest.raises(FactorError, match="real numbers"):
        Factor([GOAL], ["a", "b", "c"])
    with pytest.raises(FactorError, match="shape"):
        Factor.from_mask([GOAL], [True])


def test_a_mask_must_be_of_bools_or_an_indicator():
    f = Factor.from_values([GOAL], [1, 2, 3])
    with pytest.raises(FactorError, match="array of bool, not of int64"):
        f.where(np.array([1, 0, 1]))
    with pytest.raises(FactorError, match="neither at goal='bowl'"):
        f.where(f)


def test_axes_are_refused_where_unknown_repeated_or_named_alike():
    f = Factor.from_values([GOAL], [1, 2, 3])
    with pytest.raises(AxisError, match="no axis 'gaol' here; the axes are: goal"):
        f.sum("gaol")
    with pytest.raises(AxisError, match="named twice"):
        f.sum("goal", "goal")
    with pytest.raises(AxisError, match="two axes are called 'goal'"):
        Factor([GOAL, GOAL], np.zeros((3, 3)))
    with pytest.raises(AxisError, match="two axes are called 'goal'"):
        Factor([GOAL, TRIAL], np.zeros((3, 2))).rename(trial="goal")
    with pytest.raises(AxisError, match="at least one axis"):
        f.normalize()
    with pytest.raises(AxisError, match="goal would be lost"):
        f.align()


def test_normalising_names_the_first_cell_without_support():
    f = Factor.from_values([GOAL, TRIAL], [[1, 0], [1, 0], [1, 0]])
    with pytest.raises(ImpossibleEvidenceError, match="over goal is possible at trial=1"):
        f.normalize("goal")


def test_normalising_tells_the_kinds_of_axes_apart():
    p = Factor.from_values([GOAL, TRIAL, Axis("mood", 2)], np.ones((3, 2, 2))).normalize(
        "goal", batch=["trial"]
    )
    assert (p.random, p.conditions, p.batch) == (("goal",), ("mood",), ("trial",))


def test_factors_are_frozen_and_share_nothing_with_their_input():
    given_values = np.zeros(3)
    f = Factor([GOAL], given_values)
    given_values[0] = 1.0
    assert f.log_values[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        f.log_values[0] = 1.0
    with pytest.raises(AttributeError):
        f.axes = ()
    for derived in (f * f, f.sum("goal"), f.rename(goal="plan"), f.restrict(goal=["cup"]), f.align("goal")):
        assert not derived.log_values.flags.writeable
    with pytest.raises(TypeError):
        hash(f)


def test_a_factor_times_something_else_is_a_type_error():
    with pytest.raises(TypeError):
        Factor([GOAL], np.zeros(3)) * 2
    with pytest.raises(TypeError):
        np.zeros(3) * Factor([GOAL], np.zeros(3))


def test_equality_is_exact_and_allclose_has_a_tolerance_but_keeps_zeros_apart():
    f = Factor([GOAL], [0.0, -1.0, -math.inf])
    near = Factor([GOAL], [1e-13, -1.0, -math.inf])
    assert f != near
    assert f.allclose(near)
    assert not f.allclose(Factor([GOAL], [0.0, -1.0, -1e300]), atol=math.inf)
    assert not f.allclose(f.rename(goal="plan"))
    assert f != 3


def test_a_scalar_is_a_factor_without_axes():
    total = Factor.from_values([GOAL], [1, 2, 3]).sum()
    assert total.axes == ()
    assert total.values == pytest.approx(6.0)
    assert total * Factor.from_values([GOAL], [1, 2, 3]) == Factor.from_values([GOAL], [1, 2, 3]) * total


def test_xarray_labels_are_the_axes_labels():
    array = Factor([GOAL, TRIAL], np.zeros((3, 2))).to_xarray()
    assert array.sel(goal="mug").dims == ("trial",)
    assert "trial" not in array.coords
    array[0] = 5.0  # a copy, free to be changed


def test_xarray_that_no_axes_describe_is_refused():
    with pytest.raises(AxisError, match="repeated"):
        Factor.from_xarray(xr.DataArray([0.0, 0.0], dims="goal", coords={"goal": ["a", "a"]}))
    with pytest.raises(AxisError, match="identifier"):
        Factor.from_xarray(xr.DataArray([0.0, 0.0], dims="my goal"))


def test_html_is_small_escaped_and_elides_the_middle_of_long_axes():
    nasty = Axis("goal", ["<script>alert(1)</script>", "a&b"])
    page = Factor.from_values([nasty], [0.0, 2.0])._repr_html_()
    assert "<script>" not in page
    assert "&lt;script&gt;" in page
    assert "a&amp;b" in page
    long = Factor([Axis("sample", 100_000)], np.zeros(100_000))._repr_html_()
    assert "99988 more" in long
    assert len(long) < 5000
    assert "-inf" in Factor.from_mask([GOAL], [False] * 3)._repr_html_()


def test_reprs_say_the_axes_and_their_lengths():
    assert repr(Factor([GOAL, TRIAL], np.zeros((3, 2)))) == "Factor f(goal, trial): goal 3, trial 2"
    assert repr(Factor([], 0.0)) == "Factor f(): a scalar"


@pytest.mark.parametrize("exponent", [1e10, -1e10])
@pytest.mark.parametrize("value", [1e300, -1e300])
def test_a_power_that_leaves_the_range_of_floats_names_the_cell(exponent, value):
    factor = Factor([Axis("goal", ["cup", "bowl", "mug"])], [-math.inf if exponent > 0 else 0.0, 1.0, value])
    with pytest.raises(FactorError, match="goal='mug'"):
        factor**exponent
    assert ((factor**0.5 if exponent > 0 else factor**-1.0).log_values < math.inf).all()


def test_a_product_that_leaves_the_range_of_floats_warns_and_is_never_normalised():
    goal = Axis("goal", ["cup", "bowl"])
    factor = Factor([goal], [0.0, 1e308])
    with pytest.warns(RuntimeWarning, match="overflow"):
        product = factor * factor
    with pytest.raises(ImpossibleEvidenceError, match="infinite"):
        product.normalize("goal")
