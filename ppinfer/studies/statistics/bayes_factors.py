r"""The Bayesian counterpart: JZS Bayes factors of within-subject effects, by one integral each.

Let :math:`z_i` be subject i's scores on the :math:`p` orthonormal contrasts of an effect (`effect_scores`). Subjects
have effects of their own under a flat prior, which leaves exactly these scores. Then

.. math:: z_i \sim N(\sigma\delta, \sigma^2 I), \quad p(\sigma^2) \propto 1/\sigma^2, \quad
    H_0: \delta = 0, \quad H_1: \delta \mid g \sim N(0, g I), \quad g \sim IG(1/2, r^2/2),

so :math:`\delta` is Cauchy (multivariate for :math:`p > 1`) of scale :math:`r`. Integrating :math:`\sigma^2` and
:math:`\delta` out, with :math:`q = SS_{effect} / SS_{error} = F\, df_1 / df_2` and :math:`N = df_1 + df_2 = n p`,

.. math:: BF_{10} = \int_0^\infty (1 + n g)^{-p/2}
    \Bigl[\frac{1 + q/(1 + n g)}{1 + q}\Bigr]^{-N/2} IG(g; 1/2, r^2/2)\, dg .

For two levels this is the JZS Bayes factor of the paired t-test (Rouder et al. 2009, equation 1, one sample), delta
being the mean difference over the standard deviation of the differences; for more it is that of Rouder et al. (2012)
for fixed effects, each effect against its own error term. Scores are taken to be spherical, as the uncorrected F does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ppinfer.errors import LogError

PRIOR_SCALE = math.sqrt(0.5)
"""The scale r of the standardised effect: the "medium" default of Bayesian t-tests, about 0.707."""

_NODES = 1001
_NEGLIGIBLE = 60.0


@dataclass(frozen=True)
class Mixture:
    """The quadrature over g: nodes u = log g, and the logarithm of the integrand (Jacobian included) at each.

    Examples
    --------
    >>> Mixture(np.array([0.0, 1.0]), np.zeros(2)).log_integral
    0.0
    """

    log_g: Float[np.ndarray, " node"]
    log_integrand: Float[np.ndarray, " node"]

    @property
    def log_integral(self) -> float:
        """Logarithm of the integral by the trapezoid rule (the integrand vanishes at both ends)."""
        top = self.log_integrand.max()
        return float(top + np.log(np.trapezoid(np.exp(self.log_integrand - top), self.log_g)))


def log_bayes_factor(
    F: float, df1: int, df2: int, *, subjects: int, prior_scale: float = PRIOR_SCALE
) -> float:
    """Return log BF10 of a within-subject effect: positive = the data speak for a difference.

    Parameters
    ----------
    F, df1, df2
        The effect's F value and degrees of freedom, uncorrected; for a paired t-test F = t ** 2 and df1 = 1.
    subjects
        How many subjects there are: df2 = df1 (subjects - 1).
    prior_scale
        The scale r of the Cauchy prior on the standardised effect.

    Returns
    -------
    float
        A natural logarithm; inf for an infinite F, NaN for an undefined one.

    Raises
    ------
    LogError
        If the prior scale is not positive and finite.

    Examples
    --------
    R's ``sleep`` data, paired: t(9) = 4.0621, BF10 = 17.259 (BayesFactor's manual).

    >>> round(float(np.exp(log_bayes_factor(4.062128**2, 1, 9, subjects=10))), 2)
    17.26
    """
    check_prior_scale(prior_scale)
    ratio = F * df1 / df2
    if not math.isfinite(ratio):
        return ratio
    return mixture(ratio, df1, subjects, prior_scale=prior_scale).log_integral


def mixture(ratio: float, contrasts: int, subjects: int, *, prior_scale: float = PRIOR_SCALE) -> Mixture:
    """Return the integrand of the Bayes factor on nodes that hold all but a share of about exp(-60) of it.

    Parameters
    ----------
    ratio
        Sum of squares of the effect over that of its error (q above), finite.
    contrasts, subjects
        p and n.
    prior_scale
        The scale r.

    Examples
    --------
    >>> round(float(np.exp(mixture(0.0, 1, 10).log_integral)), 4)
    0.3088
    """
    n, p, N = float(subjects), float(contrasts), float(subjects * contrasts)
    rate = prior_scale**2 / 2

    def log_integrand(u: Float[np.ndarray, " node"]) -> Float[np.ndarray, " node"]:
        # log(1 + n g) without overflow; `evidence` is log[(1 + q) / (1 + q / (1 + n g))], which ends at log(1 + q)
        widened = np.logaddexp(0.0, math.log(n) + u)
        evidence = math.log1p(ratio) - np.log1p(ratio * np.exp(-widened))
        prior = 0.5 * math.log(rate) - math.lgamma(0.5) - 0.5 * u - rate * np.exp(-u)
        return np.asarray(prior - 0.5 * p * widened + 0.5 * N * evidence)

    peak = math.log(max(rate, ratio / n, 1 / n))
    low, high = math.log(rate) - math.log(800.0), peak + 4 * _NEGLIGIBLE / (p + 1)
    u = np.linspace(low, high, _NODES)
    values = log_integrand(u)
    # twice, because with many subjects the peak is far narrower than where it may lie
    for _ in range(2):
        inside = np.flatnonzero(values > values.max() - _NEGLIGIBLE)
        u = np.linspace(u[max(inside[0] - 1, 0)], u[min(inside[-1] + 1, _NODES - 1)], _NODES)
        values = log_integrand(u)
    return Mixture(u, values)


def check_prior_scale(prior_scale: float) -> None:
    """Refuse a scale that no Cauchy distribution has.

    Examples
    --------
    >>> check_prior_scale(0.5)
    """
    if not 0 < prior_scale < math.inf:
        raise LogError(f"the prior scale is {prior_scale}; expected a positive number, such as 0.707")
