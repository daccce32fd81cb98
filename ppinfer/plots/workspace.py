"""The plane that agents and goals share, as it is drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, Int

from ppinfer.plots.palette import (
    FAINT,
    HUMAN_COLOUR,
    INK,
    MUTED,
    ROBOT_COLOUR,
    goal_colour_among_agents,
    quiet,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ppinfer.studies.interaction import Interaction


def draw_goals(ax: Axes, places: Float[np.ndarray, "goal 2"], labels: tuple[str, ...]) -> None:
    """Draw goals as diamonds in their colours, with their labels; NaN is absent.

    Examples
    --------
    >>> from ppinfer.plots.palette import new_axes
    >>> draw_goals(new_axes(), np.array([[0.0, 1.0], [np.nan, np.nan]]), ("cup", "pan"))
    """
    for goal in np.flatnonzero(~np.isnan(places).any(axis=1)).tolist():
        place = (float(places[goal, 0]), float(places[goal, 1]))
        ax.plot(*place, "D", color=goal_colour_among_agents(goal), ms=8, mec="white", zorder=6)
        ax.annotate(
            labels[goal],
            place,
            xytext=(9, 9),
            textcoords="offset points",
            fontsize="small",
            color=INK,
            zorder=9,
            parse_math=False,
        )


def plane(ax: Axes, units: str) -> None:
    """Give axes of the plane equal scales, labels and a quiet grid.

    Examples
    --------
    >>> from ppinfer.plots.palette import new_axes
    >>> ax = new_axes()
    >>> plane(ax, "m")
    >>> ax.get_xlabel()
    'x [m]'
    """
    ax.set_aspect("equal", adjustable="datalim")
    for name, label in (("x", ax.set_xlabel), ("y", ax.set_ylabel)):
        label(f"{name} [{units}]").set_parse_math(False)
    ax.grid(color=FAINT, linewidth=0.4)
    ax.set_axisbelow(True)
    quiet(ax)
    ax.tick_params(labelcolor=MUTED)


def draw_paths(ax: Axes, interaction: Interaction) -> None:
    """Draw where both agents went among the goals: from the open circle to the full one, a dot each second.

    Examples
    --------
    >>> from ppinfer.plots.palette import new_axes
    >>> from ppinfer.studies import infer_log_conditional
    >>> from ppinfer.studies.interaction import read_interaction, stretches
    >>> from ppinfer.testing import example_interaction_log
    >>> log = example_interaction_log(trials=1)
    >>> draw_paths(
    ...     new_axes(), read_interaction(log, infer_log_conditional(log), stretches(log, "human")[0])
    ... )
    """
    for agent, name, colour in ((1, interaction.partner, ROBOT_COLOUR), (0, interaction.agent, HUMAN_COLOUR)):
        path = interaction.position[:, agent, :2]
        seen = np.flatnonzero(~np.isnan(path).any(axis=1))
        if not len(seen):
            continue
        ax.plot(*path[seen].T, color=colour, linewidth=1.6, zorder=4, label=_plain(name))
        seconds = seen[np.unique(np.floor(interaction.time[seen] + 1e-9), return_index=True)[1]]
        ax.plot(*path[seconds].T, ".", color=colour, ms=5, zorder=4)
        ax.plot(*path[seen[0]], "o", mfc="white", mec=colour, mew=1.6, ms=7, zorder=5)
        ax.plot(*path[seen[-1]], "o", color=colour, ms=8, zorder=5)
    draw_goals(ax, interaction.places[-1, :, :2], interaction.goals)
    hit: Int[np.ndarray, " hit"] = np.flatnonzero(interaction.collision)
    if len(hit):
        middle = interaction.position[hit, :, :2].mean(axis=1)
        ax.plot(*middle.T, "x", color="#B22222", ms=9, mew=2, zorder=8, label="collision")
    plane(ax, interaction.units)
    ax.margins(0.12)


def _plain(label: str) -> str:
    # Matplotlib leaves labels that begin with an underscore out of legends
    return label.lstrip("_") or "agent"
