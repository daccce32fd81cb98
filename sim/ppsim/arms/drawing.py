"""The table as it is drawn, and arms that can be moved about on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from ppinfer.plots.palette import goal_colour, quiet
from ppsim.arms.geometry import Arm
from ppsim.arms.recorded import RecordedTrial

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# the part of the table that is shown, m
_VIEW = (-1.3, 1.3, -0.98, 0.98)


def agent_colour(agent: int) -> str:
    """Return the colour that an agent has in every picture of a trial.

    Examples
    --------
    >>> agent_colour(0) != agent_colour(1)
    True
    """
    return goal_colour(agent)


def draw_scene(ax: Axes, trial: RecordedTrial) -> None:
    """Draw what does not move: the table, the arms' bases, and where each agent picks up and puts down."""
    from matplotlib.patches import Circle

    ax.set(xlim=_VIEW[:2], ylim=_VIEW[2:], aspect="equal", xlabel="x (m)", ylabel="y (m)")
    ax.set_facecolor("#FAFAF8")
    ax.grid(color="#EEEEEA", linewidth=0.8)
    ax.set_axisbelow(True)
    quiet(ax)
    for agent, (name, arm, (pick, place)) in enumerate(
        zip(trial.agents, trial.arms, trial.task, strict=True)
    ):
        colour = agent_colour(agent)
        ax.add_patch(Circle(arm.base, 1.5 * arm.radius, color=colour, alpha=0.35, linewidth=0, zorder=2))
        outward = -1.0 if arm.base[0] < 0 else 1.0
        ax.annotate(
            name,
            arm.base,
            (outward * 16, 0),
            textcoords="offset points",
            ha="right" if outward < 0 else "left",
            va="center",
            color=colour,
            weight="bold",
        )
        ax.plot(*pick, marker="o", markersize=12, fillstyle="none", color=colour, alpha=0.6, zorder=2)
        ax.plot(
            *place, marker="s", markersize=17, fillstyle="none", color=colour, markeredgewidth=1.8, zorder=2
        )


class Capsules:
    """An arm that can be moved about in a picture: its links as capsules, and its joints."""

    def __init__(self, ax: Axes, arm: Arm, colour: str) -> None:
        from matplotlib.patches import Circle, Polygon

        self.arm = arm
        self._links = [
            Polygon(np.zeros((1, 2)), closed=True, facecolor=colour, alpha=0.55, edgecolor=colour, zorder=5)
            for _ in arm.links
        ]
        self._joints = [
            Circle((0.0, 0.0), 0.35 * arm.radius, color="white", linewidth=0, zorder=6) for _ in range(3)
        ]
        self.artists = [*self._links, *self._joints]
        for artist in self.artists:
            ax.add_patch(artist)

    def show(self, joints: Float[np.ndarray, " 2"]) -> None:
        """Put the arm into a pose, or take it away where that is NaN."""
        there = bool(np.isfinite(joints).all())
        for artist in self.artists:
            artist.set_visible(there)
        if there:
            points = self.arm.points(joints)
            for link, start, stop in zip(self._links, points[:-1], points[1:], strict=True):
                link.set_xy(_capsule(start, stop, self.arm.radius))
            for joint, at in zip(self._joints, points, strict=True):
                joint.set_center((float(at[0]), float(at[1])))


def _capsule(
    start: Float[np.ndarray, " 2"], stop: Float[np.ndarray, " 2"], radius: float
) -> Float[np.ndarray, "point 2"]:
    ahead = np.arctan2(*(stop - start)[::-1])
    half = np.linspace(-np.pi / 2, np.pi / 2, 13)
    ends = [
        at + radius * np.stack([np.cos(turn + half), np.sin(turn + half)], axis=-1)
        for at, turn in ((stop, ahead), (start, ahead + np.pi))
    ]
    outline: np.ndarray = np.concatenate(ends)
    return outline
