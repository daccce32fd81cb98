"""Do people change with practice? Means by round, and the slope over rounds (Figure 5 of the parallel-play paper)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ppinfer.studies.metrics.cells import Cells, refuse_many
from ppinfer.studies.metrics.grouping import UNKNOWN_ROUND
from ppinfer.studies.metrics.over_participants import LEVEL, cell_means, over_participants


@dataclass(frozen=True)
class RoundMean:
    """The mean of a metric in one round: over participants, each of them by its own mean; NaN for too few."""

    round: int
    mean: float
    sem: float
    participants: int


@dataclass(frozen=True)
class Learning:
    """How a metric changes over rounds in one group of trials.

    Parameters
    ----------
    group, metric : str
        Which trials, which metric.
    rounds : tuple of RoundMean
        The mean in every round.
    slope, sem : float
        Mean over participants of each one's least-squares slope, in the metric's units a round, and its standard error.
    t, df, p : float
        Student's t of the mean slope against 0, n - 1 degrees of freedom, two-sided p; NaN for one participant or where
        no slope is other than 0; infinite, and p 0, where all have the same other slope.
    low, high : float
        Student's interval of the mean slope.
    participants : int
        Those with a value in at least two rounds.
    """

    group: str
    metric: str
    rounds: tuple[RoundMean, ...]
    slope: float
    sem: float
    t: float
    df: int
    p: float
    low: float
    high: float
    participants: int


def slopes(
    values: Float[np.ndarray, " trial"],
    when: Float[np.ndarray, " trial"],
    cell: Int[np.ndarray, " trial"],
    cells: int,
) -> Float[np.ndarray, " cell"]:
    """Return the least-squares slope of each cell's values over time; NaN where its times do not differ.

    Examples
    --------
    >>> slopes(np.array([1.0, 3.0, 5.0, 7.0]), np.array([0.0, 1.0, 2.0, 0.0]), np.array([0, 0, 0, 1]), 2).tolist()
    [2.0, nan]
    """
    there = ~np.isnan(values) & ~np.isnan(when)
    value, time, which = values[there], when[there], cell[there]
    count = np.maximum(np.bincount(which, minlength=cells), 1)
    # about the means: no digits are lost to late rounds or to large values
    time = time - (np.bincount(which, weights=time, minlength=cells) / count)[which]
    value = value - (np.bincount(which, weights=value, minlength=cells) / count)[which]
    variation = np.bincount(which, weights=time * time, minlength=cells)
    product = np.bincount(which, weights=time * value, minlength=cells)
    slope: np.ndarray = np.divide(product, variation, out=np.full(cells, np.nan), where=variation > 0)
    return slope


def learning_of(
    group: str,
    metric: str,
    by_round: Float[np.ndarray, "participant round"],
    rounds: Int[np.ndarray, " round"],
    slope: Float[np.ndarray, " participant"],
    *,
    level: float = LEVEL,
    noise: float = 0.0,
) -> Learning:
    """Put together means by round and participants' slopes.

    Parameters
    ----------
    group, metric : str
        Which they are of.
    by_round : (participant, round) float64
        Each participant's mean in each round; NaN = none.
    rounds : (round,) int64
        What the rounds are called.
    slope : (participant,) float64
        Each participant's slope; NaN = none.
    level : float
        Probability of the interval.
    noise : float
        What rounding alone leaves of a slope that is zero in exact arithmetic.

    Examples
    --------
    >>> learned = learning_of("naive", "score", np.array([[1.0, 2.0], [1.0, 4.0]]), np.arange(2), np.array([1.0, 3.0]))
    >>> learned.slope, learned.sem, learned.t, round(learned.p, 3), [row.mean for row in learned.rounds]
    (2.0, 1.0, 2.0, 0.295, [1.0, 3.0])
    """
    from ppinfer.studies.statistics.student import student_tests

    means = over_participants(by_round, resamples=0)
    known = slope[~np.isnan(slope)]
    n = len(known)
    mean = float(known.mean()) if n else float("nan")
    sem = t = p = half = float("nan")
    if n > 1:
        tests = student_tests(known[:, None], noise=noise)
        mean, sem = float(tests.mean[0]), float(tests.sd[0]) / math.sqrt(n)
        t, p, half = float(tests.t[0]), float(tests.p[0]), float(tests.half_width(level)[0])
    rows = tuple(
        RoundMean(int(name), float(mean_then), float(sem_then), int(count))
        for name, mean_then, sem_then, count in zip(
            rounds, means.mean, means.sem, means.participants, strict=True
        )
        if count > 0
    )
    return Learning(group, metric, rows, mean, sem, t, max(n - 1, 0), p, mean - half, mean + half, n)


def learning_in_cells(
    names: Sequence[str],
    values: Float[np.ndarray, "trial metric"],
    cells: Cells,
    when: Int[np.ndarray, " trial"],
    *,
    level: float = LEVEL,
) -> list[Learning]:
    """Return how each metric changes over rounds in each group.

    Parameters
    ----------
    names : sequence of str
        Of the metrics.
    values : (trial, metric) float64
        NaN = undefined.
    cells : Cells
        The participant and the group of each trial.
    when : (trial,) int64
        The round of each trial; -1 = unknown, and left out.
    level : float
        Probability of the interval.

    Raises
    ------
    LogError
        If there are too many rounds.

    Examples
    --------
    >>> cells = Cells.of({"participant": np.array(["ann", "ann"])}, None)
    >>> learning_in_cells(["score"], np.array([[1.0], [4.0]]), cells, np.array([0, 1]))[0].slope
    3.0
    """
    known = when != UNKNOWN_ROUND
    time, cell = when[known].astype(np.float64), cells.cell[known]
    rounds, at = np.unique(when[known], return_inverse=True)
    refuse_many(rounds.size, "rounds have")
    shape = len(cells.people), len(cells.labels)
    told = []
    for metric, column in zip(names, values[known].T, strict=True):
        by_round, _ = cell_means(column, cell * rounds.size + at.reshape(-1), cells.size * rounds.size)
        table = by_round.reshape(*shape, rounds.size)
        slope = slopes(column, time, cell, cells.size).reshape(shape)
        noise = 16 * np.finfo(float).eps * float(np.abs(column[~np.isnan(column)]).max(initial=0.0))
        told += [
            learning_of(label, metric, table[:, index], rounds, slope[:, index], level=level, noise=noise)
            for index, label in enumerate(cells.labels)
        ]
    return told
