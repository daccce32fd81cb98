"""What pages of parallel play show: times and stops, beliefs over theta, trials replan by replan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import xarray as xr

from ppinfer.plots.replan_beliefs import MeanBelief
from ppinfer.report.options import ReportOptions
from ppinfer.report.parts import Part
from ppinfer.report.play_figures import (
    belief_figure,
    differences_figure,
    human_figure,
    performance_figure,
    play_trial_figure,
)
from ppinfer.report.trial_choice import ChosenTrial
from ppinfer.studies.task_performance import TaskPerformance

NO_TRUE_THETA = "No log knows a true theta, so it cannot be told how often beliefs over theta come true."


def performance_part(
    performance: TaskPerformance,
    told: Mapping[str, list[dict[str, Any]]],
    *,
    compared: Sequence[str],
    robots: Sequence[str],
) -> Part:
    """Return times and stops of every robot, paired differences, and robots against each human.

    Parameters
    ----------
    performance
        Of every trial.
    told
        The numbers: ``pooled``, ``cells``, ``differences``.
    compared
        The robots that others are compared with.
    robots
        Those to show against each human.
    """
    return Part(
        "play/performance.html.j2",
        {"told": told, "compared": list(compared)},
        {
            "overall": [partial(performance_figure, performance)],
            "differences": [
                partial(differences_figure, told["differences"], name, number=number)
                for number, name in enumerate(compared, start=1)
            ],
            "humans": [
                partial(human_figure, performance, name, number=number)
                for number, name in enumerate(robots, start=1)
            ],
        },
    )


def belief_parts(beliefs: Sequence[MeanBelief], viewer: str, other: str) -> list[Part]:
    """Return what was believed of whom on average; nothing where there is no belief."""
    if not beliefs:
        return []
    return [
        Part(
            "play/beliefs.html.j2",
            {"beliefs": beliefs, "viewer": viewer, "other": other},
            {"figures": [partial(belief_figure, beliefs)]},
        )
    ]


def play_trials_part(
    dataset: xr.Dataset,
    chosen: Sequence[ChosenTrial],
    viewer: str,
    other: str,
    how: str,
    options: ReportOptions,
) -> Part:
    """Return some trials, replan by replan; ``how`` they were chosen, unless by name."""
    return Part(
        "sections/trials.html.j2",
        {
            "heading": "Trials, replan by replan",
            "how_chosen": how if options.trials is None else "Chosen by name.",
        },
        {
            "figures": [
                partial(
                    play_trial_figure,
                    dataset,
                    each.index,
                    viewer=viewer,
                    other=other,
                    number=number,
                    why=each.why,
                )
                for number, each in enumerate(chosen, start=1)
            ]
        },
    )
