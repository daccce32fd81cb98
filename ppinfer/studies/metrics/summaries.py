"""What metrics come to: what a metric is, its mean in a group of trials, its difference between two groups."""

from __future__ import annotations

from dataclasses import dataclass


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
