import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import f as f_distribution
from scipy.stats import friedmanchisquare, ttest_rel

from ppinfer.errors import LogError
from ppinfer.studies.statistics import RepeatedMeasures, repeated_measures_anova
from ppinfer.studies.statistics.contrasts import effects_of

from .designs import ATTITUDES, BUSHTUCKER, SLEEP, TUTORS, design, whole_numbers
from .exact import exact_effects


def test_fields_bushtucker_comes_out_as_published():
    (effect,) = repeated_measures_anova(BUSHTUCKER)
    assert (effect.df1, effect.df2) == (3, 21)
    assert pytest.approx(3.79, abs=0.005) == effect.F
    assert effect.p == pytest.approx(0.026, abs=0.0005)
    assert effect.sphericity.epsilon == pytest.approx(0.533, abs=0.0005)
    assert effect.sphericity.epsilon_hf == pytest.approx(0.666, abs=0.0005)
    assert effect.p_gg == pytest.approx(0.063, abs=0.0005)
    assert effect.p_hf == pytest.approx(0.048, abs=0.0005)
    assert [mean["mean"] for mean in effect.means] == [8.125, 4.25, 4.125, 5.75]


def test_fields_tutors_come_out_as_published():
    (effect,) = repeated_measures_anova(TUTORS)
    told = (
        effect.F,
        effect.p,
        effect.sphericity.epsilon,
        effect.sphericity.epsilon_hf,
        effect.p_gg,
        effect.p_hf,
    )
    assert np.round(told, 3).tolist() == [3.700, 0.028, 0.558, 0.712, 0.063, 0.047]


def test_a_design_of_two_factors_comes_out_as_published():
    drink, imagery, both = repeated_measures_anova(ATTITUDES)
    assert [effect.effect for effect in (drink, imagery, both)] == ["drink", "imagery", "drink:imagery"]
    assert [(effect.df1, effect.df2) for effect in (drink, imagery, both)] == [(2, 38), (2, 38), (4, 76)]
    assert [round(effect.F, 2) for effect in (drink, imagery, both)] == [5.11, 122.56, 17.15]
    assert [round(effect.sphericity.epsilon, 3) for effect in (drink, imagery, both)] == [0.577, 0.747, 0.798]
    assert round(drink.p, 3) == 0.011
    assert round(drink.p_gg, 3) == 0.030
    assert [mean["level"] for mean in both.means][:2] == ["a0 : b0", "a0 : b1"]
    assert both.means[1]["levels"] == {"drink": "a0", "imagery": "b1"}


def test_two_levels_are_a_paired_t_test():
    (effect,) = repeated_measures_anova(SLEEP)
    test = ttest_rel(*SLEEP.values.T)
    assert pytest.approx(test.statistic**2, rel=1e-12) == effect.F
    assert effect.p == pytest.approx(test.pvalue, rel=1e-12)
    assert (effect.sphericity.epsilon, effect.p_gg, effect.p_hf) == (1.0, effect.p, effect.p)
    assert math.isnan(effect.sphericity.mauchly_w)
    assert math.isnan(effect.friedman_chi2)


@settings(max_examples=30)
@given(whole_numbers(factors=(1, 3), levels=(2, 3), subjects=(2, 5)))
def test_everything_agrees_with_rational_arithmetic(values):
    effects = repeated_measures_anova(design(values))
    exact = exact_effects(values)
    between = sum(ss for name, (_, _, ss, _) in exact.items())
    own = values.reshape(len(values), -1)
    people = own.shape[1] * float(((own.mean(axis=1) - own.mean()) ** 2).sum())
    assert len(effects) == len(exact) == len(list(effects_of(values.ndim - 1)))
    for effect, (ss, df1, error, df2) in zip(effects, exact.values(), strict=True):
        assert (effect.df1, effect.df2) == (df1, df2)
        if error:
            F = float((ss / df1) / (error / df2))
            assert pytest.approx(F, rel=1e-9, abs=1e-12) == effect.F
            assert effect.p == pytest.approx(f_distribution.sf(F, df1, df2), rel=1e-7)
        elif ss:
            assert (effect.F, effect.p) == (math.inf, 0.0)
            assert "exactly the same" in effect.warnings[0]
        else:
            assert math.isnan(effect.F)
            assert math.isnan(effect.p)
            assert "no subject differs" in effect.warnings[0]
        if ss or error:
            assert effect.partial_eta_squared == pytest.approx(float(ss / (ss + error)), abs=1e-9)
            whole = float(ss + between) + people
            assert effect.generalized_eta_squared == pytest.approx(float(ss) / whole, abs=1e-9)
        assert not [
            value for value in effect.to_json().values() if isinstance(value, float) and math.isnan(value)
        ]


