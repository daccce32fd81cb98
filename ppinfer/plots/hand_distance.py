"""How near two hands come through one trial, and where safety stops held them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from ppinfer.distributions.ragged import row_starts
from ppinfer.errors import LogError
from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import FAINT, INK, WARNING, new_axes, quiet
from ppinfer.plots.trial_data import trial_index

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@draws_plain_text
def plot_hand_distance(
    log: xr.Dataset,
    trial: str | int,
    *,
    robot: str = "robot",
    human: str = "human",
    ax: Axes | None = None,
) -> Axes:
    """Draw the distance between the hands of two agents over the time of a trial, safety stops in red.

    The line ends when the first of them is done and leaves.

    Parameters
    ----------
    log
        A study log with ``end_effector``; one trial of it is read.
    trial
        The trial's name or index.
    robot, human
        Which agents these are.
    ax
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes drawn on.

    Raises
    ------
    LogError
        If there is no such trial or agent, or the log does not say where hands are.

    Examples
    --------
    >>> from ppinfer.testing.example_plays import example_planned_log
    >>> ax = plot_hand_distance(example_planned_log(), 0)
    >>> ax.get_ylabel()
    'distance of hands [m]'
    """
    if "end_effector" not in log:
        raise LogError("the log has no end_effector: it does not say where hands are")
    agents = [str(agent) for agent in log["agent"].values]
    absent = [agent for agent in (robot, human) if agent not in agents]
    if absent:
        raise LogError(f"there is no agent {absent[0]!r} in the log; there are {', '.join(agents)}")
    index = trial_index(log, trial)
    first = int(row_starts(log["row_size"].values)[index])
    samples = slice(first, first + int(log["row_size"].values[index]))
    time, hand = log["time"][samples].values, log["end_effector"][samples].values
    apart = np.linalg.norm(hand[:, agents.index(robot)] - hand[:, agents.index(human)], axis=-1)
    held = log["held"][samples].values != 0 if "held" in log else np.zeros(len(time), dtype=bool)
    ax = ax if ax is not None else new_axes(6.4, 2.0)
    ax.plot(time, apart, color=INK, linewidth=1.4)
    if held.any():
        ax.plot(time[held], apart[held], "o", color=WARNING, markersize=3.5, label="safety stop")
        ax.legend(
            loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize="small", borderaxespad=0
        )
    ax.set_xlim(0, float(time[-1]) if time[-1] > 0 else 1.0)
    ax.set_ylim(bottom=0)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("distance of hands [m]")
    ax.grid(color=FAINT, linewidth=0.4)
    ax.set_axisbelow(True)
    quiet(ax)
    return ax
