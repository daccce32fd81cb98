"""Dots with whiskers in named rows, one panel a metric: how several robots, humans or differences compare."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float

from ppinfer.errors import LogError
from ppinfer.plots.palette import FAINT, INK, MUTED, quiet

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# what each metric is called, and its unit
METRIC_LABELS = {
    "total_s": ("total time", "s"),
    "robot_s": ("robot's time", "s"),
    "human_s": ("human's time", "s"),
    "stops": ("safety stops a trial", ""),
    "stop_episodes": ("episodes of stops a trial", ""),
    "failures": ("share of trials unfinished", ""),
}
MAIN_METRICS = ("total_s", "robot_s", "human_s", "stops")
# colour, marker and words for each way of sharing plans; blue and vermilion differ for every kind of sight
_SETS = {
    "shared": ("#0072B2", "o", "shared plan sets"),
    "independent": ("#D55E00", "s", "independent plan sets"),
}
_LONGEST_NAME = 26


@dataclass(frozen=True, eq=False)
class DotSeries:
    """One dot a row, from ``low`` to ``high``; NaN where there is none."""

    label: str
    colour: str
    marker: str
    value: Float[np.ndarray, " row"]
    low: Float[np.ndarray, " row"]
    high: Float[np.ndarray, " row"]


def metric_label(metric: str, *, less: str = "") -> str:
    """Return the words for an axis of a metric, or of its difference from that of somebody else.

    Examples
    --------
    >>> metric_label("total_s"), metric_label("stops", less="norm")
    ('total time [s]', "safety stops a trial, minus norm's")
    """
    words, unit = METRIC_LABELS[metric]
    if less:
        words += f", minus {shortened(less)}'s"
    return f"{words} [{unit}]" if unit else words


def series_by_plan_sets(
    rows: Sequence[Mapping[str, Any]], names: Sequence[str], by: str, metric: str, widen: float
) -> list[DotSeries]:
    """Return means with ``widen`` standard errors to each side, one series for each way of sharing plans."""
    found = []
    for plan_sets in dict.fromkeys(str(row["plan_sets"]) for row in rows):
        at = {str(row[by]): row for row in rows if str(row["plan_sets"]) == plan_sets}
        value = np.array([at[name][metric] if name in at else np.nan for name in names], np.float64)
        error = widen * np.array(
            [at[name][f"{metric}_sem"] if name in at else np.nan for name in names], np.float64
        )
        colour, marker, label = plan_set_style(plan_sets)
        found.append(DotSeries(label, colour, marker, value, value - error, value + error))
    return found


def plan_set_style(plan_sets: str) -> tuple[str, str, str]:
    """Return colour, marker and words of a way of sharing plans.

    Examples
    --------
    >>> plan_set_style("independent")[2]
    'independent plan sets'
    """
    return _SETS.get(plan_sets, (MUTED, "D", f"{plan_sets} plan sets" if plan_sets else "plan sets unknown"))


def draw_dot_rows(ax: Axes, names: Sequence[str], series: Sequence[DotSeries], *, named: bool) -> None:
    """Draw rows from top to bottom, series of a row beside each other; a dot without interval has no whisker."""
    height = np.arange(len(names), dtype=np.float64)
    for index, one in enumerate(series):
        offset = 0.0 if len(series) == 1 else 0.34 * (index / (len(series) - 1) - 0.5)
        drawn = np.isfinite(one.value)
        known = drawn & np.isfinite(one.low) & np.isfinite(one.high)
        ax.hlines(
            (height + offset)[known],
            one.low[known],
            one.high[known],
            color=one.colour,
            alpha=0.55,
            linewidth=2,
        )
        ax.plot(
            one.value[drawn],
            (height + offset)[drawn],
            one.marker,
            color=one.colour,
            markersize=5.5,
            label=one.label,
        )
    ax.set_ylim(len(names) - 0.5, -0.5)
    if named:
        for tick in ax.set_yticks(height, [shortened(name) for name in names]):
            tick.label1.set_parse_math(False)
    else:
        ax.set_yticks(height, [""] * len(names))
    ax.grid(axis="both", color=FAINT, linewidth=0.5)
    ax.set_axisbelow(True)
    quiet(ax)
    ax.tick_params(axis="y", length=0, labelsize="medium")


def align_seconds(axes: Sequence[Axes], metrics: Sequence[str]) -> None:
    """Give all panels of times one scale, and let counts begin at 0."""
    times = [ax for ax, metric in zip(axes, metrics, strict=True) if metric.endswith("_s")]
    if times:
        low, high = (pick(ax.get_xlim()[end] for ax in times) for end, pick in ((0, min), (1, max)))
        for ax in times:
            ax.set_xlim(low, high)
    for ax, metric in zip(axes, metrics, strict=True):
        if not metric.endswith("_s"):
            high = ax.get_xlim()[1] if ax.dataLim.x1 > 0 else 1.0
            # zero itself is drawn whole
            ax.set_xlim(-0.03 * high, high)
        ax.locator_params(axis="x", nbins=5)


def panels(count: int, rows: int, axes: Sequence[Axes] | None, *, width: float = 2.55) -> tuple[Axes, ...]:
    """Return panels side by side: those that are given, or those of a new figure as tall as the rows need."""
    if axes is None:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(1.3 + width * count, 1.5 + 0.36 * rows), layout="constrained")
        axes = tuple(figure.subplots(1, count, squeeze=False)[0])
    if len(axes) != count:
        raise LogError(f"{count} panels are drawn; {len(axes)} axes were given")
    return tuple(axes)


def legend_above(ax: Axes) -> None:
    """Say above the panels what the markers are, where there is more than one kind."""
    handles, labels = ax.get_legend_handles_labels()
    if len(labels) < 2:
        return
    legend = ax.legend(
        handles,
        labels,
        loc="lower left",
        bbox_to_anchor=(0, 1.0),
        ncols=len(labels),
        frameon=False,
        fontsize="small",
        borderaxespad=0,
        handletextpad=0.2,
        labelcolor=INK,
    )
    for text in legend.get_texts():
        text.set_parse_math(False)
    # wider than its panel, it would push the panels apart; an empty title keeps its height free
    legend.set_in_layout(False)
    ax.set_title(" ", fontsize="large")


def shortened(name: str) -> str:
    """Return a name that fits beside a picture; of a policy of one's own the end says most.

    Examples
    --------
    >>> shortened("norm"), shortened("my_project.policies.nice:VeryPolite")
    ('norm', '…t.policies.nice:VeryPolite')
    """
    return name if len(name) <= _LONGEST_NAME else "…" + name[-_LONGEST_NAME:]
