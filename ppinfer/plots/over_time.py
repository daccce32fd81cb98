"""The posterior of one trial over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import FAINT, INK, MUTED, WARNING, goal_colour, goal_dashes, new_axes, quiet
from ppinfer.plots.trial_data import TrialData, read_trial

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_STRIP = -0.075
_STRIP_HEIGHT = 0.045


@draws_plain_text
def plot_posterior_over_time(posterior: xr.Dataset, trial: str | int, *, ax: Axes | None = None) -> Axes:
    """Draw each goal's probability over the time of a trial.

    A strip under the lines shows the segments in the colour of their true goal; ticks at the top mark
    samples that were not seen (grey) and outliers (red).

    Parameters
    ----------
    posterior
        A posterior, in memory or opened from a file; one trial of it is read.
    trial
        The trial's name or index.
    ax
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes drawn on; ``ax.figure.savefig(...)`` keeps the picture.

    Raises
    ------
    LogError
        If there is no such trial.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR
    >>> from ppinfer.studies import infer_log
    >>> from ppinfer.testing import example_log
    >>> ax = plot_posterior_over_time(infer_log(example_log(), GoalLQR()), 0)
    >>> ax.figure.savefig("posterior.png")
    """
    return draw_posterior_over_time(read_trial(posterior, trial), ax=ax)


@draws_plain_text
def draw_posterior_over_time(data: TrialData, *, ax: Axes | None = None) -> Axes:
    """Draw a trial that was already read; see `plot_posterior_over_time`."""
    from matplotlib.patches import Rectangle

    ax = ax if ax is not None else new_axes()
    for goal in data.shown_goals:
        absent = np.isnan(data.goal_position[:, goal]).any(axis=1) & (data.probability[:, goal] == 0)
        ax.plot(
            data.time,
            np.where(absent, np.nan, data.probability[:, goal]),
            color=goal_colour(goal),
            linestyle=goal_dashes(goal),
            linewidth=1.6,
            label=f"goal {data.goals[goal]}",
        )
    _draw_segments(data, ax)
    for which, colour, label in ((data.missing, MUTED, "not seen"), (data.outlier, WARNING, "outlier")):
        if which.any():
            ax.plot(
                data.time[which],
                np.full(int(which.sum()), 1.04),
                "|",
                color=colour,
                markersize=5,
                label=label,
            )
    ax.set_ylim(-0.11, 1.08)
    span = (float(data.time[0]), float(data.time[-1]))
    ax.set_xlim(span if span[1] > span[0] else (span[0] - 0.5, span[0] + 0.5))
    ax.set_yticks([0, 0.25, 0.5, 0.75, 1])
    ax.set_xlabel("time [s]")
    ax.set_ylabel("posterior probability")
    _plain(
        ax.set_title(f"trial {data.trial_id}, participant {data.participant}", fontsize="medium", loc="left")
    )
    handles, labels = ax.get_legend_handles_labels()
    if data.segments:
        handles.append(Rectangle((0, 0), 1, 1, color=MUTED, linewidth=0))
        labels.append("strip: true goal of a segment")
    legend = ax.legend(
        handles,
        labels,
        loc="upper left",
        bbox_to_anchor=(0, -0.17),
        ncols=min(6, len(labels)),
        frameon=False,
        fontsize="small",
        borderaxespad=0,
        handlelength=1.2,
        handletextpad=0.5,
        columnspacing=1.2,
    )
    for text in legend.get_texts():
        text.set_parse_math(False)
    quiet(ax)
    return ax


def _draw_segments(data: TrialData, ax: Axes) -> None:
    from matplotlib.patches import Rectangle

    for segment in data.segments:
        begin, end = float(data.time[segment.start]), float(data.time[segment.stop - 1])
        colour = goal_colour(segment.true_goal) if segment.true_goal >= 0 else FAINT
        ax.add_patch(
            Rectangle(
                (begin, _STRIP - _STRIP_HEIGHT / 2),
                end - begin,
                _STRIP_HEIGHT,
                color=colour,
                linewidth=0,
            )
        )
        ax.axvline(begin, color=INK, linewidth=0.5, alpha=0.25)


def _plain(text: object) -> None:
    # a label from a log may hold dollar signs: it is text, not mathematics
    text.set_parse_math(False)  # type: ignore[attr-defined]
