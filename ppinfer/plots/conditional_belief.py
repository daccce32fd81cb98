"""What was believed of where the human goes, with and without the robot, through one interaction."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from ppinfer.errors import LogError
from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import (
    FAINT,
    INK,
    MUTED,
    goal_colour_among_agents,
    goal_dashes_among_agents,
    quiet,
)
from ppinfer.plots.workspace import draw_paths

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ppinfer.studies.interaction import Interaction

# strips below and above the lines: the human's true goal, and the robot's
_BELOW, _ABOVE, _HEIGHT = -0.14, 1.07, 0.07


@draws_plain_text
def plot_conditional_belief(
    interaction: Interaction, *, title: str | None = None, figure: Figure | None = None
) -> tuple[Axes, ...]:
    """Draw the belief over the human's goal through an interaction, before and after the reaction to the robot.

    From top to bottom: the belief without the robot; b_post given the robot's goal at each instant; p(theta_post),
    averaged over what the human may take that goal to be; and where the log has them, the two that the study held live.
    Beside them the paths of both agents. The strip under the lines has the colour of the goal that the human really
    went for, that above them the colour of the robot's.

    Parameters
    ----------
    interaction
        From `ppinfer.studies.interaction.read_interaction`.
    title
        Default: the trial's name.
    figure
        Where to draw; a new one by default.

    Returns
    -------
    tuple of matplotlib.axes.Axes
        One for each belief, then that of the paths.

    Raises
    ------
    LogError
        If positions have one coordinate only.

    Examples
    --------
    >>> from ppinfer.studies import infer_log_conditional
    >>> from ppinfer.studies.interaction import read_interaction, stretches
    >>> from ppinfer.testing import example_interaction_log
    >>> log = example_interaction_log(trials=1)
    >>> one = read_interaction(log, infer_log_conditional(log), stretches(log, "human")[0])
    >>> axes = plot_conditional_belief(one)
    >>> [ax.get_title(loc="left") for ax in axes[:2]]
    ['without the robot', "given the robot's goal"]
    """
    if interaction.position.shape[2] < 2:
        raise LogError("paths in the plane need two coordinates of position")
    shown = _beliefs(interaction)
    panels = _new_panels(len(shown), figure)
    *lines, paths = panels
    for ax, (name, probability) in zip(lines, shown, strict=True):
        _draw_belief(ax, interaction, probability)
        ax.set_title(name, loc="left", fontsize="small", pad=3).set_parse_math(False)
    _strip_key(lines[0], interaction)
    for ax in lines[:-1]:
        ax.tick_params(labelbottom=False)
    lines[-1].set_xlabel("time [s]")
    lines[len(lines) // 2].set_ylabel("probability of the human's goal".replace("human", interaction.agent))
    draw_paths(paths, interaction)
    said = f"trial {interaction.trial_id}" if title is None else title
    paths.set_title(said, loc="left", fontsize="medium").set_parse_math(False)
    _legend(paths, interaction)
    return panels


def _beliefs(interaction: Interaction) -> list[tuple[str, Float[np.ndarray, "sample goal"]]]:
    partner = interaction.partner
    shown = [
        (f"without the {partner}", interaction.belief),
        (f"given the {partner}'s goal", interaction.given),
        (
            f"overall: averaged over what the {interaction.agent} may take that goal to be",
            interaction.overall,
        ),
    ]
    told = (f"without the {partner}", f"given the {partner}")
    for (name, values), said in zip(interaction.live.items(), told, strict=False):
        shown.append((f"live, {said} ({name})", values))
    return shown


def _draw_belief(ax: Axes, interaction: Interaction, probability: Float[np.ndarray, "sample goal"]) -> None:
    time = interaction.time
    present = ~np.isnan(interaction.places).any(axis=2)
    for goal in np.flatnonzero(present.any(axis=0)).tolist():
        ax.plot(
            time,
            np.where(present[:, goal], probability[:, goal], np.nan),
            color=goal_colour_among_agents(goal),
            linestyle=goal_dashes_among_agents(goal),
            linewidth=1.6,
            label=interaction.goals[goal].lstrip("_"),
            clip_on=False,
        )
    for heading in interaction.headings:
        _strip(ax, interaction, heading.start, heading.stop, heading.goal, _BELOW)
    turns = np.flatnonzero(np.diff(interaction.partner_goal)) + 1
    edges = [0, *turns.tolist(), len(time)]
    for start, stop in pairwise(edges):
        if interaction.partner_goal[start] >= 0:
            _strip(ax, interaction, start, stop, int(interaction.partner_goal[start]), _ABOVE)
    ax.set_ylim(_BELOW - _HEIGHT, _ABOVE + _HEIGHT)
    begin, end = float(time[0]), float(time[-1])
    ax.set_xlim((begin, end) if end > begin else (begin - 0.5, begin + 0.5))
    ax.set_yticks([0, 0.5, 1])
    ax.grid(color=FAINT, linewidth=0.4, axis="y")
    ax.set_axisbelow(True)
    quiet(ax)


def _strip(ax: Axes, interaction: Interaction, start: int, stop: int, goal: int, at: float) -> None:
    from matplotlib.patches import Rectangle

    time = interaction.time
    begin, end = float(time[start]), float(time[min(stop, len(time) - 1)])
    colour = goal_colour_among_agents(goal) if goal >= 0 else FAINT
    ax.add_patch(Rectangle((begin, at - _HEIGHT / 2), end - begin, _HEIGHT, color=colour, linewidth=0))


def _strip_key(ax: Axes, interaction: Interaction) -> None:
    """Say beside the first panel what its strips are."""
    for at, agent in ((_ABOVE, interaction.partner), (_BELOW, interaction.agent)):
        ax.annotate(
            f" {agent}'s goal",
            (1.0, at),
            xycoords=("axes fraction", "data"),
            va="center",
            fontsize="x-small",
            color=MUTED,
            parse_math=False,
            annotation_clip=False,
        )


def _legend(ax: Axes, interaction: Interaction) -> None:
    from matplotlib.lines import Line2D

    handles, labels = ax.get_legend_handles_labels()
    present = (~np.isnan(interaction.places).any(axis=2)).any(axis=0)
    for goal in np.flatnonzero(present).tolist():
        handle = Line2D([], [], color=goal_colour_among_agents(goal), linewidth=2)
        handle.set_linestyle(goal_dashes_among_agents(goal))
        handles.append(handle)
        labels.append(f"goal {interaction.goals[goal]}")
    legend = ax.figure.legend(
        handles,
        labels,
        loc="outside lower left",
        ncols=8,
        frameon=False,
        fontsize="small",
        handlelength=1.4,
        columnspacing=1.4,
        labelcolor=INK,
    )
    for text in legend.get_texts():
        text.set_parse_math(False)


def _new_panels(beliefs: int, figure: Figure | None) -> tuple[Axes, ...]:
    if figure is None:
        from matplotlib.figure import Figure as NewFigure

        figure = NewFigure(figsize=(10.4, max(4.0, 0.8 + 1.1 * beliefs)), layout="constrained")
    grid = figure.add_gridspec(beliefs, 2, width_ratios=[1.2, 1])
    first = figure.add_subplot(grid[0, 0])
    others = [figure.add_subplot(grid[row, 0], sharex=first) for row in range(1, beliefs)]
    return (first, *others, figure.add_subplot(grid[:, 1]))
