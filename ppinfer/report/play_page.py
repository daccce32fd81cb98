"""The page about a log of parallel play: how fast and how safe robots were, and what they believed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
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
from ppinfer.report.options import NO_SEGMENTS, SEGMENT_OPTIONS, Pair, ReportOptions
from ppinfer.report.parts import Contents, Part, sentence
from ppinfer.report.play_facts import baselines, inferring_trials, personal_robots, play_facts
from ppinfer.report.play_parts import NO_TRUE_THETA, belief_parts, performance_part, play_trials_part
from ppinfer.report.play_trials import choose_plays, how_chosen
from ppinfer.report.sections.condition_tests import compare_conditions, tests_parts
from ppinfer.report.sections.data_sheet import data_part, log_sheet
from ppinfer.report.sections.faults import faults_part
from ppinfer.report.sections.metrics import measured_log, metrics_parts
from ppinfer.report.sections.provenance import log_provenance, made_part
from ppinfer.report.source import Source
from ppinfer.report.trial_choice import named_trials, wanted_trials
from ppinfer.report.written import PageWriter, WrittenReport
from ppinfer.studies.task_performance import TaskPerformance, task_performance

_PLAY_VARIABLES = ("finish_time", "stops", "stop_episodes", "controller")


def is_play_log(log: xr.Dataset) -> bool:
    """Whether a log says how fast and safe agents did their tasks."""
    return all(name in log.variables for name in _PLAY_VARIABLES)


def write_play_page(
    source: Source, log: xr.Dataset, options: ReportOptions, pair: Pair, writer: PageWriter
) -> WrittenReport:
    """Write the page about a log of parallel play; see `ppinfer.report.write_report`."""
    options.refuse(source.given, SEGMENT_OPTIONS, NO_SEGMENTS)
    options.refuse(
        source.given, ("model", "parameters"), "choose{s} how goals are inferred, and this log has none"
    )
    wanted = wanted_trials(log, options.participants, options.exclude)
    measured = measured_log(log, wanted, robot=pair.robot, human=pair.human)
    tested = compare_conditions(measured)
    named = None if options.trials is None else named_trials(log, options.trials)
    performance = _among(task_performance(log, robot=pair.robot, human=pair.human), wanted)
    beliefs = _beliefs(log, pair, wanted)
    against = baselines(performance)
    told: dict[str, list[dict[str, Any]]] = {
        "pooled": performance.pooled(),
        "cells": performance.cells(),
        "differences": performance.differences(against),
    }
    means = _mean_beliefs(beliefs, pair)
    chosen = named or choose_plays(beliefs, pair.human, stops=log["stops"].values, among=wanted)
    drawable = beliefs is not None or "end_effector" in log
    trials: list[Part] = []
    if drawable:
        how = how_chosen(pair.human, stops=True)
        trials = [play_trials_part(log, chosen, pair.robot, pair.human, how, options)]
    about = ", and what the robot believed of the human" if means else ""
    contents = Contents(
        title=str(log.attrs.get("title") or "Parallel play"),
        lead=(
            f"Parallel play in {source.given.name}: a robot and a human, each with a task of its own in the same "
            f"place. How fast they were, how often a safety stop held them{about}."
        ),
        warnings=_warnings(performance, told, beliefs, pair),
        sections={
            "data": [
                data_part(log_sheet(log, shown=len(performance.scene), more=play_facts(performance, beliefs)))
            ],
            "faults": [faults_part(source.checked, what="the log", notes=str(log.attrs.get("notes", "")))],
            "posteriors": [*belief_parts(means, pair.robot, pair.human), *trials]
            or [sentence("The log holds no beliefs.")],
            "calibration": [sentence(NO_TRUE_THETA)],
            "metrics": [
                performance_part(
                    performance,
                    told,
                    compared=[
                        name for name in against if any(row["against"] == name for row in told["differences"])
                    ],
                    robots=personal_robots(performance, beliefs),
                ),
                *metrics_parts(measured),
            ],
            "tests": tests_parts(tested),
            "made": [made_part(source, options, log_provenance(log))],
        },
    )
    names = log["trial_id"].values
    return writer.write(
        contents,
        trials=[str(names[each.index]) for each in chosen] if drawable else [],
        task_performance=told,
        beliefs=tuple(means) if means else None,
        metrics=measured,
        tests=tested,
    )


def _among(performance: TaskPerformance, trials: Bool[np.ndarray, " trial"]) -> TaskPerformance:
    return replace(
        performance, **{item.name: getattr(performance, item.name)[trials] for item in fields(performance)}
    )


def _beliefs(log: xr.Dataset, pair: Pair, wanted: Bool[np.ndarray, " trial"]) -> ReplanBeliefs | None:
    if belief_variable(log) is None:
        return None
    return read_beliefs(log, robot=pair.robot, human=pair.human).among(wanted & inferring_trials(log))


def _mean_beliefs(beliefs: ReplanBeliefs | None, pair: Pair) -> list[MeanBelief]:
    return [] if beliefs is None or pair.human not in beliefs.theta else mean_beliefs(beliefs, pair.human)


def _warnings(
    performance: TaskPerformance,
    told: Mapping[str, list[dict[str, Any]]],
    beliefs: ReplanBeliefs | None,
    pair: Pair,
) -> list[str]:
    warnings = []
    unfinished = round(sum(row["failures"] * row["trials"] for row in told["pooled"]))
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
    if beliefs is not None and len(beliefs.trial) and pair.human not in beliefs.theta:
        warnings.append(f"theta has no label {pair.human!r}, so that beliefs are not summed up")
    return warnings