@settings(max_examples=30)
@given(whole_numbers(subjects=(3, 7)), st.randoms(use_true_random=False))
def test_who_and_what_comes_first_changes_nothing(values, random):
    effects = repeated_measures_anova(design(values))
    people = random.sample(range(len(values)), len(values))
    shuffled = values[people]
    for axis in range(1, values.ndim):
        shuffled = shuffled.take(random.sample(range(values.shape[axis]), values.shape[axis]), axis=axis)
    _same(effects, repeated_measures_anova(design(shuffled)))


@settings(max_examples=30)
@given(
    whole_numbers(subjects=(3, 6)),
    st.integers(0, 2**32 - 1),
    st.sampled_from([1.0, 0.37, -2.5, 1e150, 1e-150]),
)
def test_a_persons_level_and_the_unit_change_nothing_within_people(values, seed, unit):
    shift = np.random.default_rng(seed).normal(size=(len(values),) + (1,) * (values.ndim - 1))
    _same(repeated_measures_anova(design(values)), repeated_measures_anova(design((values + shift) * unit)))


def _same(effects, others):
    for one, other in zip(effects, others, strict=True):
        if not math.isfinite(one.F):
            assert str(one.F) == str(other.F)
            continue
        assert pytest.approx(one.F, rel=1e-7, abs=1e-10) == other.F
        assert other.p_gg == pytest.approx(one.p_gg, rel=1e-6)
        assert other.p_hf == pytest.approx(one.p_hf, rel=1e-6)
        assert other.partial_eta_squared == pytest.approx(one.partial_eta_squared, abs=1e-9)
        assert other.log_bf10 == pytest.approx(one.log_bf10, rel=1e-6, abs=1e-8)


@settings(max_examples=30)
@given(whole_numbers(factors=(1, 1), levels=(2, 4), subjects=(3, 6)), st.integers(1, 3))
def test_means_of_repeated_rows_are_what_is_analysed(values, times):
    names, levels = np.indices(values.shape)
    rows = np.repeat(np.column_stack([names.ravel(), levels.ravel(), values.ravel()]), times, axis=0)
    rows[:, 2] += np.tile(np.arange(times) - 1 if times == 3 else np.zeros(times, int), values.size)
    subjects, factor = ([str(number) for number in rows[:, column]] for column in (0, 1))
    told = RepeatedMeasures.from_columns(
        "y", rows[:, 2].astype(float), subjects, {"x": factor}, repeated="mean"
    )
    assert (told.values == values).all()
    assert bool(told.notes) == (times > 1)


@pytest.mark.parametrize("shape", [(334, 3), (100, 3, 4)])
def test_large_tables_are_analysed_from_the_same_sums_of_squares(shape, monkeypatch):
    from ppinfer.studies.statistics import anova

    values = np.random.default_rng(3).normal(size=shape)
    large = repeated_measures_anova(design(values))
    monkeypatch.setattr(anova, "_REGRESSED", values.size)
    _same(large, repeated_measures_anova(design(values)))


def test_a_far_origin_costs_no_digits():
    near, far = (repeated_measures_anova(design(BUSHTUCKER.values + origin)) for origin in (0.0, 2.0**40))
    _same(near, far)


def test_an_effect_of_rounding_size_is_no_effect():
    values = np.array([[0.1 + 0.2, 0.3, 0.3], [0.3, 0.1 + 0.2, 0.3], [0.7, 0.7, 0.7]])
    (effect,) = repeated_measures_anova(design(values))
    assert math.isnan(effect.F)
    assert effect.to_json()["F"] is None
    assert effect.to_json()["bf10"] is None


def test_names_that_no_formula_can_hold_are_only_names():
    odd = design(ATTITUDES.values, dv="my dv ~ C(x)", factors=("C", "participant id + 1"))
    effects = repeated_measures_anova(odd)
    _same(repeated_measures_anova(ATTITUDES), effects)
    assert effects[2].effect == "C:participant id + 1"


def test_friedmans_test_is_scipys():
    (effect,) = repeated_measures_anova(BUSHTUCKER)
    chi2, p = friedmanchisquare(*BUSHTUCKER.values.T)
    assert (effect.friedman_chi2, effect.friedman_p) == (chi2, p)
    assert effect.kendall_w == pytest.approx(chi2 / 24)


def test_too_few_people_for_mauchly_is_said():
    (effect,) = repeated_measures_anova(design([[1, 2, 4, 3], [2, 5, 3, 3], [1, 1, 2, 5]]))
    assert effect.to_json()["mauchly_w"] is None
    assert effect.to_json()["mauchly_df"] == 5
    assert "too few for Mauchly" in effect.warnings[0]
    assert 1 / 3 <= effect.sphericity.epsilon <= 1


@pytest.mark.parametrize(
    ("values", "message"),
    [([[1.0, 2.0]], "number of subjects is 1"), ([[1.0], [2.0]], "too few levels: 1 .'a0'.")],
)
def test_what_cannot_be_analysed_is_refused(values, message):
    with pytest.raises(LogError, match=message):
        repeated_measures_anova(design(values))
