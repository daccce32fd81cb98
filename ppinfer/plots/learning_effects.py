"""What changes with practice: metrics of trials against rounds (Figure 5 of the parallel-play paper)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.metric_panels import group_style, legend_below, metric_panels, name_axis, shown_metrics
from ppinfer.plots.palette import FAINT, quiet
from ppinfer.studies.metrics.trial_metrics import TrialMetrics

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# lines of several groups stand beside each other, so that their bars can be told apart
_APART = 0.16
_MOST_TICKS = 12


@draws_plain_text
def plot_learning_effects(
    metrics: TrialMetrics,
    names: Sequence[str] | None = None,
    *,
    by: str | None = "condition",
    over: str | None = None,
    axes: Sequence[Axes] | None = None,
) -> tuple[Axes, ...]:
    """Draw the mean of each metric in every round, one line a group, with standard errors over participants.

    Parameters
    ----------
    metrics : TrialMetrics
        The metrics of every trial.
    names : sequence of str, optional
        Which, in the order of the panels; by default up to four that say most.
    by, over
        What trials are grouped by and rounds counted by, as in `TrialMetrics.learning`.
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
    >>> axes = plot_learning_effects(trial_metrics(example_team_log()), ["stops", "score"])
    >>> [ax.get_ylabel() for ax in axes]
    ['stops', 'score']
    """
    shown = shown_metrics(metrics, names)
    drawn = metric_panels(len(shown), axes)
    learned = metrics.learning(by, over=over)
    counted = metrics.rounds_are(by, over)
    groups = list(dict.fromkeys(row.group for row in learned))
    handles = {}
    for ax, metric in zip(drawn, shown, strict=True):
        rows = [row for row in learned if row.metric == metric.name]
        for index, row in enumerate(rows):
            colour, marker = group_style(index)
            offset = _APART * (index / (len(groups) - 1) - 0.5) if len(groups) > 1 else 0.0
            at = np.array([one.round for one in row.rounds], np.float64) + offset
            mean, sem = (np.array([getattr(one, name) for one in row.rounds]) for name in ("mean", "sem"))
            line = ax.plot(at, mean, marker=marker, color=colour, linewidth=1.6, markersize=4.5)
            handles[row.group] = line[0]
            known = np.isfinite(sem)
            ax.vlines(
                at[known], (mean - sem)[known], (mean + sem)[known], color=colour, alpha=0.55, linewidth=2
            )
        rounds = sorted({one.round for row in rows for one in row.rounds})
        if len(rounds) <= _MOST_TICKS:
            ax.set_xticks(rounds)
        ax.set_xlabel("trial in order" if counted == "order" else counted).set_parse_math(False)
        name_axis(ax, metric)
        ax.grid(axis="y", color=FAINT, linewidth=0.5)
        ax.set_axisbelow(True)
        quiet(ax)
    legend_below(drawn[0], handles, "" if by is None else by)
    return tuple(drawn)
