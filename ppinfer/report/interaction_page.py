"""The page about two agents among goals: what the human will do given what the robot does, and how safe that is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Bool

from ppinfer.errors import LogError
from ppinfer.goals import GoalModel
from ppinfer.goals.coupled import GoalCoupled
from ppinfer.report.facts import Facts, configuration_facts, counted
from ppinfer.report.figures import calibration_figure
from ppinfer.report.interaction_beliefs import (
    COUPLED,
    InferredBeliefs,
    ScoredBelief,
    belief_warnings,
    infer_beliefs,
    read_stretch,
    score_beliefs,
)
from ppinfer.report.interaction_choice import HOW_CHOSEN, ChosenStretch, choose_stretches, named_stretches
from ppinfer.report.interaction_figures import game_figure, interaction_figure, safety_figure
from ppinfer.report.options import Pair, ReportOptions
from ppinfer.report.parts import Contents, Part, sentence
from ppinfer.report.sections.condition_tests import compare_conditions, tests_parts
from ppinfer.report.sections.data_sheet import data_part, log_sheet
from ppinfer.report.sections.faults import faults_part
from ppinfer.report.sections.metrics import measured_log, metrics_parts
from ppinfer.report.sections.provenance import log_provenance, made_part
from ppinfer.report.source import Source
from ppinfer.report.trial_choice import named_trials, wanted_trials
from ppinfer.report.written import PageWriter, WrittenReport
from ppinfer.studies.assumed_reactions import robots_of_ones_own
from ppinfer.studies.game_performance import GAME_METRICS, GamePerformance, game_performance
from ppinfer.studies.interaction import Interaction, live_names

# robots that others are compared with, where they played
_BASELINES = ("naive", "reactive")


def is_interaction_log(log: xr.Dataset) -> bool:
    """Whether a log is of two agents among goals in the plane."""
    return "goal_position" in log and log.sizes["agent"] == 2 and log.sizes["space"] == 2


@dataclass(frozen=True, eq=False)
class _Shown:
    """The interactions on the page, and the one in which the agents came nearest to each other."""

    interactions: tuple[Interaction, ...]
    chosen: tuple[ChosenStretch, ...]

    @property
    def nearest(self) -> Interaction | None:
        near = [one for one in self.interactions if not np.isnan(one.apart).all()]
        return min(near, key=lambda one: float(np.nanmin(one.apart)), default=None)


def write_interaction_page(
    source: Source, log: xr.Dataset, options: ReportOptions, pair: Pair, writer: PageWriter
) -> WrittenReport:
    """Write the page about a log of two agents among goals; see `ppinfer.report.write_report`."""
    wanted = wanted_trials(log, options.participants, options.exclude)
    measured = measured_log(log, wanted, robot=pair.robot, human=pair.human)
    tested = compare_conditions(measured)
    named = None if options.trials is None else [each.index for each in named_trials(log, options.trials)]
    models: dict[str, GoalModel] = {COUPLED: GoalCoupled()}
    if options.model is not None or options.parameters:
        model = options.goal_model()
        models[f"{model.name} {options.model_origin().partition(',')[0]}"] = model
    inferred = infer_beliefs(source.path, log, pair, models)
    performance = _performance(log, pair, wanted)
    scored, left_out = score_beliefs(log, pair, inferred, options)
    scores = [row for each in scored for row in each.scores]
    shown = _shown(log, pair, inferred, wanted, named)
    told = None if performance is None else _told(performance)
    contents = Contents(
        title=str(log.attrs.get("title") or "Two agents among goals"),
        lead=(
            f"A {pair.human} and a {pair.robot} among goals in {source.given.name}: where the {pair.human} will "
            f"go, given what the {pair.robot} does, and how safe the {pair.robot} is among where they may go."
        ),
        warnings=belief_warnings(scores, left_out),
        sections={
            "data": [data_part(log_sheet(log, more=_facts(log, inferred, performance)))],
            "faults": [faults_part(source.checked, what="the log", notes=str(log.attrs.get("notes", "")))],
            "posteriors": [
                *_interaction_parts(log, pair, shown, by_name=named is not None),
                *_score_parts(scores, pair, left_out),
                *_safety_parts(shown, pair),
            ],
            "calibration": [_calibration_part(scored)],
            "metrics": [*([] if told is None else [_game_part(told)]), *metrics_parts(measured)],
            "tests": tests_parts(tested),
            "made": [
                made_part(
                    source,
                    options,
                    log_provenance(log),
                    more=[("The beliefs on this page", _model_facts(inferred, models, options))],
                )
            ],
        },
    )
    return writer.write(
        contents,
        trials=tuple(dict.fromkeys(one.trial_id for one in shown.interactions)),
        game_performance=told,
        conditional_scores=tuple(scores),
        metrics=measured,
        tests=tested,
    )


def _shown(
    log: xr.Dataset,
    pair: Pair,
    inferred: InferredBeliefs,
    wanted: Bool[np.ndarray, " trial"],
    named: Sequence[int] | None,
) -> _Shown:
    numbers = inferred.numbers
    if named is None:
        among = wanted[[one.trial for one in numbers.stretches]]
        chosen = choose_stretches(numbers, among, whole=inferred.whole)
    else:
        chosen = named_stretches(numbers, named)
    return _Shown(tuple(read_stretch(log, each.stretch, pair) for each in chosen), tuple(chosen))


def _interaction_parts(log: xr.Dataset, pair: Pair, shown: _Shown, *, by_name: bool) -> list[Part]:
    if not shown.interactions:
        return []
    how = "Chosen by name; of each trial, the stretch in which the robot makes most of a difference."
    return [
        Part(
            "interactions/stretches.html.j2",
            {
                "agent": pair.human,
                "partner": pair.robot,
                "how_chosen": how if by_name else HOW_CHOSEN,
                "own_robots": robots_of_ones_own(log, pair.robot) if live_names(log) else (),
            },
            {
                "figures": [
                    partial(interaction_figure, one, number=number, why=each.why)
                    for number, (one, each) in enumerate(
                        zip(shown.interactions, shown.chosen, strict=True), start=1
                    )
                ]
            },
        )
    ]


def _score_parts(scores: Sequence[dict[str, Any]], pair: Pair, left_out: str) -> list[Part]:
    if not scores:
        return []
    context = {
        "scores": scores,
        "agent": pair.human,
        "partner": pair.robot,
        "coupled": COUPLED,
        "left_out": left_out,
    }
    return [Part("interactions/scores.html.j2", context)]


def _safety_parts(shown: _Shown, pair: Pair) -> list[Part]:
    if shown.nearest is None:
        return []
    return [
        Part(
            "interactions/safety.html.j2",
            {"partner": pair.robot},
            {"figures": [partial(safety_figure, shown.nearest)]},
        )
    ]


def _calibration_part(scored: Sequence[ScoredBelief]) -> Part:
    if not scored:
        return sentence("Without true goals nothing is known of how often beliefs come true.")
    (drawn,) = (each for each in scored if each.name == COUPLED)
    return Part(
        "interactions/calibration.html.j2",
        {"beliefs": scored, "drawn": COUPLED},
        {"figures": [partial(calibration_figure, drawn.calibration)]},
    )


def _game_part(told: dict[str, list[dict[str, Any]]]) -> Part:
    return Part(
        "interactions/game.html.j2",
        {"told": told, "metrics": GAME_METRICS},
        {"figures": [partial(game_figure, told["cells"])]},
    )


def _performance(log: xr.Dataset, pair: Pair, wanted: Bool[np.ndarray, " trial"]) -> GamePerformance | None:
    try:
        found = game_performance(log, robot=pair.robot, human=pair.human)
    except LogError:
        return None
    return replace(found, **{item.name: getattr(found, item.name)[wanted] for item in fields(found)})


def _told(performance: GamePerformance) -> dict[str, list[dict[str, Any]]]:
    robots = set(performance.robot.tolist())
    against = [name for name in _BASELINES if name in robots]
    return {
        "pooled": performance.pooled(),
        "cells": performance.cells(),
        "differences": performance.differences(against),
    }


def _facts(log: xr.Dataset, inferred: InferredBeliefs, performance: GamePerformance | None) -> Facts:
    facts = (
        []
        if performance is None
        else [
            ("robots", counted(performance.robot.tolist())),
            ("humans", counted(performance.human.tolist())),
        ]
    )
    return [
        *facts,
        ("stretches with the same goals throughout", f"{len(inferred.numbers.stretches):,}"),
        ("beliefs held live", ", ".join(live_names(log)) or "none"),
    ]


def _model_facts(inferred: InferredBeliefs, models: dict[str, GoalModel], options: ReportOptions) -> Facts:
    facts = configuration_facts(inferred.attrs["configuration"])
    for name, model in models.items():
        told = ", ".join(f"{key} = {value}" for key, value in model.parameters.items())
        origin = "its default parameters" if name == COUPLED else options.model_origin()
        facts.append((name, f"{origin}: {told}"))
    return facts
