"""Panels of metrics of trials: how many, of which metrics, and what their axes are called."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ppinfer.errors import LogError
from ppinfer.plots.labels import label
from ppinfer.plots.palette import GOAL_COLOURS, INK, MUTED
from ppinfer.studies.metrics.summaries import MetricFacts
from ppinfer.studies.metrics.trial_metrics import TrialMetrics

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

# what a reader wants to see first, as far as the log has it
_MAIN = (
    "total_s",
    "stops",
    "score",
    "collisions",
    "concurrent_share",
    "human_idle_share",
    "robot_idle_share",
)
_MOST = 4
_ACROSS = 4
_LONGEST = 32


def shown_metrics(metrics: TrialMetrics, names: Sequence[str] | None) -> list[MetricFacts]:
    """Return the metrics to draw: those asked for, else up to four that say most.

    Raises
    ------
    LogError
        If one that is asked for is not there.
    """
    main = [name for name in _MAIN if name in metrics.names][:_MOST]
    return [metrics.facts(name) for name in names or main or metrics.names[:_MOST]]


def metric_panels(
    count: int, axes: Sequence[Axes] | None, *, width: float = 3.0, height: float = 2.9
) -> list[Axes]:
    """Return a panel for each metric: those that are given, or those of a new figure, four in a row.

    Raises
    ------
    LogError
        If another number of axes is given.
    """
    if axes is None:
        from matplotlib.figure import Figure

        across = min(count, _ACROSS)
        down = math.ceil(count / across)
        figure = Figure(figsize=(max(4.0, width * across), height * down + 0.5), layout="constrained")
        drawn = list(figure.subplots(down, across, squeeze=False).ravel())
        for spare in drawn[count:]:
            spare.remove()
        return drawn[:count]
    if len(axes) != count:
        raise LogError(f"{count} panels are drawn; {len(axes)} axes were given")
    return list(axes)


def name_axis(ax: Axes, metric: MetricFacts) -> None:
    """Call the vertical axis as the metric, with its units."""
    words = metric.name.removesuffix("_s").removesuffix("_m").replace("_", " ")
    shown = label(f"{words} [{metric.units}]" if metric.units else words)
    ax.set_ylabel(shown, color=INK).set_parse_math(False)


def group_style(index: int) -> tuple[str, str]:
    """Return colour and marker of a group; together they repeat after 35 groups.

    Examples
    --------
    >>> group_style(0) == group_style(35), group_style(0) == group_style(7)
    (True, False)
    """
    markers = ("o", "s", "^", "D", "v")
    return GOAL_COLOURS[index % len(GOAL_COLOURS)], markers[index % len(markers)]


def fitting(name: str) -> str:
    """Return a group's name as it fits into a picture; an empty one is none.

    Examples
    --------
    >>> fitting("naive"), fitting("")
    ('naive', 'none')
    """
    return label(name, most=_LONGEST) or "none"


def legend_below(ax: Axes, handles: Mapping[str, Line2D], title: str) -> None:
    """Say below all panels which line is which group, where there is more than one."""
    if len(handles) < 2:
        return
    # named here: Matplotlib hides what is labelled with a leading underscore
    legend = ax.figure.legend(
        list(handles.values()),
        [fitting(name) for name in handles],
        title=label(title),
        loc="outside lower center",
        ncols=min(len(handles), _ACROSS),
        frameon=False,
        fontsize="small",
        title_fontsize="small",
        labelcolor=INK,
    )
    legend.get_title().set_color(MUTED)
    for text in (*legend.get_texts(), legend.get_title()):
        text.set_parse_math(False)
