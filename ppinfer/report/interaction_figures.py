"""The figures of a report on two agents among goals, as PNG bytes with their captions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from jaxtyping import Float

from ppinfer.goals.choice.joint import point_agent
from ppinfer.plots.candidate_paths import plot_candidates
from ppinfer.plots.conditional_belief import plot_conditional_belief
from ppinfer.plots.game_performance import plot_game_performance
from ppinfer.plots.risk_map import plot_risk_map
from ppinfer.report.figures import ReportFigure, new_figure, png_of
from ppinfer.studies.interaction import Interaction
from ppinfer.studies.interaction_safety import candidate_paths, risk_map, situation_at

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# the moment that is looked at: so long before the agents are nearest, s
BEFORE_CLOSEST = 1.0
_MARGIN = 1.5
# of the running median of distances, in samples
_HALF_WINDOW = 4
# as near as that to the smallest distance is near, m
_CLOSE = 0.5


def game_figure(cells: Sequence[Mapping[str, Any]]) -> ReportFigure:
    """Draw points, collisions and first scores of every robot with every human."""
    return ReportFigure(
        name="game-performance.png",
        png=png_of(_figure_of(plot_game_performance(cells))),
        title="Every robot with every human",
        caption=(
            "Mean over games; whiskers are one standard error to each side, robust to what games of one number have in "
            "common. More points are better, fewer collisions, and an earlier first score."
        ),
    )


def interaction_figure(interaction: Interaction, *, number: int, why: str) -> ReportFigure:
    """Draw the beliefs through one interaction beside the paths."""
    agent, partner = interaction.agent, interaction.partner
    live = (
        " The last two are those that the study held live."
        if interaction.live
        else " The log holds no live beliefs."
    )
    return ReportFigure(
        name=f"interaction-{number}.png",
        png=png_of(_figure_of(plot_conditional_belief(interaction))),
        title=f"Trial {interaction.trial_id}, from {interaction.time[0]:.1f} s ({why})",
        caption=(
            f"Left, from top to bottom: the probability of each goal of the {agent} from its motion alone; given the "
            f"goal that the {partner} had then (Algorithm 1's b_post); and averaged over what the {agent} may take "
            f"that goal to be.{live} The strip below the lines has the colour of the goal that the {agent} went for, "
            f"that above them of the {partner}'s. Right: the paths, from open to full circle, a dot each second."
        ),
    )


def safety_figure(interaction: Interaction, *, rollouts: int = 1000) -> ReportFigure:
    """Draw candidate trajectories and the risk map a second before the two were nearest to each other.

    Raises
    ------
    LogError
        If they were never both seen.
    """
    sample = safety_sample(interaction)
    situation = situation_at(interaction, sample)
    goal = int(interaction.partner_goal[sample])
    whose = f"the goal that the {interaction.partner} had then"
    if goal < 0:
        goal = int(interaction.mental_model[sample].argmax())
        whose = f"the goal that the {interaction.partner} most probably had then"
    post = interaction.post[sample, goal]
    paths = candidate_paths(situation, goal, post, rollouts=rollouts)
    places = interaction.places[sample, :, :2]
    bounds = _bounds(interaction, places, paths.candidates.positions)
    risk = risk_map(
        point_agent(),
        paths.place,
        (paths.human,),
        bounds=bounds,
        rollouts=rollouts,
        rng=np.random.default_rng(0),
    )
    figure = new_figure(10.8, 5.2)
    left, right = figure.subplots(1, 2)
    plot_candidates(paths, goals=places, labels=interaction.goals, units=interaction.units, ax=left)
    plot_risk_map(
        risk,
        goals=places,
        labels=interaction.goals,
        robot=situation.robot_position,
        units=interaction.units,
        ax=right,
    )
    left.set_aspect("equal", adjustable="box")
    left.set(xlim=bounds[:2], ylim=bounds[2:])
    handles, labels = left.get_legend_handles_labels()
    for text in figure.legend(
        handles, labels, loc="outside lower left", ncols=8, frameon=False, fontsize="small", markerscale=0.6
    ).get_texts():
        text.set_parse_math(False)
    found = paths.choice.certificate
    verdict = f"{'not ' * paths.choice.flagged}claimed with 99 % confidence"
    return ReportFigure(
        name="safety.png",
        png=png_of(figure),
        title=f"Trial {interaction.trial_id}, at {interaction.time[sample]:.1f} s",
        caption=(
            f"Left: candidate trajectories to {whose} ({interaction.goals[goal]}). Blue ones are safe as Algorithm 3 "
            f"has it: they keep out of wherever the {interaction.agent} may well be within {risk.horizon} steps; "
            "dotted red ones do not. The thick one was chosen, and stays clear in "
            f"{found.safe:,} of {found.rollouts:,} rollouts of its own: that the probability of coming nearer than "
            f"{paths.distance:g} {interaction.units} is at most 5 % is {verdict}. Circles: what a safe candidate keeps "
            "out of at a few instants. Right: that probability for a robot that starts at rest in each place and goes "
            f"for the same goal; the line is at 5 %. The {interaction.agent} heads for each goal with its probability "
            "given that goal of the robot, by LQR with disturbed velocities, and avoids nobody."
        ),
    )


def safety_sample(interaction: Interaction) -> int:
    """Return the sample to look at: the last, at least `BEFORE_CLOSEST` before the closest approach, with both seen.

    Distances are running medians: a tracker that jumps for an instant is no approach. Of agents that stand near each
    other for long, the time they came there counts.
    """
    seen = np.flatnonzero(~np.isnan(interaction.apart))
    half = min(_HALF_WINDOW, (len(seen) - 1) // 2)
    padded = np.pad(interaction.apart[seen], half, mode="reflect")
    smooth = np.median(np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1), axis=1)
    closest = interaction.time[seen[int((smooth <= smooth.min() + _CLOSE).argmax())]]
    early = seen[interaction.time[seen] <= closest - BEFORE_CLOSEST]
    return int(early[-1] if len(early) else seen[0])


def _bounds(
    interaction: Interaction,
    places: Float[np.ndarray, "goal 2"],
    candidates: Float[np.ndarray, "candidate instant 2"],
) -> tuple[float, float, float, float]:
    """Return a square that holds goals, agents and candidates."""
    points = np.concatenate([places, interaction.position[..., :2].reshape(-1, 2), candidates.reshape(-1, 2)])
    points = points[~np.isnan(points).any(axis=1)]
    # jumps of a tracker must not make all else small
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    there = places[~np.isnan(places).any(axis=1)]
    low, high = np.minimum(low, there.min(axis=0)), np.maximum(high, there.max(axis=0))
    middle, half = (low + high) / 2, (high - low).max() / 2 + _MARGIN
    return (
        float(middle[0] - half),
        float(middle[0] + half),
        float(middle[1] - half),
        float(middle[1] + half),
    )


def _figure_of(axes: Sequence[Axes]) -> Figure:
    return cast("Figure", axes[0].figure)
