"""The figures of a report on parallel play, as PNG bytes with their captions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import xarray as xr

from ppinfer.plots.belief_by_human import plot_belief_by_human
from ppinfer.plots.hand_distance import plot_hand_distance
from ppinfer.plots.paired_differences import plot_paired_differences
from ppinfer.plots.personality import draw_personality, read_personality_trial
from ppinfer.plots.replan_beliefs import MeanBelief, belief_variable
from ppinfer.plots.task_performance import plot_against_personalities, plot_task_performance
from ppinfer.report.figures import ReportFigure, new_figure, png_of
from ppinfer.studies.task_performance import TaskPerformance

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FINISHED = "whoever was not done counts with the trial's length"


def performance_figure(performance: TaskPerformance) -> ReportFigure:
    """Draw times and stops of every robot, over all humans."""
    axes = plot_task_performance(performance)
    return ReportFigure(
        name="task-performance.png",
        png=png_of(_figure_of(axes)),
        title="Times and safety stops of every robot",
        caption=(
            "Mean over all trials with all humans; whiskers are one standard error to each side, robust to what "
            "trials of a scene have in common. Total time: until both had finished "
            f"({_FINISHED}). Further left is better in every panel."
        ),
    )


def differences_figure(
    differences: Sequence[Mapping[str, Any]], against: str, *, number: int
) -> ReportFigure:
    """Draw paired differences from one robot."""
    axes = plot_paired_differences(differences, against)
    return ReportFigure(
        name=f"differences-{number}.png",
        png=png_of(_figure_of(axes)),
        title=f"Paired differences from {against}",
        caption=(
            f"Each trial less that of {against} in the same scene, with the same human and plan sets; whiskers are "
            "95 % intervals of a bootstrap over scenes. Left of the line is faster, or stopped less often; an "
            "interval clear of the line is hardly an accident of the scenes."
        ),
    )


def human_figure(performance: TaskPerformance, robot: str, *, number: int) -> ReportFigure:
    """Draw times and stops of one robot against each human."""
    axes = plot_against_personalities(performance, robot)
    return ReportFigure(
        name=f"humans-{number}.png",
        png=png_of(_figure_of(axes)),
        title=f"{robot} against each human",
        caption=(
            "Mean over the trials with each human; whiskers are one standard error to each side. A robot that "
            "adapts keeps its stops low with all of them."
        ),
    )


def belief_figure(beliefs: Sequence[MeanBelief]) -> ReportFigure:
    """Draw the mean belief that the other agent favours itself."""
    axes, label = plot_belief_by_human(beliefs), beliefs[0].label
    return ReportFigure(
        name="beliefs.png",
        png=png_of(_figure_of(axes)),
        title=f"What was believed of each {label}",
        caption=(
            f"The mean over trials of the probability that the {label} favours itself, from a trial's first replan "
            "(0 %) to its last (100 %); bands are one standard error. Beside each name: the mean over the replans "
            "of each trial, then over trials. Dashed: one half."
        ),
    )


def play_trial_figure(
    dataset: xr.Dataset, trial: int, *, viewer: str, other: str, number: int, why: str
) -> ReportFigure:
    """Draw what ``viewer`` believed of ``other`` through one trial, and under it how near hands came."""
    believes, has_hands = belief_variable(dataset) is not None, "end_effector" in dataset
    figure = new_figure(9.2, 2.3 * (1.2 * believes + 0.8 * has_hands) + 0.3)
    ratios = [2.0] * believes + [1.3] * has_hands
    panels = figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios, squeeze=False)[:, 0]
    captions = []
    if believes:
        data = read_personality_trial(dataset, trial, robot=viewer, human=other)
        draw_personality(data, ax=panels[0])
        captions.append(
            f"The height of a band is the probability that the {other}'s choice of equilibria favours that agent, from "
            "one replan to the next; white: no belief was held."
        )
        if len(data.time):
            captions.append("Red ticks are safety stops, dashed lines say when agents were done.")
    if has_hands:
        plot_hand_distance(dataset, trial, robot=viewer, human=other, ax=panels[-1])
        captions.append(
            "Below: how far apart hands were, until the first was done."
            if believes
            else "How far apart hands were, until the first was done; safety stops in red."
        )
    if believes and has_hands:
        panels[0].set_xlabel("")
    return ReportFigure(
        name=f"trial-{number}.png",
        png=png_of(figure),
        title=f"Trial {dataset['trial_id'].values[trial]} ({why})",
        caption=" ".join(captions),
    )


def _figure_of(axes: Sequence[Axes]) -> Figure:
    return cast("Figure", axes[0].figure)
