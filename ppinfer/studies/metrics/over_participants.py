"""Means over participants with their uncertainty: a participant's own mean first, then all participants alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ppinfer.studies.resampling import resampled_sums

RESAMPLES = 10_000
LEVEL = 0.95
# statistics that are resampled together, so that draws fit into memory
_TOGETHER = 64


@dataclass(frozen=True, eq=False)
class OverParticipants:
    """Some statistics over participants.

    Parameters
    ----------
    mean, sem : (statistic,) float64
        Over those participants that have a value, and its standard error s / sqrt(n); NaN for fewer than 1 and 2.
    low, high : (statistic,) float64
        The percentile interval of the mean, by drawing participants with replacement; NaN for fewer than 2.
    participants : (statistic,) int64
        How many have a value.
    """

    mean: Float[np.ndarray, " statistic"]
    sem: Float[np.ndarray, " statistic"]
    low: Float[np.ndarray, " statistic"]
    high: Float[np.ndarray, " statistic"]
    participants: Int[np.ndarray, " statistic"]


def cell_means(
    values: Float[np.ndarray, " trial"], cell: Int[np.ndarray, " trial"], cells: int
) -> tuple[Float[np.ndarray, " cell"], Int[np.ndarray, " cell"]]:
    """Return the mean of each cell over the trials that have a value, and how many these are.

    Examples
    --------
    >>> means, count = cell_means(np.array([1.0, 3.0, np.nan]), np.array([0, 0, 1]), 2)
    >>> means.tolist(), count.tolist()
    ([2.0, nan], [2, 0])
    """
    there = ~np.isnan(values)
    count = np.bincount(cell[there], minlength=cells)
    total = np.bincount(cell[there], weights=values[there], minlength=cells)
    return np.divide(total, count, out=np.full(cells, np.nan), where=count > 0), count


def over_participants(
    values: Float[np.ndarray, "participant statistic"],
    *,
    resamples: int = RESAMPLES,
    seed: int = 0,
    level: float = LEVEL,
) -> OverParticipants:
    """Return mean, standard error and bootstrap interval of each statistic over participants.

    Parameters
    ----------
    values : (participant, statistic) float64
        A value a participant; NaN where a participant has none.
    resamples, seed : int
        Of the bootstrap. The same participants are drawn for all statistics that the same participants have.
    level : float
        Probability of the interval.

    Examples
    --------
    >>> found = over_participants(np.array([[1.0], [3.0], [np.nan]]))
    >>> found.mean.tolist(), found.sem.tolist(), found.low.tolist(), found.participants.tolist()
    ([2.0], [1.0], [1.0], [2])
    """
    there = ~np.isnan(values)
    count = there.sum(axis=0)
    filled = np.where(there, values, 0.0)
    mean = np.divide(filled.sum(axis=0), count, out=np.full(count.shape, np.nan), where=count > 0)
    spread = np.where(there, values - mean, 0.0)
    many = count > 1
    variance = np.divide((spread**2).sum(axis=0), count - 1, out=np.full(count.shape, np.nan), where=many)
    sem = np.sqrt(variance / np.maximum(count, 1))
    low, high = np.full(count.shape, np.nan), np.full(count.shape, np.nan)
    patterns, pattern = np.unique(there.T, axis=0, return_inverse=True)
    pattern = pattern.reshape(-1)
    for index, who in enumerate(patterns):
        chosen = np.flatnonzero(pattern == index)
        if who.sum() < 2 or resamples < 1:
            continue
        for begin in range(0, chosen.size, _TOGETHER):
            some = chosen[begin : begin + _TOGETHER]
            draws = resampled_sums(
                values[np.ix_(who, some)].T, resamples=resamples, rng=np.random.default_rng(seed)
            )
            tail = (1.0 - level) / 2.0
            low[some], high[some] = np.quantile(draws / who.sum(), [tail, 1.0 - tail], axis=0)
    return OverParticipants(mean, sem, low, high, count)
