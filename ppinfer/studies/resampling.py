"""Uncertainty over participants: cluster-robust standard errors and the participant bootstrap."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

_MAX_CELLS = 1 << 22


def cluster_sums(
    values: Float[np.ndarray, "*statistic row"], cluster: Int[np.ndarray, " row"], n_clusters: int
) -> Float[np.ndarray, "*statistic cluster"]:
    """Add up values within clusters, along the last axis.

    Examples
    --------
    >>> cluster_sums(np.array([1.0, 2.0, 4.0]), np.array([0, 1, 0]), 2)
    array([5., 2.])
    """
    leading = values.shape[:-1]
    flat = values.reshape(-1, values.shape[-1])
    sums = np.stack([np.bincount(cluster, weights=row, minlength=n_clusters) for row in flat])
    return sums.reshape(*leading, n_clusters)


def mean_and_cluster_se(
    values: Float[np.ndarray, " row"], cluster: Int[np.ndarray, " row"], n_clusters: int
) -> tuple[float, float]:
    r"""Return the pooled mean and its standard error, robust to dependence within clusters.

    With :math:`N` values :math:`x_i` in :math:`G` clusters and :math:`\bar x` their mean,

    .. math:: SE^2 = \frac{G}{G - 1} \frac{1}{N^2} \sum_g \Bigl(\sum_{i \in g} (x_i - \bar x)\Bigr)^2,

    which is the plain :math:`s^2 / N` when every cluster holds one value.

    Parameters
    ----------
    values
        One number a row (segment); infinities make the mean infinite and the standard error NaN.
    cluster
        The cluster (participant) of each row, in ``range(n_clusters)``.
    n_clusters
        How many clusters there are; with fewer than 2 the standard error is NaN.

    Examples
    --------
    >>> mean, se = mean_and_cluster_se(np.array([0.0, 1.0, 1.0, 0.0]), np.arange(4), 4)
    >>> mean, round(se, 6)
    (0.5, 0.288675)
    """
    mean = float(values.mean()) if len(values) else float("nan")
    if n_clusters < 2 or not np.isfinite(mean):
        return mean, float("nan")
    sums = cluster_sums(values - mean, cluster, n_clusters)
    return mean, float(np.sqrt(n_clusters / (n_clusters - 1) * (sums**2).sum()) / len(values))


def resampled_sums(
    sums: Float[np.ndarray, "statistic cluster"], *, resamples: int, rng: np.random.Generator
) -> Float[np.ndarray, "resample statistic"]:
    """Draw clusters with replacement and add up their sums: the bootstrap of every statistic at once.

    Parameters
    ----------
    sums
        What each cluster contributes to each statistic.
    resamples
        How many times as many clusters as there are, are drawn.
    rng
        Where the draws come from.

    Returns
    -------
    array
        The sum of each statistic over the drawn clusters; a mean is the ratio of two of them.

    Examples
    --------
    >>> sums = np.array([[1.0, 3.0], [1.0, 1.0]])
    >>> draws = resampled_sums(sums, resamples=100, rng=np.random.default_rng(0))
    >>> sorted(set((draws[:, 0] / draws[:, 1]).tolist()))
    [1.0, 2.0, 3.0]
    """
    n_clusters = sums.shape[-1]
    out = np.empty((resamples, len(sums)))
    step = max(1, _MAX_CELLS // n_clusters)
    for start in range(0, resamples, step):
        size = min(step, resamples - start)
        times = rng.multinomial(n_clusters, np.full(n_clusters, 1 / n_clusters), size=size)
        out[start : start + size] = times @ sums.T
    return out
