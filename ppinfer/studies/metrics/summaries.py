"""What metrics come to: what a metric is, its mean in a group of trials, its difference between two groups."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ppinfer.studies.metrics.cells import Cells
from ppinfer.studies.metrics.over_participants import OverParticipants, over_participants


@dataclass(frozen=True)
class MetricFacts:
    """What a column of values is: the metric's name, the units in this log, and its meaning."""

    name: str
    units: str
    meaning: str


@dataclass(frozen=True)
class GroupMean:
    """A metric in one group of trials.

    Parameters
    ----------
    group, metric : str
        Which trials, which metric.
    mean, sem : float
        Mean over participants, each of them by the mean of its own trials, and its standard error; NaN for one.
    low, high : float
        Bootstrap interval of the mean over participants.
    participants, trials : int
        Those with a value.
    """

    group: str
    metric: str
    mean: float
    sem: float
    low: float
    high: float
    participants: int
    trials: int


@dataclass(frozen=True)
class PairedDifference:
    """How a metric differs between two groups, participant by participant: the mean of ``a`` minus ``b``.

    Parameters
    ----------
    a, b, metric : str
        Which groups, which metric.
    mean, sem : float
        Over the participants that have a value in both, of the difference of their means.
    low, high : float
        Bootstrap interval over these participants.
    participants : int
        How many they are.
    """

    a: str
    b: str
    metric: str
    mean: float
    sem: float
    low: float
    high: float
    participants: int


def group_means(
    names: Sequence[str],
    values: Float[np.ndarray, "trial metric"],
    cells: Cells,
    *,
    resamples: int,
    seed: int,
    level: float,
) -> list[GroupMean]:
    """Return the mean of every metric in every group (`TrialMetrics.by`).

    Examples
    --------
    >>> cells = Cells.of({"participant": np.array(["ann", "ann", "bob"])}, None)
    >>> found, = group_means(["m"], np.array([[1.0], [3.0], [4.0]]), cells, resamples=100, seed=0, level=0.95)
    >>> found.mean, found.sem, found.participants, found.trials
    (3.0, 1.0, 2, 3)
    """
    means, count = _means_in_cells(values, cells)
    # all at once: the same participants are drawn for all that the same participants have
    found = over_participants(means, resamples=resamples, seed=seed, level=level)
    rows = itertools.product(names, cells.labels)
    return [
        GroupMean(label, metric, *_numbers(found, at), int(count[:, at].sum()))
        for at, (metric, label) in enumerate(rows)
    ]


def paired_differences(
    names: Sequence[str],
    values: Float[np.ndarray, "trial metric"],
    cells: Cells,
    *,
    resamples: int,
    seed: int,
    level: float,
) -> list[PairedDifference]:
    """Return how every metric differs between all pairs of groups (`TrialMetrics.differences`).

    Examples
    --------
    >>> columns = {"participant": np.array(["ann", "ann", "bob", "bob"]), "robot": np.array(["a", "b", "a", "b"])}
    >>> values = np.array([[3.0], [1.0], [8.0], [4.0]])
    >>> cells = Cells.of(columns, "robot")
    >>> found, = paired_differences(["m"], values, cells, resamples=100, seed=0, level=0.95)
    >>> found.a, found.b, found.mean, found.sem
    ('a', 'b', 3.0, 1.0)
    """
    labels = cells.labels
    pairs = list(itertools.combinations(range(len(labels)), 2))
    if not pairs:
        return []
    first, second = np.array(pairs).T
    means = _means_in_cells(values, cells)[0].reshape(len(cells.people), len(names), len(labels))
    differences = (means[..., first] - means[..., second]).reshape(len(cells.people), -1)
    found = over_participants(differences, resamples=resamples, seed=seed, level=level)
    rows = itertools.product(names, pairs)
    return [
        PairedDifference(labels[a], labels[b], metric, *_numbers(found, at))
        for at, (metric, (a, b)) in enumerate(rows)
        if found.participants[at]
    ]


def _means_in_cells(
    values: Float[np.ndarray, "trial metric"], cells: Cells
) -> tuple[Float[np.ndarray, "participant statistic"], Int[np.ndarray, "participant statistic"]]:
    """Return each participant's mean of each metric in each group, and of how many trials it is."""
    found = [cells.means(column) for column in values.T]
    nothing = np.empty((len(cells.people), 0))
    return (
        np.concatenate([nothing, *(means for means, _ in found)], axis=1),
        np.concatenate([nothing.astype(np.int64), *(count for _, count in found)], axis=1),
    )


def _numbers(found: OverParticipants, at: int) -> tuple[float, float, float, float, int]:
    return (
        float(found.mean[at]),
        float(found.sem[at]),
        float(found.low[at]),
        float(found.high[at]),
        int(found.participants[at]),
    )
