"""The paths of all agents of one trial."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.motion_data import read_motion
from ppinfer.plots.palette import FAINT, GOAL_COLOURS, new_axes, quiet
from ppinfer.plots.trial_data import trial_index

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MAX_NAMED = 12


@draws_plain_text
def plot_trial_paths(log: xr.Dataset, trial: str | int, *, ax: Axes | None = None) -> Axes:
    """Draw the paths of the agents of a trial in the plane, from open to full circle, with a dot each second.

    Of positions with one coordinate, it is drawn against time. Of a log that says where hands were, hands are drawn.

    Parameters
    ----------
    log
        A study log, in memory or opened from a file; one trial of it is read.
    trial
        The trial's name or index.
    ax
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes drawn on.

    Raises
    ------
    LogError
        If there is no such trial.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> ax = plot_trial_paths(example_log(), 0)
    >>> ax.get_xlabel()
    'x [m]'
    """
    motion = read_motion(log, np.array([trial_index(log, trial)]))
    planar = motion.position.shape[2] == 2
    ax = ax if ax is not None else new_axes(4.4, 4.0)
    seconds = np.r_[True, np.diff(np.floor(motion.time + 1e-9)) > 0]
    for index, agent in enumerate(motion.agents):
        here = motion.position[:, index]
        points = here if planar else np.column_stack([motion.time, here[:, 0]])
        seen = np.flatnonzero(~np.isnan(points).any(axis=1))
        colour = GOAL_COLOURS[index % len(GOAL_COLOURS)]
        ax.plot(*points.T, color=colour, linewidth=1.2, label=agent if index < _MAX_NAMED else "_")
        ax.plot(*points[seconds].T, ".", color=colour, ms=3.5)
        if len(seen):
            ax.plot(*points[seen[0]], "o", mfc="white", mec=colour, ms=6)
            ax.plot(*points[seen[-1]], "o", color=colour, ms=6)
    labels = motion.labels() if planar else ("time [s]", motion.labels()[0])
    ax.set_xlabel(labels[0], parse_math=False)
    ax.set_ylabel(labels[1], parse_math=False)
    if planar:
        ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.08)
    # a name that begins with an underscore is one too
    handles = [line for line in ax.get_lines() if line.get_label() in motion.agents]
    legend = ax.legend(handles, [str(line.get_label()) for line in handles], frameon=False, fontsize="small")
    for text in legend.get_texts():
        text.set_parse_math(False)
    ax.grid(color=FAINT, linewidth=0.4)
    ax.set_axisbelow(True)
    quiet(ax)
    return ax
