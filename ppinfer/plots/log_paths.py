"""All paths of a log at once, each agent in a panel of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from jaxtyping import Float

from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.motion_data import MotionData, read_motion
from ppinfer.plots.palette import AGENT_COLOURS, FAINT, INK, MUTED, quiet
from ppinfer.plots.workspace import halo

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MAX_AGENTS = 3
_MAX_PLACES = 12


@draws_plain_text
def plot_log_paths(log: xr.Dataset) -> tuple[Axes, ...]:
    """Draw the paths of all trials over one another, a panel for each of the first agents.

    Open circles are starts, diamonds are goals. Of positions with one coordinate, it is drawn against time.

    Parameters
    ----------
    log
        A study log, in memory or opened from a file. Of very long ones some trials are drawn, evenly spread.

    Returns
    -------
    tuple of matplotlib.axes.Axes
        One for each agent, three at most; ``axes[0].figure.savefig(...)`` keeps the picture.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> (ax,) = plot_log_paths(example_log())
    >>> ax.figure.savefig("paths.png")
    """
    from matplotlib.figure import Figure

    motion = read_motion(log)
    shown = motion.agents[:MAX_AGENTS]
    planar = motion.position.shape[2] == 2
    figure = Figure(figsize=(9.2, 4.2 if len(shown) < 3 else 3.4), layout="constrained")
    panels = figure.subplots(1, len(shown), squeeze=False)[0]
    for index, (agent, ax) in enumerate(zip(shown, panels, strict=True)):
        _draw(motion, index, ax, planar=planar)
        if planar and "goal_position" in log and "end_effector" not in log:
            _draw_goals(log, ax)
        title = ax.set_title(f"{agent}, {motion.trials:,} trials", fontsize="medium", loc="left")
        title.set_parse_math(False)
        labels = motion.labels() if planar else ("time [s]", motion.labels()[0])
        ax.set_xlabel(labels[0], parse_math=False)
        if not index:
            ax.set_ylabel(labels[1], parse_math=False)
        if planar:
            ax.set_aspect("equal", adjustable="datalim")
        ax.grid(color=FAINT, linewidth=0.4)
        ax.set_axisbelow(True)
        quiet(ax)
    return tuple(panels)


def _draw(motion: MotionData, agent: int, ax: Axes, *, planar: bool) -> None:
    here = motion.position[:, agent]
    # a gap between trials, so that all of them are one line
    ends = np.flatnonzero(np.diff(motion.trial)) + 1
    points: Float[np.ndarray, "point 2"] = here if planar else np.column_stack([motion.time, here[:, 0]])
    colour = AGENT_COLOURS[agent % len(AGENT_COLOURS)]
    alpha = float(np.clip(12 / motion.trials, 0.12, 0.8))
    ax.plot(*np.insert(points, ends, np.nan, axis=0).T, color=colour, alpha=alpha, linewidth=0.8)
    starts = points[np.r_[0, ends]]
    ax.plot(*starts.T, "o", mfc="white", mec=colour, mew=0.7, ms=3, linestyle="none")


def _draw_goals(log: xr.Dataset, ax: Axes) -> None:
    goals = [str(name) for name in log["goal"].values]
    where = log["goal_position"].values[..., :2]
    for index, name in enumerate(goals):
        places = np.unique(where[:, index], axis=0)
        places = places[~np.isnan(places).any(axis=1)]
        # names of goals that are elsewhere in every trial would cover each other
        few = len(places) == 1 and len(goals) <= _MAX_PLACES
        ax.plot(
            *places.T, "D", color=INK if few else MUTED, mec="white", ms=6 if few else 3, linestyle="none"
        )
        if few:
            for place in places:
                label = ax.annotate(
                    name,
                    tuple(place),
                    xytext=(5, 5),
                    textcoords="offset points",
                    fontsize="small",
                    color=INK,
                    parse_math=False,
                )
                label.set_path_effects(halo())
