"""The metrics of every trial of a study, and what they come to by condition, between conditions and over rounds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float, Int, Shaped

from ppinfer.errors import LogError
from ppinfer.studies.metrics.cells import Cells
from ppinfer.studies.metrics.grouping import column_of
from ppinfer.studies.metrics.learning_effects import Learning, learning_in_cells
from ppinfer.studies.metrics.over_participants import LEVEL, RESAMPLES, cell_means
from ppinfer.studies.metrics.summaries import (
    GroupMean,
    MetricFacts,
    PairedDifference,
    group_means,
    paired_differences,
)

if TYPE_CHECKING:
    from ppinfer.studies.statistics.measures import RepeatedMeasures


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
        cells = Cells.of(self.columns, column)
        return group_means(self.names, self.values, cells, resamples=resamples, seed=seed, level=level)

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
        cells = Cells.of(self.columns, column)
        return paired_differences(self.names, self.values, cells, resamples=resamples, seed=seed, level=level)

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
        cells = Cells.of(self.columns, column)
        name = self.rounds_are(column, over)
        when = cells.order() if name == "order" else column_of(self.columns, name)
        if when.dtype.kind != "i":
            raise LogError(
                f"rounds are counted by whole numbers, and {name!r} is text; give another column, or 'order'"
            )
        return learning_in_cells(self.names, self.values, cells, when, level=level)

    def rounds_are(self, column: str | None = "condition", over: str | None = None) -> str:
        """Return what `learning` counts rounds by: a column's name, or ``"order"``."""
        return Cells.of(self.columns, column).rounds_are(self.round) if over is None else over

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
        # people and levels in the order of their names, whatever the order of trials and whoever lacks some
        found = [
            np.unique(column_of(self.columns, name), return_inverse=True)
            for name in ("participant", *factors)
        ]
        names = [tuple(map(str, labels)) for labels, _ in found]
        shape = tuple(map(len, names))
        cell = np.ravel_multi_index([codes.reshape(-1) for _, codes in found], shape)
        means, count = cell_means(self.values_of(metric), cell, math.prod(shape))
        several = int((count > 1).sum())
        note = f"{metric!r}: mean of several trials taken in {several} cells (up to {count.max()} trials)"
        return RepeatedMeasures(
            metric,
            means.reshape(shape),
            names[0],
            tuple(factors),
            tuple(names[1:]),
            source=str(self.provenance.get("log", "")),
            notes=(note,) if several else (),
        )

    def participant_means(
        self, metric: str, column: str | None = "condition"
    ) -> tuple[tuple[str, ...], tuple[str, ...], Float[np.ndarray, "participant group"]]:
        """Return participants, groups, and each participant's mean in each group; NaN where there is none.

        Raises
        ------
        LogError
            If there is no such metric or column.
        """
        cells = Cells.of(self.columns, column)
        return cells.people, cells.labels, cells.means(self.values_of(metric))[0]

    def facts(self, metric: str) -> MetricFacts:
        """Return what a metric is: its units and meaning.

        Raises
        ------
        LogError
            If there is no such metric here.
        """
        self.values_of(metric)
        return self.metrics[self.names.index(metric)]

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

        Differences between all pairs are left out, and said to be, where there are more than 12 groups.
        """
        from ppinfer.studies.metrics.faces import metrics_json

        return metrics_json(
            self,
            by,
            learning_by=learning_by,
            learning_over=learning_over,
            resamples=resamples,
            seed=seed,
            level=level,
        )

    def _repr_html_(self) -> str:
        """Show the mean of every metric as a small table; what comes from the log is text."""
        from ppinfer.studies.metrics.faces import metrics_html

        return metrics_html(self)
