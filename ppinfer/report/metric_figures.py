"""The figures of a report on metrics: by condition, and over rounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

from ppinfer.plots.learning_effects import plot_learning_effects
from ppinfer.plots.metric_by_condition import plot_metric_by_condition
from ppinfer.report.figures import ReportFigure, png_of
from ppinfer.studies.metrics import TrialMetrics

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def condition_figure(metrics: TrialMetrics, by: str | None, names: Sequence[str] | None) -> ReportFigure:
    """Draw each participant's mean in each condition, and the mean over participants."""
    axes = plot_metric_by_condition(metrics, names, by=by or "condition")
    return ReportFigure(
        name="metrics.png",
        png=png_of(cast("Figure", axes[0].figure)),
        title="Metrics by condition",
        caption=(
            "Grey lines are participants, each by the mean of its own trials; the large mark is their mean, with its "
            "95 % bootstrap interval over participants. Lines that rise or fall together say more than intervals that "
            "overlap."
        ),
    )


def learning_figure(metrics: TrialMetrics, by: str | None, names: Sequence[str] | None) -> ReportFigure:
    """Draw the mean of each metric in every round."""
    axes = plot_learning_effects(metrics, names, by=by)
    return ReportFigure(
        name="learning.png",
        png=png_of(cast("Figure", axes[0].figure)),
        title="Over rounds",
        caption="The mean over participants in each round; whiskers are one standard error to each side.",
    )
