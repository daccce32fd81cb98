"""What differs between robots in the same scenes with the same humans."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ppinfer.errors import LogError
from ppinfer.plots.dot_rows import (
    DotSeries,
    draw_dot_rows,
    legend_above,
    metric_label,
    panels,
    plan_set_style,
)
from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@draws_plain_text
def plot_paired_differences(
    differences: Sequence[Mapping[str, Any]],
    against: str = "norm",
    *,
    metrics: Sequence[str] = ("total_s", "stops"),
    axes: Sequence[Axes] | None = None,
) -> tuple[Axes, ...]:
    """Draw each robot's paired difference from one robot, with its bootstrap interval.

    Left of the line at 0 a robot is faster, or stops less often, than the one it is compared with; an interval
    that is clear of the line says that this is hardly an accident of the scenes.

    Parameters
    ----------
    differences
        From `ppinfer.studies.task_performance.TaskPerformance.differences`.
    against
        The robot that the others are compared with.
    metrics
        Which, in the order of the panels.
    axes
        One for each metric; a new figure by default.

    Returns
    -------
    tuple of matplotlib.axes.Axes
        The panels.

    Raises
    ------
    LogError
        If nothing is compared with that robot by that metric, or the number of axes is another.

    Examples
    --------
    >>> rows = [
    ...     {"robot": "bayes", "against": "norm", "plan_sets": "shared", "metric": metric, "mean": -0.2, "low": -0.5,
    ...      "high": 0.1, "pairs": 30}
    ...     for metric in ("total_s", "stops")
    ... ]
    >>> [ax.get_xlabel().splitlines()[0] for ax in plot_paired_differences(rows)]
    ["total time, minus norm's [s]", "safety stops a trial, minus norm's"]
    """
    rows = [row for row in differences if row["against"] == against and row["metric"] in metrics]
    missing = [metric for metric in metrics if metric not in {row["metric"] for row in rows}]
    if missing or not metrics:
        known = dict.fromkeys(str(row["against"]) for row in differences)
        raise LogError(
            f"no difference in {missing[0] if missing else 'any metric'} from {against!r}; there are differences from "
            f"{', '.join(known) or 'no robot'}"
        )
    names = list(dict.fromkeys(str(row["robot"]) for row in rows))
    drawn = panels(len(metrics), len(names), axes, width=3.9)
    for ax, metric in zip(drawn, metrics, strict=True):
        ax.axvline(0.0, color=INK, linewidth=1)
        here = [row for row in rows if row["metric"] == metric]
        draw_dot_rows(ax, names, _series(here, names), named=ax is drawn[0])
        label = ax.set_xlabel(f"{metric_label(metric, less=against)}\n← less    more →")
        label.set_parse_math(False)
        ax.margins(x=0.08)
    drawn[0].set_ylabel("robot")
    legend_above(drawn[0])
    return drawn


def _series(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> list[DotSeries]:
    found = []
    for plan_sets in dict.fromkeys(str(row["plan_sets"]) for row in rows):
        at = {str(row["robot"]): row for row in rows if str(row["plan_sets"]) == plan_sets}
        mean, low, high = (
            np.array([at[name][field] if name in at else np.nan for name in names], np.float64)
            for field in ("mean", "low", "high")
        )
        colour, marker, label = plan_set_style(plan_sets)
        found.append(DotSeries(label, colour, marker, mean, low, high))
    return found
