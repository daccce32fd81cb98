import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import logsumexp
from scipy.stats import cauchy, multivariate_t, t

from ppinfer.errors import LogError
from ppinfer.studies.statistics import credible_interval, log_bayes_factor, repeated_measures_anova
from ppinfer.studies.statistics.contrasts import effect_scores

from .designs import BUSHTUCKER, SLEEP, design


def bf10(*args, **options):
    return math.exp(log_bayes_factor(*args, **options))


def test_the_sleep_data_come_out_as_bayesfactor_publishes():
    (effect,) = repeated_measures_anova(SLEEP)
    assert math.exp(effect.log_bf10) == pytest.approx(17.259, abs=0.0005)


def test_the_example_of_rouder_and_others_comes_out_as_published():
    # 2009, p. 234: t = 2.03, N = 80, r = 1: odds of 1.56 for the null
    assert 1 / bf10(2.03**2, 1, 79, subjects=80, prior_scale=1.0) == pytest.approx(1.56, abs=0.005)


@pytest.mark.parametrize(("statistic", "n", "r"), [(0.0, 5, 0.5), (2.1, 12, math.sqrt(0.5)), (-9.0, 30, 1.0)])
def test_two_levels_are_the_noncentral_t_averaged_over_a_cauchy_prior(statistic, n, r):
    from scipy.stats import nct

    def integrand(delta):
        return nct.pdf(statistic, n - 1, delta * math.sqrt(n)) * cauchy.pdf(delta, scale=r)

    top = statistic / math.sqrt(n)
    over = sum(
        quad(integrand, a, b, limit=200)[0] for a, b in ((-6, top - 1), (top - 1, top + 1), (top + 1, 6))
    )
    assert bf10(statistic**2, 1, n - 1, subjects=n, prior_scale=r) == pytest.approx(
        over / t.pdf(statistic, n - 1), rel=1e-4
    )


@pytest.mark.parametrize("values", [BUSHTUCKER.values[:, :3], [[1, 2, 4], [2, 2, 3], [1, 5, 4], [0, 1, 3]]])
def test_three_levels_are_a_brute_force_marginal_likelihood(values):
    measures = design(values)
    z = effect_scores(measures.values, (0,))
    n, p = z.shape
    prior = multivariate_t(loc=np.zeros(p), shape=0.5 * np.eye(p), df=1)
    axis = np.linspace(-7, 7, 141)
    delta = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, p)
    u = np.linspace(-4.0, 6.0, 401)

    def log_likelihood(delta):
        """Return log of the integral over u = log sigma of prod_i N(z_i; sigma delta, sigma^2 I)."""
        exponent = (
            (z**2).sum() * np.exp(-2 * u)
            - 2 * (delta @ z.sum(axis=0))[:, None] * np.exp(-u)
            + n * (delta**2).sum(axis=1)[:, None]
        )
        return logsumexp(-n * p * u - exponent / 2, axis=1)

    null = log_likelihood(np.zeros((1, p)))[0]
    brute = (np.exp(log_likelihood(delta) - null) * prior.pdf(delta)).sum() * (axis[1] - axis[0]) ** 2
    (effect,) = repeated_measures_anova(measures)
    assert math.exp(effect.log_bf10) == pytest.approx(brute, rel=1e-3)


@given(st.floats(0, 1e4), st.integers(1, 8), st.integers(2, 300), st.floats(0.05, 20))
def test_the_quadrature_agrees_with_scipys(F, df1, n, r):
    df2 = df1 * (n - 1)
    q, N = F * df1 / df2, df1 + df2
    log_value = log_bayes_factor(F, df1, df2, subjects=n, prior_scale=r)

    def integrand(u):
        widened = np.log1p(n * np.exp(u))
        evidence = np.log1p(q) - np.log1p(q * np.exp(-widened))
        prior = math.log(r / math.sqrt(2 * math.pi)) - u / 2 - r**2 / 2 * np.exp(-u)
        return np.exp(prior - df1 / 2 * widened + N / 2 * evidence - log_value)

    # pieces, because quad may step over a peak
    edges = np.linspace(-14, 50, 65)
    whole = sum(quad(integrand, *ends)[0] for ends in itertools.pairwise(edges))
    assert whole == pytest.approx(1.0, rel=1e-6)


