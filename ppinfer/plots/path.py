"""The path of one trial in the plane, with its goals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from jaxtyping import Float, Int

from ppinfer.errors import LogError
from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import FAINT, INK, MUTED, goal_colour, new_axes, quiet
from ppinfer.plots.trial_data import TrialData, read_trial

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_TRUE_GOAL_SIZE = 190
_MAX_NAMED_PLACES = 8


@draws_plain_text
def plot_path(posterior: xr.Dataset, trial: str | int, *, ax: Axes | None = None) -> Axes:
    """Draw the path of a trial in the plane, each sample in the colour of the goal believed most.

    The paler a sample, the less certain the belief. Goals are diamonds; a ring marks those that were the
    true goal of a segment, and where goals move within the trial, the places that nobody went to are faint.
    The path starts at the open circle.

    Parameters
    ----------
    posterior
        A posterior with at least two coordinates of position; the first two are drawn.
    trial
        The trial's name or index.
    ax
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes drawn on, with equal scales.

    Raises
    ------
    LogError
        If there is no such trial, or positions have one coordinate only.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR
    >>> from ppinfer.studies import infer_log
    >>> from ppinfer.testing import example_log
    >>> ax = plot_path(infer_log(example_log(), GoalLQR()), 0)
    >>> ax.figure.savefig("path.png")
    """
    return draw_path(read_trial(posterior, trial), ax=ax, space=tuple(map(str, posterior["space"].values)))


@draws_plain_text
def draw_path(data: TrialData, *, space: tuple[str, ...] = ("x", "y"), ax: Axes | None = None) -> Axes:
    """Draw a trial that was already read; see `plot_path`."""
    if data.position.shape[1] < 2:
        raise LogError("a path in the plane needs two coordinates of position")
    ax = ax if ax is not None else new_axes(4, 4)
    seen = np.flatnonzero(~np.isnan(data.position[:, :2]).any(axis=1))
    ax.plot(*data.position[:, :2].T, color=FAINT, linewidth=0.8, zorder=1)
    ax.scatter(
        data.position[seen, 0],
        data.position[seen, 1],
        c=_belief_colours(data.probability[seen]),
        s=9,
        linewidths=0,
        zorder=3,
    )
    if len(seen):
        ax.plot(*data.position[seen[0], :2], "o", mfc="white", mec=INK, ms=6, zorder=4)
    true = np.array([data.goal_position[s.start, s.true_goal, :2] for s in data.segments if s.true_goal >= 0])
    for goal in data.shown_goals:
        places = np.unique(data.goal_position[:, goal, :2], axis=0)
        places = places[~np.isnan(places).any(axis=1)]
        # where goals move within the trial, those that nobody went for stand back
        matters = np.ones(len(places), dtype=bool)
        if len(places) > 1 and len(true):
            matters = (places[:, None] == true).all(axis=2).any(axis=1)
        for of_note, alpha, size in ((matters, 1.0, 42), (~matters, 0.3, 24)):
            ax.scatter(
                places[of_note, 0],
                places[of_note, 1],
                marker="D",
                s=size,
                alpha=alpha,
                color=goal_colour(goal),
                edgecolors="white",
                zorder=5,
            )
        for place in places[matters][:_MAX_NAMED_PLACES]:
            ax.annotate(
                data.goals[goal],
                tuple(place),
                xytext=(8, 8),
                textcoords="offset points",
                fontsize="small",
                color=INK,
                parse_math=False,
            )
    if len(true):
        ax.scatter(
            true[:, 0],
            true[:, 1],
            s=_TRUE_GOAL_SIZE,
            facecolors="none",
            edgecolors=INK,
            linewidths=1,
            zorder=4,
        )
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.08)
    ax.set_xlabel(f"{space[0]} [{data.units}]")
    ax.set_ylabel(f"{space[1]} [{data.units}]")
    ax.grid(color=FAINT, linewidth=0.4)
    ax.set_axisbelow(True)
    quiet(ax)
    ax.tick_params(labelcolor=MUTED)
    return ax


def _belief_colours(probability: Float[np.ndarray, "sample goal"]) -> Float[np.ndarray, "sample 4"]:
    from matplotlib.colors import to_rgb

    n_goals = probability.shape[1]
    palette = np.array([to_rgb(goal_colour(goal)) for goal in range(n_goals)])
    best: Int[np.ndarray, " sample"] = probability.argmax(axis=1)
    # from chance (faint) to certainty (full)
    chance = 1 / n_goals if n_goals > 1 else 0.0
    certainty = np.clip((probability.max(axis=1) - chance) / (1 - chance), 0, 1)
    return np.column_stack([palette[best], 0.15 + 0.85 * certainty])
