"""How fast and how safe robots are beside a human: the paper's figures 4 and 6b."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

from ppinfer.errors import LogError
from ppinfer.plots.dot_rows import (
    MAIN_METRICS,
    METRIC_LABELS,
    align_seconds,
    draw_dot_rows,
    legend_above,
    metric_label,
    panels,
    series_by_plan_sets,
)
from ppinfer.plots.labels import draws_plain_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ppinfer.studies.task_performance import TaskPerformance

Whiskers = Literal["sem", "95%"]
# how many standard errors a whisker reaches to each side
_REACH = {"sem": 1.0, "95%": 1.959964}


@draws_plain_text
def plot_task_performance(
    performance: TaskPerformance,
    *,
    metrics: Sequence[str] = MAIN_METRICS,
    whiskers: Whiskers = "sem",
    axes: Sequence[Axes] | None = None,
) -> tuple[Axes, ...]:
    """Draw the mean of each metric for every robot, over all humans: one panel a metric, one row a robot.

    Parameters
    ----------
    performance
        The metrics of every trial (`ppinfer.studies.task_performance.task_performance`).
    metrics
        Which of `ppinfer.studies.task_performance.METRICS`, in the order of the panels; panels of seconds share
        one scale.
    whiskers
        One standard error to each side (``"sem"``), or the normal 95 % interval; robust to what trials of a scene
        have in common. With one scene there are none.
    axes
        One for each metric; a new figure by default.

    Returns
    -------
    tuple of matplotlib.axes.Axes
        The panels; where agents shared plans and also planned apart, each row has a dot for both.

    Raises
    ------
    LogError
        If a metric is unknown, there is no trial, or the number of axes is another.

    Examples
    --------
    >>> from ppinfer.studies.task_performance import task_performance
    >>> from ppinfer.testing.example_plays import example_planned_log
    >>> axes = plot_task_performance(task_performance(example_planned_log()))
    >>> axes[0].get_xlabel(), [label.get_text() for label in axes[0].get_yticklabels()]
    ('total time [s]', ['bayes'])
    """
    return _draw(performance.pooled(), "robot", metrics, whiskers, axes)


@draws_plain_text
def plot_against_personalities(
    performance: TaskPerformance,
    robot: str,
    *,
    metrics: Sequence[str] = MAIN_METRICS,
    whiskers: Whiskers = "sem",
    axes: Sequence[Axes] | None = None,
) -> tuple[Axes, ...]:
    """Draw the mean of each metric of one robot against each human.

    Parameters
    ----------
    performance
        The metrics of every trial.
    robot
        Whose; the paper's figure 6b is that of Bayes-Nash.
    metrics, whiskers, axes
        As in `plot_task_performance`.

    Returns
    -------
    tuple of matplotlib.axes.Axes
        The panels, one row a human.

    Raises
    ------
    LogError
        If there is no such robot, or as in `plot_task_performance`.

    Examples
    --------
    >>> from ppinfer.studies.task_performance import task_performance
    >>> from ppinfer.testing.example_plays import example_planned_log
    >>> axes = plot_against_personalities(task_performance(example_planned_log()), "bayes")
    >>> [label.get_text() for label in axes[0].get_yticklabels()]
    ['norm']
    """
    cells = performance.cells()
    rows = [row for row in cells if row["robot"] == robot]
    if not rows:
        known = dict.fromkeys(str(row["robot"]) for row in cells)
        raise LogError(f"there is no robot {robot!r}; there are {', '.join(known) or 'none'}")
    return _draw(rows, "human", metrics, whiskers, axes)


def _draw(
    rows: Sequence[Mapping[str, Any]],
    by: Literal["robot", "human"],
    metrics: Sequence[str],
    whiskers: Whiskers,
    axes: Sequence[Axes] | None,
) -> tuple[Axes, ...]:
    unknown = [metric for metric in metrics if metric not in METRIC_LABELS]
    if unknown or not metrics:
        raise LogError(
            f"{f'unknown metric {unknown[0]!r}' if unknown else 'no metric'}; name some of {', '.join(METRIC_LABELS)}"
        )
    if not rows:
        raise LogError("there is no trial to draw")
    names = list(dict.fromkeys(str(row[by]) for row in rows))
    drawn = panels(len(metrics), len(names), axes)
    for ax, metric in zip(drawn, metrics, strict=True):
        draw_dot_rows(
            ax, names, series_by_plan_sets(rows, names, by, metric, _REACH[whiskers]), named=ax is drawn[0]
        )
        ax.set_xlabel(metric_label(metric))
    drawn[0].set_ylabel(by)
    align_seconds(drawn, metrics)
    legend_above(drawn[0])
    return drawn
