"""Where in the workspace a robot would be at risk of coming too near to a human."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float

from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import FAINT, HUMAN_COLOUR, INK, ROBOT_COLOUR, WARNING, new_axes
from ppinfer.plots.workspace import draw_goals, plane

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

    from ppinfer.safety import Mover
    from ppinfer.studies.interaction_safety import RiskMap

# a line is drawn where a plan would just be accepted at the usual eps
_EPS = 0.05


@draws_plain_text
def plot_risk_map(
    risk: RiskMap,
    *,
    goals: Float[np.ndarray, "goal 2"] | None = None,
    labels: tuple[str, ...] = (),
    robot: Float[np.ndarray, " 2"] | None = None,
    units: str = "m",
    colour_bar: bool = True,
    ax: Axes | None = None,
) -> Axes:
    """Draw the probability of a violation for a robot that starts at rest in each place and goes for its target.

    The darker, the likelier; the line is at 5 %. Orange is the human: where they are, and their nominal motion to each
    goal they may pursue, thicker where that is likelier. The blue square is the target; a blue disc, the robot.

    Parameters
    ----------
    risk
        From `ppinfer.studies.interaction_safety.risk_map`.
    goals, labels
        Where goals are (NaN: absent), and what they are called.
    robot
        Where the robot really is.
    units
        Of positions.
    colour_bar
        Whether to say what the shades are.
    ax
        Where to draw; a new figure by default.

    Examples
    --------
    >>> from ppinfer.goals.choice.joint import point_agent
    >>> from ppinfer.safety import Mover
    >>> from ppinfer.studies.interaction_safety import risk_map
    >>> human = Mover(point_agent(), np.zeros(4), np.array([[4.0, 0.0, 0.0, 0.0]]), np.array([1.0]))
    >>> found = risk_map(
    ...     point_agent(), np.array([0.0, 4.0]), (human,), bounds=(-2.0, 6.0, -4.0, 4.0), cells=9, rollouts=10,
    ...     rng=np.random.default_rng(0),
    ... )
    >>> plot_risk_map(found).get_title(loc="left")
    'p(nearer than 1 m in 20 steps), starting here'
    """
    ax = ax if ax is not None else new_axes(5.6, 4.6)
    image = _shade(ax, risk)
    if colour_bar:
        bar = ax.figure.colorbar(image, ax=ax, shrink=0.75, pad=0.02)
        bar.set_label("probability of a violation", fontsize="small")
        bar.ax.tick_params(labelsize="small")
        bar.outline.set_visible(False)
    if risk.probability.min() < _EPS < risk.probability.max():
        ax.contour(risk.x, risk.y, risk.probability, levels=[_EPS], colors=[WARNING], linewidths=0.9)
    for other in risk.others:
        draw_mover(ax, other, risk.horizon)
    ax.plot(*risk.target, "s", color=ROBOT_COLOUR, fillstyle="none", ms=16, mew=1.8, zorder=7, label="target")
    if robot is not None:
        ax.plot(*robot, "o", color=ROBOT_COLOUR, ms=9, mec="white", zorder=8, label="robot")
    if goals is not None:
        agents = [other.agent.position(other.state) for other in risk.others]
        if robot is not None:
            agents.append(np.asarray(robot, dtype=np.float64))
        draw_goals(ax, goals, labels, among=np.array(agents).reshape(-1, 2))
    plane(ax, units)
    ax.set_aspect("equal", adjustable="box")
    ax.grid(visible=False)
    ax.set_xlim(risk.x[0], risk.x[-1])
    ax.set_ylim(risk.y[0], risk.y[-1])
    title = ax.set_title(
        f"p(nearer than {risk.distance:g} {units} in {risk.horizon} steps), starting here",
        loc="left",
        fontsize="small",
    )
    title.set_parse_math(False)
    return ax


def draw_mover(ax: Axes, other: Mover, horizon: int, *, colour: str = HUMAN_COLOUR) -> None:
    """Draw where another agent is, and its nominal motion in each mode, thicker where that is likelier.

    Examples
    --------
    >>> from ppinfer.goals.choice.joint import point_agent
    >>> from ppinfer.safety import Mover
    >>> ax = new_axes()
    >>> draw_mover(ax, Mover(point_agent(), np.zeros(4), np.ones((1, 4)), np.array([1.0])), 20)
    >>> len(ax.lines)
    2
    """
    for probability, path in zip(other.probability.tolist(), nominal_modes(other, horizon), strict=True):
        if probability >= 0.01:
            ax.plot(
                *path.T, color=colour, linewidth=0.8 + 3.2 * probability, solid_capstyle="round", zorder=5
            )
    here = other.agent.position(other.state)
    ax.plot(*here, "o", color=colour, ms=9, mec="white", zorder=8, label="human")


def nominal_modes(other: Mover, horizon: int) -> Float[np.ndarray, "mode instant space"]:
    """Return where another agent goes in each mode, undisturbed.

    Examples
    --------
    >>> from ppinfer.goals.choice.joint import point_agent
    >>> from ppinfer.safety import Mover
    >>> nominal_modes(Mover(point_agent(), np.zeros(4), np.ones((3, 4)), np.full(3, 1 / 3)), 20).shape
    (3, 21, 2)
    """
    from ppinfer.safety import nominal_motion

    starts = np.repeat(other.state[None], other.modes, axis=0)
    states, _ = nominal_motion(other.agent, starts, other.targets, horizon)
    return other.agent.position(states)


def _shade(ax: Axes, risk: RiskMap) -> AxesImage:
    from matplotlib.colors import LinearSegmentedColormap

    half_x, half_y = (risk.x[1] - risk.x[0]) / 2, (risk.y[1] - risk.y[0]) / 2
    shades: Any = LinearSegmentedColormap.from_list("risk", ["#FFFFFF", FAINT, "#A0A0A0", INK])
    return ax.imshow(
        risk.probability,
        origin="lower",
        extent=(risk.x[0] - half_x, risk.x[-1] + half_x, risk.y[0] - half_y, risk.y[-1] + half_y),
        cmap=shades,
        vmin=0.0,
        vmax=1.0,
        interpolation="nearest",
        zorder=0,
    )
