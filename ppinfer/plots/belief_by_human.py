"""What robots believe about each human, through the trial."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ppinfer.errors import LogError
from ppinfer.plots.dot_rows import shortened
from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import FAINT, INK, MUTED, goal_colour, goal_dashes, quiet
from ppinfer.plots.replan_beliefs import SHARES, MeanBelief

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLUMNS = 3
_LONG_NAME = 14


@draws_plain_text
def plot_belief_by_human(
    beliefs: Sequence[MeanBelief], *, axes: Sequence[Axes] | None = None
) -> tuple[Axes, ...]:
    """Draw each robot's mean belief that the human favours itself, one line a human, through the trial.

    Bands are one standard error over trials. The number beside a human's name is the mean over whole trials.

    Parameters
    ----------
    beliefs
        From `ppinfer.plots.replan_beliefs.mean_beliefs`.
    axes
        One for each robot and way of sharing plans; a new figure by default.

    Returns
    -------
    tuple of matplotlib.axes.Axes
        The panels, in the order of the beliefs.

    Raises
    ------
    LogError
        If there is no belief, or the number of axes is another.

    Examples
    --------
    >>> from ppinfer.plots.replan_beliefs import mean_beliefs, read_beliefs
    >>> from ppinfer.testing.example_plays import example_planned_log
    >>> (ax,) = plot_belief_by_human(mean_beliefs(read_beliefs(example_planned_log())))
    >>> ax.get_title(loc="left")
    'bayes (shared plan sets)'
    """
    if not beliefs:
        raise LogError("there is no belief to draw")
    of_panel = list(dict.fromkeys((one.robot, one.plan_sets) for one in beliefs))
    humans = list(dict.fromkeys(one.human for one in beliefs))
    drawn = _grid(len(of_panel)) if axes is None else tuple(axes)
    if len(drawn) != len(of_panel):
        raise LogError(f"{len(of_panel)} panels are drawn; {len(drawn)} axes were given")
    for index, (ax, (robot, plan_sets)) in enumerate(zip(drawn, of_panel, strict=True)):
        ax.axhline(0.5, color=MUTED, linewidth=0.8, linestyle="--")
        for one in beliefs:
            if (one.robot, one.plan_sets) == (robot, plan_sets):
                _draw(ax, one, humans.index(one.human))
        title = f"{shortened(robot)} ({plan_sets} plan sets)" if plan_sets else shortened(robot)
        ax.set_title(title, fontsize="medium", loc="left").set_parse_math(False)
        ax.set_xlim(0, 100)
        ax.set_ylim(0, 1)
        ax.set_yticks([0, 0.25, 0.5, 0.75, 1])
        ax.grid(color=FAINT, linewidth=0.5)
        ax.set_axisbelow(True)
        ax.set_xlabel("share of the trial [%]")
        if axes is not None or index % _COLUMNS == 0:
            ax.set_ylabel(f"p({beliefs[0].label} favours itself)").set_parse_math(False)
        else:
            ax.tick_params(labelleft=False)
        legend = ax.legend(
            loc="upper left",
            bbox_to_anchor=(-0.06, -0.27),
            ncols=_legend_columns(humans),
            frameon=False,
            fontsize="small",
            borderaxespad=0,
            labelcolor=INK,
            handlelength=0.9,
            handletextpad=0.4,
            columnspacing=0.8,
        )
        for text in legend.get_texts():
            text.set_parse_math(False)
        quiet(ax)
    return drawn


def _draw(ax: Axes, one: MeanBelief, index: int) -> None:
    share, colour = 100 * SHARES, goal_colour(index)
    if np.isfinite(one.curve_sem).all():
        ax.fill_between(
            share,
            np.clip(one.curve - one.curve_sem, 0, 1),
            np.clip(one.curve + one.curve_sem, 0, 1),
            color=colour,
            alpha=0.18,
            linewidth=0,
        )
    ax.plot(
        share,
        one.curve,
        color=colour,
        linestyle=goal_dashes(index),
        linewidth=1.8,
        label=f"{shortened(one.human) or 'unknown'}: {one.mean:.2f}",
    )


def _legend_columns(humans: Sequence[str]) -> int:
    # three of the usual names are as wide as a panel
    if max(map(len, humans)) > _LONG_NAME:
        return 1
    return 3 if len(humans) <= 3 else 2


def _grid(count: int) -> tuple[Axes, ...]:
    from matplotlib.figure import Figure

    columns = min(count, _COLUMNS)
    rows = -(-count // columns)
    figure = Figure(figsize=(max(7.2, 0.8 + 3.1 * columns), 2.9 * rows), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False).ravel().tolist()
    for ax in grid[count:]:
        ax.remove()
    return tuple(grid[:count])