@settings(max_examples=30)
@given(st.integers(1, 8), st.integers(2, 200), st.floats(0.1, 3))
def test_more_evidence_is_a_larger_factor_and_none_speaks_for_none(df1, n, r):
    F = np.concatenate([[0.0], np.geomspace(1e-3, 1e6, 10)])
    found = [log_bayes_factor(f, df1, df1 * (n - 1), subjects=n, prior_scale=r) for f in F]
    assert (np.diff(found) > 0).all()
    assert found[0] < 0


@pytest.mark.parametrize(("F", "n"), [(1e300, 21), (1e4, 10**7), (0.5, 10**9), (1e-300, 3), (1e12, 10**6)])
@pytest.mark.parametrize("r", [1e-6, 0.707, 1e6])
def test_extremes_stay_finite(F, n, r):
    assert math.isfinite(log_bayes_factor(F, 2, 2 * (n - 1), subjects=n, prior_scale=r))


def test_what_is_infinite_or_undefined_stays_so():
    assert log_bayes_factor(math.inf, 2, 40, subjects=21) == math.inf
    assert math.isnan(log_bayes_factor(math.nan, 2, 40, subjects=21))


@pytest.mark.parametrize("r", [0.0, -1.0, math.nan, math.inf])
def test_a_prior_scale_is_positive(r):
    with pytest.raises(LogError, match="expected a positive number"):
        log_bayes_factor(3.0, 2, 40, subjects=21, prior_scale=r)


@pytest.mark.parametrize("r", [0.2, math.sqrt(0.5), 2.0])
def test_the_credible_interval_is_that_of_a_grid_over_mean_and_deviation(r):
    differences = SLEEP.values[:, 1] - SLEEP.values[:, 0]
    n, mean = len(differences), differences.mean()
    mu, sigma = np.linspace(-6, 9, 3001)[:, None], np.exp(np.linspace(np.log(0.2), np.log(15), 500))
    squares = ((differences - mean) ** 2).sum() + n * (mean - mu) ** 2
    # p(sigma) = 1/sigma cancels against the step of the grid; the prior of mu given sigma brings another 1/sigma
    density = np.exp(-n * np.log(sigma) - squares / (2 * sigma**2)) * cauchy.pdf(mu / sigma, scale=r) / sigma
    cumulated = np.cumsum(density.sum(axis=1))
    brute = np.interp([0.025, 0.975], cumulated / cumulated[-1], mu[:, 0])
    assert credible_interval(differences, prior_scale=r) == pytest.approx(brute, abs=0.01)


@settings(max_examples=30)
@given(st.integers(2, 30), st.integers(0, 2**32 - 1), st.sampled_from([1.0, 1e-9, 1e9]))
def test_the_credible_interval_holds_the_shrunken_mean_and_scales_with_the_unit(n, seed, unit):
    differences = np.random.default_rng(seed).normal(1.0, 1.0, size=n)
    low, high = credible_interval(differences)
    assert low < differences.mean() < high
    assert credible_interval(unit * differences) == pytest.approx((unit * low, unit * high), rel=1e-6)
    assert credible_interval(-differences) == pytest.approx((-high, -low), rel=1e-6, abs=1e-8)


def test_the_narrower_the_prior_the_nearer_to_zero_is_the_credible_interval():
    differences = SLEEP.values[:, 1] - SLEEP.values[:, 0]
    ends = np.array([credible_interval(differences, prior_scale=r) for r in (1e-12, 1e-9, 1e-6)])
    # so far below the data, nothing but the prior says how large a difference is
    np.testing.assert_allclose(ends[1:] / ends[:-1], 1e3, rtol=0.01)
