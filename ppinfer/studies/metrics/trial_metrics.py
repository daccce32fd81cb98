"""The metrics of every trial of a study, and what they come to by condition, between conditions and over rounds."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float, Int, Shaped

from ppinfer.errors import LogError
from ppinfer.studies.metrics.grouping import FIRST, UNKNOWN_ROUND, column_of
from ppinfer.studies.metrics.learning_effects import Learning, learning_of, slopes
from ppinfer.studies.metrics.over_participants import (
    LEVEL,
    RESAMPLES,
    OverParticipants,
    cell_means,
    over_participants,
)

if TYPE_CHECKING:
    from ppinfer.studies.statistics.measures import RepeatedMeasures

ALL = "all trials"
MAX_GROUPS = 1000
# all pairs of more groups than these make a table that nobody reads
MAX_PAIRED = 12


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


@dataclass(frozen=True, eq=False)
class TrialMetrics:
    """Some metrics of every trial of a log; `ppinfer.studies.metrics.trial_metrics` makes it.

    All summaries are over participants, since trials of one person depend on one another: a participant's mean over its
    trials comes first, and every participant counts alike.

    Parameters
    ----------
    values : (trial, metric) float64
        NaN where a metric is undefined in a trial.
    metrics : tuple of MetricFacts
        Names, units and meanings.
    columns : mapping of str to (trial,) array
        What trials can be grouped by: text or whole numbers, ``trial_id`` and ``participant`` among them.
    not_available : mapping of str to str
        Metrics that this log cannot give, and why.
    warnings : tuple of str
        What a reader of the numbers has to know.
    provenance : mapping
        The log, its hash, options and version.

    Examples
    --------
    >>> from ppinfer.studies.metrics import trial_metrics
    >>> from ppinfer.testing import example_log
    >>> metrics = trial_metrics(example_log(participants=3, trials=2), names=["duration_s"])
    >>> metrics.values.shape, round(metrics.by("participant")[0].mean, 6)
    ((6, 1), 1.9)
    """

    values: Float[np.ndarray, "trial metric"]
    metrics: tuple[MetricFacts, ...]
    columns: Mapping[str, Shaped[np.ndarray, " trial"]]
    not_available: Mapping[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the metrics, in the order of the values' columns."""
        return tuple(metric.name for metric in self.metrics)

    @property
    def trial_id(self) -> Shaped[np.ndarray, " trial"]:
        """The name of each trial."""
        return self.columns["trial_id"]

    @property
    def participant(self) -> Shaped[np.ndarray, " trial"]:
        """Who took part in each trial."""
        return self.columns["participant"]

    @property
    def condition(self) -> Shaped[np.ndarray, " trial"] | None:
        """The condition of each trial, None where the log has none."""
        return self.columns.get("condition")

    @property
    def round(self) -> Int[np.ndarray, " trial"] | None:
        """The round of each trial, -1 = unknown; None where the log has none."""
        return self.columns.get("round")

    def values_of(self, metric: str) -> Float[np.ndarray, " trial"]:
        """Return one metric's value in every trial.

        Raises
        ------
        LogError
            If there is no such metric here; the message says why where that is known.
        """
        if metric in self.names:
            return self.values[:, self.names.index(metric)]
        if metric in self.not_available:
            raise LogError(f"this log cannot give the metric {metric!r}: {self.not_available[metric]}")
        raise LogError(f"there is no metric {metric!r}; there are {', '.join(self.names)}")

    def by(
        self,
        column: str | None = None,
        *,
        resamples: int = RESAMPLES,
        seed: int = 0,
        level: float = LEVEL,
    ) -> list[GroupMean]:
        """Return mean, standard error and bootstrap interval of every metric in every group of trials.

        1. Each participant's mean over its trials in the group that have a value.
        2. The mean of these means, their standard error, and the percentile interval by drawing participants.

        Parameters
        ----------
        column : str, optional
            What trials are grouped by; by default all are one group.
        resamples, seed : int
            Of the bootstrap.
        level : float
            Probability of the interval.

        Raises
        ------
        LogError
            If there is no such column, or it has too many values.
        """
        labels, group = self._groups(column)
        told = []
        for metric in self.names:
            means, count = self._cells(metric, group, len(labels))
            found = over_participants(means, resamples=resamples, seed=seed, level=level)
            told += [
                GroupMean(label, metric, *_numbers(found, at), int(count[:, at].sum()))
                for at, label in enumerate(labels)
            ]
        return told

    def differences(
        self,
        column: str = "condition",
        *,
        resamples: int = RESAMPLES,
        seed: int = 0,
        level: float = LEVEL,
    ) -> list[PairedDifference]:
        """Return the paired differences between all pairs of groups, over the participants that were in both.

        Pairs that no participant has in common are left out. The same participants are drawn for all pairs that the
        same participants have in common.

        Parameters
        ----------
        column, resamples, seed, level
            As in `by`.

        Raises
        ------
        LogError
            If there is no such column, or it has too many values.
        """
        labels, group = self._groups(column)
        pairs = list(itertools.combinations(range(len(labels)), 2))
        if not pairs:
            return []
        first, second = np.array(pairs).T
        told = []
        for metric in self.names:
            means, _ = self._cells(metric, group, len(labels))
            found = over_participants(
                means[:, first] - means[:, second], resamples=resamples, seed=seed, level=level
            )
            told += [
                PairedDifference(labels[a], labels[b], metric, *_numbers(found, at))
                for at, (a, b) in enumerate(pairs)
                if found.participants[at]
            ]
        return told

    def learning(
        self,
        column: str | None = "condition",
        *,
        over: str | None = None,
        level: float = LEVEL,
    ) -> list[Learning]:
        """Return how every metric changes over rounds, in every group of trials.

        Means by round, and each participant's least-squares slope over its trials; then their mean, standard error and
        Student's t against 0 over participants.

        Parameters
        ----------
        column : str, optional
            What trials are grouped by; None = all are one group.
        over : str, optional
            A column of whole numbers that rounds are counted by, or ``"order"``: the place of a trial among those of
            its participant and group, in the order of the log, from 0. By default ``round`` where the log has it
            and participants have several in a group, else ``order``; `rounds_are` says which.
        level : float
            Probability of the interval.

        Raises
        ------
        LogError
            If there is no such column, or ``over`` is no column of whole numbers.
        """
        people, person = self._people()
        labels, group = self._groups(column)
        when = self._when(person, group, len(labels), over)
        known = ~np.isnan(when)
        rounds, at = np.unique(when[known].astype(np.int64), return_inverse=True)
        if rounds.size > MAX_GROUPS:
            raise LogError(f"there are {rounds.size:,} rounds; at most {MAX_GROUPS:,} are compared")
        cell = person * len(labels) + group
        cells = len(people) * len(labels)
        told = []
        for metric in self.names:
            values = self.values_of(metric)
            by_round, _ = cell_means(
                values[known], cell[known] * max(rounds.size, 1) + at, cells * max(rounds.size, 1)
            )
            table = by_round.reshape(len(people), len(labels), max(rounds.size, 1))[..., : rounds.size]
            slope = slopes(values, when, cell, cells).reshape(len(people), len(labels))
            told += [
                learning_of(label, metric, table[:, index], rounds, slope[:, index], level=level)
                for index, label in enumerate(labels)
            ]
        return told

    def rounds_are(self, column: str | None = "condition", over: str | None = None) -> str:
        """Return what `learning` counts rounds by: a column's name, or ``"order"``."""
        _, person = self._people()
        labels, group = self._groups(column)
        return self._over(person, group, len(labels), over)

    def measures(self, metric: str, within: str | Sequence[str] = "condition") -> RepeatedMeasures:
        """Return participants' means by condition, as analyses of variance take them.

        Parameters
        ----------
        metric : str
            Which metric is the dependent variable.
        within : str or sequence of str
            The columns that are within-subject factors.

        Returns
        -------
        RepeatedMeasures
            A participant a row; NaN in cells without a value.

        Raises
        ------
        LogError
            If there is no such metric or column.
        """
        from ppinfer.studies.statistics.measures import RepeatedMeasures

        factors = [within] if isinstance(within, str) else list(within)
        values = self.values_of(metric)
        # people and levels in the order of their names, whatever the order of trials
        order = np.lexsort(
            [
                np.unique(self.columns["participant"], return_inverse=True)[1],
                *(
                    np.unique(column_of(self.columns, name), return_inverse=True)[1]
                    for name in reversed(factors)
                ),
            ]
        )
        return RepeatedMeasures.from_columns(
            metric,
            values[order],
            [str(name) for name in self.participant[order]],
            {name: [str(label) for label in self.columns[name][order]] for name in factors},
            repeated="mean",
            source=str(self.provenance.get("log", "")),
        )

    def table(self) -> dict[str, Shaped[np.ndarray, " trial"]]:
        """Return one row a trial as columns: ids, what trials can be grouped by, and the metrics."""
        metrics = {name: self.values[:, at] for at, name in enumerate(self.names)}
        return {name: column for name, column in self.columns.items() if name not in metrics} | metrics

    def to_json(
        self,
        by: str | None = None,
        *,
        learning_by: str | None = None,
        learning_over: str | None = None,
        resamples: int = RESAMPLES,
        seed: int = 0,
        level: float = LEVEL,
    ) -> dict[str, Any]:
        """Return everything as ``ppinfer metrics --json`` prints it; the parameters are those of the methods.

        Differences between all pairs are left out, and said to be, where there are more than `MAX_PAIRED` groups.
        """
        options: dict[str, Any] = {"resamples": resamples, "seed": seed, "level": level}
        warnings = list(self.warnings)
        paired = by is not None and len(self._groups(by)[0]) <= MAX_PAIRED
        if by is not None and not paired:
            warnings.append(
                f"{by!r} has more than {MAX_PAIRED} values: differences between pairs are left out"
            )
        learned = self.learning(learning_by, over=learning_over, level=level) if learning_by else []
        return {
            **self.provenance,
            "options": {
                **self.provenance.get("options", {}),
                **options,
                "learning_by": learning_by,
                "learning_over": self.rounds_are(learning_by, learning_over) if learning_by else None,
            },
            "by": by,
            "metrics": [asdict(metric) for metric in self.metrics],
            "not_available": dict(self.not_available),
            "trials": self._trials_json(),
            "groups": [asdict(row) for row in self.by(by, **options)],
            "differences": [asdict(row) for row in self.differences(by, **options)] if by and paired else [],
            "learning": [_listed(asdict(row)) for row in learned],
            "warnings": warnings,
        }

    def _repr_html_(self) -> str:
        """Show the mean of every metric as a small table; what comes from the log is text."""
        from html import escape

        rows = "".join(
            f"<tr><td>{escape(row.metric)}</td><td>{_shown(row.mean)}</td><td>{_shown(row.sem)}</td>"
            f"<td>{escape(metric.units)}</td><td>{row.trials}</td><td>{escape(metric.meaning)}</td></tr>"
            for row, metric in zip(self.by(resamples=0), self.metrics, strict=True)
        )
        people, _ = self._people()
        return (
            f"<p>{len(self.values)} trials of {len(people)} participants</p><table><thead><tr><th>metric</th>"
            "<th>mean</th><th>SEM</th><th>units</th><th>trials</th><th>meaning</th></tr></thead>"
            f"<tbody>{rows}</tbody></table>"
        )

    def _people(self) -> tuple[list[str], Int[np.ndarray, " trial"]]:
        names, person = np.unique(self.participant.astype(str), return_inverse=True)
        return names.tolist(), person.reshape(-1)

    def _groups(self, column: str | None) -> tuple[list[str], Int[np.ndarray, " trial"]]:
        if column is None:
            return [ALL], np.zeros(len(self.values), np.int64)
        labels, group = np.unique(column_of(self.columns, column), return_inverse=True)
        if labels.size > MAX_GROUPS:
            raise LogError(
                f"{column!r} has {labels.size:,} values, and at most {MAX_GROUPS:,} groups are compared; group by a "
                "column with fewer"
            )
        return [str(label) for label in labels], group.reshape(-1)

    def _cells(
        self, metric: str, group: Int[np.ndarray, " trial"], groups: int
    ) -> tuple[Float[np.ndarray, "participant group"], Int[np.ndarray, "participant group"]]:
        people, person = self._people()
        means, count = cell_means(self.values_of(metric), person * groups + group, len(people) * groups)
        return means.reshape(len(people), groups), count.reshape(len(people), groups)

    def _over(
        self,
        person: Int[np.ndarray, " trial"],
        group: Int[np.ndarray, " trial"],
        groups: int,
        over: str | None,
    ) -> str:
        if over is not None:
            return over
        rounds = self.round
        if rounds is None:
            return "order"
        known = rounds != UNKNOWN_ROUND
        cells = np.unique(np.stack([person * groups + group, rounds])[:, known], axis=1)
        # one round for each condition: what is learned within it shows in the order of trials
        several = cells.shape[1] > np.unique(cells[0]).size
        return "round" if several else "order"

    def _when(
        self,
        person: Int[np.ndarray, " trial"],
        group: Int[np.ndarray, " trial"],
        groups: int,
        over: str | None,
    ) -> Float[np.ndarray, " trial"]:
        name = self._over(person, group, groups, over)
        if name == "order":
            cell = person * groups + group
            order = np.argsort(cell, kind="stable")
            count = np.bincount(cell)
            place = np.empty(cell.size)
            place[order] = np.arange(cell.size) - np.repeat(np.cumsum(count) - count, count)
            return place
        values = column_of(self.columns, name)
        if values.dtype.kind != "i":
            raise LogError(
                f"rounds are counted by whole numbers, and {name!r} is text; give another column, or 'order'"
            )
        return np.where(values == UNKNOWN_ROUND, np.nan, values.astype(np.float64))

    def _trials_json(self) -> list[dict[str, Any]]:
        names = [name for name in FIRST if name in self.columns]
        ids = [self.columns[name].tolist() for name in names]
        return [
            {**dict(zip(names, told, strict=True)), "values": dict(zip(self.names, row, strict=True))}
            for *told, row in zip(*ids, self.values.tolist(), strict=True)
        ]


def _numbers(found: OverParticipants, at: int) -> tuple[float, float, float, float, int]:
    return (
        float(found.mean[at]),
        float(found.sem[at]),
        float(found.low[at]),
        float(found.high[at]),
        int(found.participants[at]),
    )


def _listed(row: dict[str, Any]) -> dict[str, Any]:
    return {**row, "rounds": list(row["rounds"])}


def _shown(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.4g}"
