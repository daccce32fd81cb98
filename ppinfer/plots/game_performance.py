"""How robots did with each human in the reaching game: points, collisions, and when they first scored."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ppinfer.errors import LogError
from ppinfer.plots.dot_rows import DotSeries, draw_dot_rows, panels, shortened
from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import GOAL_COLOURS, INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# what each metric is called on its axis
GAME_LABELS = {
    "score": "points a game",
    "collisions": "collisions a game",
    "first_score_s": "first score [s]",
    "human_goal_changes": "human's changes of goal",
    "robot_goal_changes": "robot's changes of goal",
    "scoreless": "share of games without score",
}
_MAIN = ("score", "collisions", "first_score_s")
_MARKERS = "osD^vP"


@draws_plain_text
def plot_game_performance(
    cells: Sequence[Mapping[str, Any]],
    *,
    metrics: Sequence[str] = _MAIN,
    axes: Sequence[Axes] | None = None,
) -> tuple[Axes, ...]:
    """Draw the mean of each metric for every robot, a dot for each human, with one standard error to each side.

    Parameters
    ----------
    cells
        From `ppinfer.studies.game_performance.GamePerformance.cells`.
    metrics
        Which of its metrics, in the order of the panels.
    axes
        One for each metric; a new figure by default.

    Returns
    -------
    tuple of matplotlib.axes.Axes
        The panels: one row a robot, or where numbers of goals differ, a robot with that many goals.

    Raises
    ------
    LogError
        If a metric is unknown, there is no game, or the number of axes is another.

    Examples
    --------
    >>> cells = [
    ...     {"robot": "naive", "human": "moving", **{name: 1.0 for name in GAME_LABELS},
    ...      **{f"{name}_sem": 0.1 for name in GAME_LABELS}}
    ... ]
    >>> [ax.get_xlabel() for ax in plot_game_performance(cells)]
    ['points a game', 'collisions a game', 'first score [s]']
    """
    unknown = [metric for metric in metrics if metric not in GAME_LABELS]
    if unknown or not metrics:
        raise LogError(
            f"{f'unknown metric {unknown[0]!r}' if unknown else 'no metric'}; name some of {', '.join(GAME_LABELS)}"
        )
    if not cells:
        raise LogError("there is no game to draw")
    named = [(_row_name(cell), cell) for cell in cells]
    names = list(dict.fromkeys(name for name, _ in named))
    humans = list(dict.fromkeys(str(cell["human"]) for cell in cells))
    drawn = panels(len(metrics), len(names), axes, width=2.9)
    for ax, metric in zip(drawn, metrics, strict=True):
        series = []
        for number, human in enumerate(humans):
            at = {name: cell for name, cell in named if str(cell["human"]) == human}
            mean, error = (
                np.array([at[name][field] if name in at else np.nan for name in names], np.float64)
                for field in (metric, f"{metric}_sem")
            )
            series.append(
                DotSeries(
                    f"{shortened(human)} human",
                    GOAL_COLOURS[1 + number % (len(GOAL_COLOURS) - 1)],
                    _MARKERS[number % len(_MARKERS)],
                    mean,
                    mean - error,
                    mean + error,
                )
            )
        draw_dot_rows(ax, names, series, named=ax is drawn[0])
        ax.set_xlabel(GAME_LABELS[metric])
    drawn[0].set_ylabel("robot")
    handles, labels = drawn[0].get_legend_handles_labels()
    legend = drawn[0].legend(
        handles, labels, loc="lower left", bbox_to_anchor=(0, 1.0), ncols=len(labels), frameon=False,
        fontsize="small", borderaxespad=0, handletextpad=0.2, labelcolor=INK,
    )  # fmt: skip
    for text in legend.get_texts():
        text.set_parse_math(False)
    # wider than its panel, it would push the panels apart; an empty title keeps its height free
    legend.set_in_layout(False)
    drawn[0].set_title(" ", fontsize="large")
    return drawn


def _row_name(cell: Mapping[str, Any]) -> str:
    return f"{cell['robot']}, {cell['goals']} goals" if "goals" in cell else str(cell["robot"])
