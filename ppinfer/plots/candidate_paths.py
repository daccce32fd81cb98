"""The trajectories that a robot has to choose from, among where a human may go (Algorithm 3)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import FAINT, HUMAN_COLOUR, INK, MUTED, ROBOT_COLOUR, WARNING, new_axes
from ppinfer.plots.risk_map import draw_mover, nominal_modes
from ppinfer.plots.workspace import draw_goals, plane

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ppinfer.studies.interaction_safety import CandidatePaths

# modes that candidates give way to, as in candidate_trajectories
_LIKELY = 0.05
_INSTANTS = 4


@draws_plain_text
def plot_candidates(
    paths: CandidatePaths,
    *,
    goals: Float[np.ndarray, "goal 2"] | None = None,
    labels: tuple[str, ...] = (),
    units: str = "m",
    ax: Axes | None = None,
) -> Axes:
    """Draw candidate trajectories: safe ones in blue, unsafe ones dotted red, the chosen one thick.

    Grey dots are the synthetic obstacles that spread the candidates out. Orange is the human's nominal motion to each
    goal that they may well pursue, thicker where that is likelier, with circles of what a safe candidate keeps out of
    at a few instants: the least distance, and on top of it what the human's uncertainty amounts to by then.

    Parameters
    ----------
    paths
        From `ppinfer.studies.interaction_safety.candidate_paths`.
    goals, labels
        Where goals are (NaN: absent), and what they are called.
    units
        Of positions.
    ax
        Where to draw; a new figure by default.

    Examples
    --------
    >>> from ppinfer.studies.interaction_safety import candidate_paths
    >>> from ppinfer.testing import example_goal_situation
    >>> found = candidate_paths(example_goal_situation(), 0, np.array([0.1, 0.8, 0.1]), rollouts=400)
    >>> plot_candidates(found).get_title(loc="left").split(";")[0]
    '22 of 65 candidates safe'
    """
    ax = ax if ax is not None else new_axes(5.6, 4.6)
    positions, safe = paths.candidates.positions, paths.candidates.safe
    _draw_tubes(ax, paths)
    draw_mover(ax, paths.human, positions.shape[1] - 1)
    if len(paths.obstacles):
        ax.plot(
            *paths.obstacles.T, ".", color=MUTED, alpha=0.55, ms=3.5, zorder=2, label="synthetic obstacles"
        )
    for which, colour, dashes, label in ((~safe, WARNING, ":", "unsafe"), (safe, ROBOT_COLOUR, "-", "safe")):
        for number, path in enumerate(positions[which]):
            ax.plot(
                *path.T,
                color=colour,
                linestyle=dashes,
                linewidth=0.8,
                alpha=0.5,
                zorder=3,
                label=label if number == 0 else f"_{label}",
            )
    chosen = positions[paths.choice.plan]
    ax.plot(*chosen.T, color=INK, linewidth=4.2, zorder=6, solid_capstyle="round")
    ax.plot(
        *chosen.T,
        color=WARNING if paths.choice.flagged else ROBOT_COLOUR,
        linewidth=2.6,
        zorder=7,
        label="chosen, not certified" if paths.choice.flagged else "chosen",
        solid_capstyle="round",
    )
    ax.plot(*positions[0, 0], "o", color=ROBOT_COLOUR, ms=9, mec="white", zorder=8, label="robot")
    ax.plot(*paths.place, "s", color=ROBOT_COLOUR, fillstyle="none", ms=16, mew=1.8, zorder=7, label="target")
    if goals is not None:
        draw_goals(
            ax,
            goals,
            labels,
            among=np.concatenate([chosen, paths.human.agent.position(paths.human.state)[None]]),
        )
    plane(ax, units)
    ax.margins(0.08)
    found = paths.choice.certificate
    kept = int(safe.sum()) if safe.any() else "none"
    ax.set_title(
        f"{kept} of {len(safe)} candidates safe; the chosen one clear in {found.safe:,} of {found.rollouts:,} rollouts",
        loc="left",
        fontsize="small",
    )
    return ax


def _draw_tubes(ax: Axes, paths: CandidatePaths) -> None:
    from matplotlib.patches import Circle

    from ppinfer.safety import coverage_factor, uncertainty_growth

    horizon = paths.candidates.positions.shape[1] - 1
    kappa = coverage_factor("instant", eps=paths.eps, horizon=horizon)
    radius = paths.distance + kappa * uncertainty_growth(paths.human.agent, horizon)
    shown = np.unique(np.linspace(0, horizon, _INSTANTS + 1).round().astype(np.int64))
    for probability, path in zip(
        paths.human.probability.tolist(), nominal_modes(paths.human, horizon), strict=True
    ):
        if probability <= _LIKELY:
            continue
        for instant in shown.tolist():
            ax.add_patch(
                Circle(
                    (float(path[instant, 0]), float(path[instant, 1])),
                    float(radius[instant]),
                    facecolor=HUMAN_COLOUR,
                    edgecolor=FAINT if instant == 0 else HUMAN_COLOUR,
                    alpha=0.08,
                    linewidth=0.8,
                    zorder=1,
                )
            )
