"""The page about a log of parallel play: how fast and how safe robots were, and what they believed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Bool

from ppinfer.plots.replan_beliefs import (
    MeanBelief,
    ReplanBeliefs,
    belief_variable,
    mean_beliefs,
    read_beliefs,
)
from ppinfer.report.play_facts import (
    baselines,
    inferring_trials,
    log_provenance,
    log_sheet,
    personal_robots,
    wanted_trials,
)
from ppinfer.report.play_figures import (
    belief_figure,
    differences_figure,
    human_figure,
    performance_figure,
    play_trial_figure,
)
from ppinfer.report.play_trials import choose_plays, how_chosen
from ppinfer.report.rendering import render
from ppinfer.report.trial_choice import ChosenTrial, named_trials
from ppinfer.report.written import Drawn, Progress, WrittenReport
from ppinfer.studies.faults import Report
from ppinfer.studies.schema import FORMAT
from ppinfer.studies.storage import open_log, stated_format
from ppinfer.studies.task_performance import TaskPerformance, task_performance
from ppinfer.studies.validation import validate_log

PLAY_VARIABLES = ("finish_time", "stops", "stop_episodes", "controller")
ROBOT, HUMAN = "robot", "human"


def is_play_log(source: Path) -> bool:
    """Whether a file is a study log that says how fast and safe a robot and a human did their tasks."""
    is_log = (source / "zarr.json").is_file() if source.is_dir() else stated_format(source) == FORMAT
    if not is_log:
        return False
    with open_log(source) as log:
        return all(name in log.variables for name in PLAY_VARIABLES)


@dataclass(frozen=True)
class _Told:
    """The numbers on the page, each told once and drawn as it is told."""

    pooled: list[dict[str, Any]]
    cells: list[dict[str, Any]]
    differences: list[dict[str, Any]]
    beliefs: list[MeanBelief]


def write_play_page(
    source: Path,
    target: Path,
    *,
    trials: Sequence[str] | None,
    participants: Sequence[str] | None,
    exclude: Sequence[str] | None,
    progress: Progress,
) -> WrittenReport:
    """Write the page about a log of parallel play; see `ppinfer.report.write_report`."""
    checked = validate_log(source)
    with open_log(source) as log:
        if not checked.ok:
            return _write_faults(source, target, log, checked)
        wanted = wanted_trials(log, participants, exclude)
        chosen = None if trials is None else named_trials(log, trials)
        performance = _among(task_performance(log), wanted)
        beliefs = (
            None if belief_variable(log) is None else read_beliefs(log).among(wanted & inferring_trials(log))
        )
        against = baselines(performance)
        told = _Told(
            pooled=performance.pooled(),
            cells=performance.cells(),
            differences=performance.differences(against),
            beliefs=_mean_beliefs(beliefs),
        )
        if chosen is None:
            chosen = choose_plays(beliefs, HUMAN, stops=log["stops"].values, among=wanted)
        warnings = _warnings(performance, told, beliefs)
        compared = [name for name in against if any(row["against"] == name for row in told.differences)]
        robots = personal_robots(performance, beliefs)
        drawable = beliefs is not None or "end_effector" in log
        drawn = Drawn(
            progress,
            total=1
            + len(compared)
            + len(robots)
            + (1 if told.beliefs else 0)
            + (len(chosen) if drawable else 0),
        )
        context = {
            "performance_figure": drawn.add(performance_figure(performance)),
            "difference_figures": [
                (name, drawn.add(differences_figure(told.differences, name, number=number)))
                for number, name in enumerate(compared, start=1)
            ],
            "human_figures": [
                drawn.add(human_figure(performance, name, number=number))
                for number, name in enumerate(robots, start=1)
            ],
            "belief_figure": drawn.add(belief_figure(told.beliefs)) if told.beliefs else None,
            "trial_figures": [
                drawn.add(
                    play_trial_figure(log, each.index, viewer=ROBOT, other=HUMAN, number=number, why=each.why)
                )
                for number, each in enumerate(chosen, start=1)
            ]
            if drawable
            else [],
        }
        page = render(
            "play.html.j2",
            title=str(log.attrs.get("title") or "Parallel play"),
            source=source.name,
            viewer=ROBOT,
            other=HUMAN,
            told=told,
            faults=[],
            notes_of_check=checked.lines(),
            warnings=warnings,
            how_chosen=how_chosen(HUMAN, stops=True) if trials is None else "Chosen by name.",
            data_sheet=log_sheet(log, performance, beliefs),
            provenance=log_provenance(log, source),
            **context,
        )
        shown = _names(log, chosen) if drawable else ()
    return WrittenReport(
        page=target / "index.html",
        figures=drawn.write(target, page),
        trials=shown,
        warnings=tuple(warnings),
        task_performance={
            "pooled": told.pooled,
            "cells": told.cells,
            "differences": told.differences,
        },
        beliefs=tuple(told.beliefs) if told.beliefs else None,
    )


def _write_faults(source: Path, target: Path, log: xr.Dataset, checked: Report) -> WrittenReport:
    count = sum(checked.fault_counts.values())
    warnings = [
        f"the log has {count} fault{'s' * (count != 1)}, so nothing is concluded from it; mend it "
        "(see 'ppinfer validate')"
    ]
    drawn = Drawn(None, total=0)
    page = render(
        "play.html.j2",
        title=str(log.attrs.get("title") or "Parallel play"),
        source=source.name,
        told=None,
        faults=checked.lines(),
        notes_of_check=[],
        warnings=warnings,
        data_sheet=[(name, f"{size:,}") for name, size in checked.sizes.items()],
        provenance=log_provenance(log, source),
    )
    return WrittenReport(
        page=target / "index.html", figures=drawn.write(target, page), trials=(), warnings=tuple(warnings)
    )


def _among(performance: TaskPerformance, trials: Bool[np.ndarray, " trial"]) -> TaskPerformance:
    return replace(
        performance, **{item.name: getattr(performance, item.name)[trials] for item in fields(performance)}
    )


def _mean_beliefs(beliefs: ReplanBeliefs | None) -> list[MeanBelief]:
    return [] if beliefs is None or HUMAN not in beliefs.theta else mean_beliefs(beliefs, HUMAN)


def _warnings(performance: TaskPerformance, told: _Told, beliefs: ReplanBeliefs | None) -> list[str]:
    warnings = []
    unfinished = round(sum(row["failures"] * row["trials"] for row in told.pooled))
    if unfinished:
        trials = len(performance.scene)
        warnings.append(
            f"{unfinished:,} of {trials:,} trials were not finished: whoever was not done counts with the trial's "
            "length"
        )
    if len(np.unique(performance.scene)) < 2:
        warnings.append(
            "there is one scene: nothing is known of how scenes differ, so there are no intervals"
        )
    if beliefs is not None and len(beliefs.trial) and HUMAN not in beliefs.theta:
        warnings.append(f"theta has no label {HUMAN!r}, so that beliefs are not summed up")
    return warnings


def _names(log: xr.Dataset, chosen: Sequence[ChosenTrial]) -> tuple[str, ...]:
    names = log["trial_id"].values
    return tuple(str(names[each.index]) for each in chosen)
