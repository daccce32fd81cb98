r"""The posterior of a mean difference under the JZS alternative: how large it is, if there is one.

Given g, the mean difference mu = sigma delta of n differences with mean m and sum of squares S about it is
distributed as Student's t with n degrees of freedom,

.. math:: \mu \mid g \sim t_n\Bigl(\frac{n g}{1 + n g} m,\; \frac{S + n m^2 / (1 + n g)}{n (n + 1/g)}\Bigr)

(location and squared scale), and g is weighted by the integrand of the Bayes factor.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from ppinfer.studies.statistics.bayes_factors import PRIOR_SCALE, mixture

# of the nodes of the Bayes factor: quantiles need no more
_EVERY = 4


def credible_interval(
    differences: Float[np.ndarray, " subject"], *, level: float = 0.95, prior_scale: float = PRIOR_SCALE
) -> tuple[float, float]:
    """Return the central credible interval of the mean difference, given that there is one (H1).

    Parameters
    ----------
    differences
        One a subject, at least 2 that are not all equal, in the variable's units.
    level
        The probability inside.
    prior_scale
        The scale of the Cauchy prior on the standardised difference.

    Returns
    -------
    tuple
        Lower and upper end, a little nearer to zero than the confidence interval; NaN where nothing varies.

    Examples
    --------
    >>> low, high = credible_interval(np.array([-1.2, -2.4, -1.3, -1.3, 0.0, -1.0, -1.8, -0.8, -4.6, -1.4]))
    >>> round(low, 2), round(high, 2)
    (-2.29, -0.49)
    """
    from scipy.optimize import brentq
    from scipy.special import stdtr

    n = len(differences)
    mean = float(differences.mean())
    error = float(((differences - mean) ** 2).sum())
    if not error > 0 or not math.isfinite(n * mean**2 / error):
        return float("nan"), float("nan")
    nodes = mixture(n * mean**2 / error, 1, n, prior_scale=prior_scale)
    log_g, log_weight = nodes.log_g[::_EVERY], nodes.log_integrand[::_EVERY]
    weight = np.exp(log_weight - log_weight.max())
    weight /= weight.sum()
    log_widened = np.logaddexp(0.0, math.log(n) + log_g)
    widened = np.exp(log_widened)
    # n g / (1 + n g), which is not to be lost beside 1 where g is tiny
    shrunk = np.exp(math.log(n) + log_g - log_widened)
    location = shrunk * mean
    # n (n + 1/g) = n^2 (1 + n g) / (n g) = n^2 / shrunk
    scale = np.sqrt((error + n * mean**2 / widened) * shrunk) / n

    def below(value: float) -> float:
        return float(weight @ stdtr(n, (value - location) / scale))

    width = math.sqrt(error / n) + abs(mean)
    ends = []
    for tail in ((1 - level) / 2, (1 + level) / 2):
        reach = 4 * width
        while not below(-reach) < tail < below(reach):
            reach *= 4
        ends.append(
            float(
                brentq(
                    lambda value, tail=tail: below(value) - tail,
                    -reach,
                    reach,
                    xtol=1e-20 * width,
                    rtol=1e-10,
                )
            )
        )
    return ends[0], ends[1]
