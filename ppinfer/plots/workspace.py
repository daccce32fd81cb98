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
    from matplotlib.patheffects import AbstractPathEffect

    from ppinfer.studies.interaction import Interaction


# where a label may stand, seen from its goal: above and to the right by preference
_CORNERS = ((1, 1), (-1, 1), (1, -1), (-1, -1))


def halo() -> list[AbstractPathEffect]:
    """Return what keeps a label legible on lines and dark places.

    Examples
    --------
    >>> len(halo())
    1
    """
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=2.5, foreground="white")]


def clear_corner(
    place: Float[np.ndarray, " 2"], among: Float[np.ndarray, "point 2"], reach: float
) -> tuple[int, int]:
    """Return the side of a goal on which its label is farthest from whatever is near it: signs of x and y.

    Parameters
    ----------
    place : (2,) float64
        Where the goal is.
    among : (point, 2) float64
        What the label must not lie on; NaN is nothing.
    reach : float
        How far the label is from the goal along each axis; what is farther away than three times that is not near.

    Examples
    --------
    >>> clear_corner(np.zeros(2), np.array([[0.5, 0.5]]), 0.5)
    (-1, -1)
    >>> clear_corner(np.zeros(2), np.array([[9.0, 9.0]]), 0.5)
    (1, 1)
    """
    there = among[~np.isnan(among).any(axis=1)]
    near = there[np.linalg.norm(there - place, axis=1) <= 3.0 * reach]
    if not len(near):
        return _CORNERS[0]
    spots = place + reach * np.array(_CORNERS, dtype=np.float64)
    room = np.linalg.norm(spots[:, None] - near, axis=2).min(axis=1)
    return _CORNERS[int(room.argmax())]


def draw_goals(
    ax: Axes,
    places: Float[np.ndarray, "goal 2"],
    labels: tuple[str, ...],
    *,
    among: Float[np.ndarray, "point 2"] | None = None,
) -> None:
    """Draw goals as diamonds in their colours, with their labels; NaN is absent.

    ``among`` are points that labels keep away from.

    Examples
    --------
    >>> from ppinfer.plots.palette import new_axes
    >>> draw_goals(new_axes(), np.array([[0.0, 1.0], [np.nan, np.nan]]), ("cup", "pan"))
    """
    present = np.flatnonzero(~np.isnan(places).any(axis=1)).tolist()
    points = np.empty((0, 2)) if among is None else among
    around = np.concatenate([points[~np.isnan(points).any(axis=1)], places[present]])
    # a label is about so far away in a picture of all of these
    reach = 0.04 * float(np.ptp(around, axis=0).max()) if len(around) else 0.0
    for goal in present:
        across, up = clear_corner(places[goal], points, reach)
        place = (float(places[goal, 0]), float(places[goal, 1]))
        ax.plot(*place, "D", color=goal_colour_among_agents(goal), ms=8, mec="white", zorder=6)
        ax.annotate(
            labels[goal],
            place,
            xytext=(9 * across, 9 * up),
            textcoords="offset points",
            ha="left" if across > 0 else "right",
            va="bottom" if up > 0 else "top",
            fontsize="small",
            color=INK,
            zorder=9,
            parse_math=False,
            path_effects=halo(),
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
    draw_goals(
        ax,
        interaction.places[-1, :, :2],
        interaction.goals,
        among=interaction.position[..., :2].reshape(-1, 2),
    )
    hit: Int[np.ndarray, " hit"] = np.flatnonzero(interaction.collision)
    if len(hit):
        middle = interaction.position[hit, :, :2].mean(axis=1)
        ax.plot(*middle.T, "x", color="#B22222", ms=9, mew=2, zorder=8, label="collision")
    plane(ax, interaction.units)
    square(ax)


def square(ax: Axes, margin: float = 0.08) -> None:
    """Show a square about all that is drawn: a panel of any shape is used as far as equal scales let it.

    Examples
    --------
    >>> from ppinfer.plots.palette import new_axes
    >>> ax = new_axes()
    >>> _ = ax.plot([0.0, 4.0], [1.0, 1.0])
    >>> square(ax, margin=0.25)
    >>> [tuple(map(float, side)) for side in (ax.get_xlim(), ax.get_ylim())]
    [(-1.0, 5.0), (-2.0, 4.0)]
    """
    ax.set_aspect("equal", adjustable="box", anchor="N")
    ax.margins(0)
    ax.autoscale_view()
    low, high = (np.array(side) for side in zip(ax.get_xlim(), ax.get_ylim(), strict=True))
    middle, half = (low + high) / 2, (0.5 + margin) * float((high - low).max() or 1.0)
    ax.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))


def _plain(label: str) -> str:
    # Matplotlib leaves labels that begin with an underscore out of legends
    return label.lstrip("_") or "agent"
