"""Metrics of trials: what they come to in each condition, and how they change with practice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Bool

from ppinfer.plots.metric_panels import shown_metrics
from ppinfer.report.metric_figures import condition_figure, learning_figure
from ppinfer.report.parts import Draw, Part, sentence
from ppinfer.studies.metrics import TrialMetrics, trial_metrics
from ppinfer.studies.metrics.summaries import GroupMean

# what conditions may be called in a log, the first that there are several of
_GROUPS = ("condition", "robot_controller")
_MOST_ACROSS = 5


@dataclass(frozen=True, eq=False)
class Measured:
    """The metrics of the trials on a page, and what they are compared by.

    Attributes
    ----------
    metrics
        Of every trial.
    by
        The column of conditions; None where there is none.
    """

    metrics: TrialMetrics
    by: str | None

    @classmethod
    def of(cls, metrics: TrialMetrics) -> Measured:
        """Find what to compare by: the first column of conditions that has several, else the first that is there."""
        there = [name for name in _GROUPS if name in metrics.columns]
        several = [name for name in there if len(np.unique(metrics.columns[name].astype(str))) > 1]
        return cls(metrics, next(iter([*several, *there]), None))

    @cached_property
    def rows(self) -> list[GroupMean]:
        """The mean of every metric in every condition."""
        return self.metrics.by(self.by)

    def to_json(self) -> dict[str, Any]:
        """Return what ``ppinfer report --json`` says of metrics."""
        units = {each.name: each.units for each in self.metrics.metrics}
        return {
            "by": self.by,
            "groups": [{**asdict(row), "units": units[row.metric]} for row in self.rows],
        }


def measured_log(
    log: xr.Dataset,
    wanted: Bool[np.ndarray, " trial"],
    *,
    robot: str | None = None,
    human: str | None = None,
    more: TrialMetrics | None = None,
) -> Measured:
    """Measure the trials of a log that are wanted; ``more`` are further metrics of all of its trials."""
    metrics = trial_metrics(log, robot=robot, human=human)
    if more is not None:
        metrics = replace(
            metrics,
            values=np.concatenate([more.values, metrics.values], axis=1),
            metrics=(*more.metrics, *metrics.metrics),
        )
    return Measured.of(among(metrics, wanted))


def among(metrics: TrialMetrics, trials: Bool[np.ndarray, " trial"]) -> TrialMetrics:
    """Return the metrics of some trials, as far as they are defined in any of them."""
    values = metrics.values[trials]
    kept = np.flatnonzero(~np.isnan(values).all(axis=0)) if len(values) else np.arange(0)
    return replace(
        metrics,
        values=values[:, kept],
        metrics=tuple(metrics.metrics[at] for at in kept),
        columns={name: column[trials] for name, column in metrics.columns.items()},
    )


def metrics_parts(measured: Measured, *, drawn: Sequence[str] | None = None) -> list[Part]:
    """Return the table of metrics by condition, its figure, and what changes over rounds.

    Parameters
    ----------
    measured
        The metrics.
    drawn
        Which to draw; by default up to four that say most.
    """
    metrics = measured.metrics
    if not metrics.names:
        return [sentence("No metric of the trials is defined.")]
    rows = measured.rows
    groups = list(dict.fromkeys(row.group for row in rows))
    several = len(groups) > 1
    figures: list[Draw] = []
    if several:
        figures.append(partial(condition_figure, metrics, measured.by, drawn))
    return [
        Part(
            "sections/metrics.html.j2",
            {
                "metrics": metrics.metrics,
                "by": (measured.by or "").replace("_", " "),
                "groups": groups,
                "across": len(groups) <= _MOST_ACROSS,
                "cells": {(row.metric, row.group): row for row in rows},
                "people": len(np.unique(metrics.participant.astype(str))),
                "missing": sorted(metrics.not_available),
                "warnings": metrics.warnings,
                "meanings": [(each.name, each.meaning) for each in metrics.metrics],
                "several": several,
            },
            {"figures": figures},
        ),
        *_learning_parts(measured, drawn),
    ]


def _learning_parts(measured: Measured, drawn: Sequence[str] | None) -> list[Part]:
    metrics = measured.metrics
    rounds = metrics.round
    # the order of trials in a log alone is no order in time
    if (
        rounds is None
        or metrics.rounds_are(measured.by) != "round"
        or len(np.unique(rounds[rounds >= 0])) < 2
    ):
        return []
    shown = [each.name for each in shown_metrics(metrics, drawn)]
    learned = [row for row in metrics.learning(measured.by) if row.participants > 1 and row.metric in shown]
    if not learned:
        return []
    return [
        Part(
            "sections/learning.html.j2",
            {
                "rows": learned,
                "all": len(shown) == len(metrics.names),
                "by": (measured.by or "").replace("_", " "),
                "units": {each.name: each.units for each in metrics.metrics},
            },
            {"figures": [partial(learning_figure, metrics, measured.by, drawn)]},
        )
    ]
