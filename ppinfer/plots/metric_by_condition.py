"""Metrics by condition: every participant's own line, and the mean over participants with its interval."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.metric_panels import fitting, group_style, metric_panels, name_axis, shown_metrics
from ppinfer.plots.palette import FAINT, INK, MUTED, quiet
from ppinfer.studies.metrics.over_participants import RESAMPLES
from ppinfer.studies.metrics.trial_metrics import TrialMetrics

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# longer names, and more of them, stand aslant
_UPRIGHT = 26


@draws_plain_text
def plot_metric_by_condition(
    metrics: TrialMetrics,
    names: Sequence[str] | None = None,
    *,
    by: str = "condition",
    resamples: int = RESAMPLES,
    seed: int = 0,
    axes: Sequence[Axes] | None = None,
) -> tuple[Axes, ...]:
    """Draw each participant's mean in each group, joined by a line, and the mean over participants.

    Lines that rise or fall together say more than intervals that overlap: the comparison is within participants.

    Parameters
    ----------
    metrics : TrialMetrics
        The metrics of every trial.
    names : sequence of str, optional
        Which, in the order of the panels; by default up to four that say most.
    by : str
        What trials are grouped by.
    resamples, seed : int
        Of the bootstrap interval of the mean over participants.
    axes : sequence of matplotlib.axes.Axes, optional
        One for each metric; a new figure by default.

    Returns
    -------
    tuple of matplotlib.axes.Axes
        The panels.

    Raises
    ------
    LogError
        If there is no such metric or column, or the number of axes is another.

    Examples
    --------
    >>> from ppinfer.studies.metrics import trial_metrics
    >>> from ppinfer.testing.example_teams import example_team_log
    >>> axes = plot_metric_by_condition(trial_metrics(example_team_log()), ["score"])
    >>> [text.get_text() for text in axes[0].get_xticklabels()]
    ['c0', 'c1']
    """
    shown = shown_metrics(metrics, names)
    drawn = metric_panels(len(shown), axes)
    rows = metrics.by(by, resamples=resamples, seed=seed)
    for ax, metric in zip(drawn, shown, strict=True):
        _, labels, means = metrics.participant_means(metric.name, by)
        at = np.arange(len(labels), dtype=np.float64)
        # all participants in one call: a study has many
        ax.plot(at, means.T, color=MUTED, alpha=0.35, linewidth=0.9, marker=".", markersize=4, zorder=1)
        for index, row in enumerate(row for row in rows if row.metric == metric.name):
            colour, marker = group_style(index)
            if np.isfinite(row.low):
                ax.vlines(at[index], row.low, row.high, color=colour, linewidth=3, alpha=0.7, zorder=2)
            ax.plot(
                at[index], row.mean, marker, color=colour, markersize=8, markeredgecolor="white", zorder=3
            )
        aslant = sum(map(len, labels)) > _UPRIGHT
        for tick in ax.set_xticks(at, [fitting(label) for label in labels]):
            tick.label1.set_parse_math(False)
            if aslant:
                tick.label1.set(rotation=28, ha="right", rotation_mode="anchor")
        ax.set_xlim(-0.5, len(labels) - 0.5)
        ax.set_xlabel(by, color=INK).set_parse_math(False)
        name_axis(ax, metric)
        ax.grid(axis="y", color=FAINT, linewidth=0.5)
        ax.set_axisbelow(True)
        quiet(ax)
    return tuple(drawn)
