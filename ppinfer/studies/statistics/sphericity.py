"""Sphericity of an effect: Mauchly's test, and the epsilons that correct degrees of freedom."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class Sphericity:
    """How far an effect's contrasts are from equal variances and no correlation.

    Parameters
    ----------
    epsilon
        Greenhouse and Geisser's epsilon, in [1 / df1, 1]; 1 = spherical. NaN where nothing varies.
    epsilon_hf
        Huynh and Feldt's epsilon, at most 1.
    mauchly_w
        Mauchly's W, the likelihood ratio against sphericity; NaN where it is undefined (one contrast, or no more
        subjects than contrasts).
    mauchly_chi2, mauchly_df, mauchly_p
        Its chi-squared approximation, degrees of freedom and p-value.

    Examples
    --------
    >>> Sphericity(epsilon=1.0, epsilon_hf=1.0).mauchly_p
    nan
    """

    epsilon: float
    epsilon_hf: float
    mauchly_w: float = float("nan")
    mauchly_chi2: float = float("nan")
    mauchly_df: int = 0
    mauchly_p: float = float("nan")


def sphericity(scores: Float[np.ndarray, "subject contrast"]) -> Sphericity:
    r"""Judge sphericity from the scores on orthonormal contrasts.

    With :math:`S` their covariance, :math:`p` contrasts and :math:`n` subjects (Greenhouse & Geisser 1959; Huynh &
    Feldt 1976; Mauchly 1940 with Anderson's second-order approximation to the distribution),

    .. math:: \hat\epsilon = \frac{(\mathrm{tr} S)^2}{p\, \mathrm{tr} S^2}, \quad
        \tilde\epsilon = \min\Bigl(1, \frac{n p \hat\epsilon - 2}{p (n - 1 - p \hat\epsilon)}\Bigr), \quad
        W = \frac{\det S}{(\mathrm{tr} S / p)^p}.

    Parameters
    ----------
    scores
        As `effect_scores` returns them; at least 2 subjects.

    Examples
    --------
    >>> scores = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    >>> sphericity(scores).epsilon, sphericity(scores).mauchly_w
    (1.0, 1.0)
    """
    from scipy.stats import chi2

    n, p = scores.shape
    if p == 1:
        return Sphericity(1.0, 1.0)
    centred = scores - scores.mean(axis=0)
    # eigenvalues of the covariance by singular values: squaring first would lose half of the digits
    variances = np.linalg.svd(centred, compute_uv=False) ** 2 / (n - 1)
    variances = np.concatenate([variances, np.zeros(p - len(variances))])
    total = variances.sum()
    if total == 0:
        return Sphericity(float("nan"), float("nan"))
    shares = variances / total
    epsilon = float(np.clip(1 / (p * (shares**2).sum()), 1 / p, 1.0))
    room = n - 1 - p * epsilon
    # n - 1 <= p * epsilon (but for rounding): the estimate has no finite value below 1
    epsilon_hf = min(1.0, (n * p * epsilon - 2) / (p * room)) if room > 1e-9 * n else 1.0
    df = p * (p + 1) // 2 - 1
    if n - 1 < p:
        return Sphericity(epsilon, epsilon_hf, mauchly_df=df)
    # singular values are right to a few eps of the largest, and these are their squares
    if shares.min() <= (10 * n * np.finfo(float).eps) ** 2:
        return Sphericity(epsilon, epsilon_hf, 0.0, float("inf"), df, 0.0)
    log_w = min(0.0, float(np.log(p * shares).sum()))
    rho = 1 - (2 * p**2 + p + 2) / (6 * p * (n - 1))
    statistic = -(n - 1) * rho * log_w
    tail, tail_4 = (float(chi2.sf(statistic, df + more)) for more in (0, 4))
    second = (p + 2) * (p - 1) * (p - 2) * (2 * p**3 + 6 * p**2 + 3 * p + 2)
    weight = second / (288 * ((n - 1) * rho * p) ** 2)
    return Sphericity(
        epsilon,
        epsilon_hf,
        float(np.exp(log_w)),
        statistic,
        df,
        float(np.clip(tail + weight * (tail_4 - tail), 0.0, 1.0)),
    )
