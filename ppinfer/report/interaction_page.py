"""The page about two agents among goals: what the human will do given what the robot does, and how safe that is."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float, Int

from ppinfer.errors import LogError
from ppinfer.goals import infer_goals
from ppinfer.goals.coupled import GoalCoupled
from ppinfer.report.facts import Facts, configuration_facts, shown_time
from ppinfer.report.interaction_choice import (
    HOW_CHOSEN,
    MIN_SAMPLES,
    StretchNumbers,
    choose_stretches,
    named_stretches,
    stretch_numbers,
)
from ppinfer.report.interaction_figures import game_figure, interaction_figure, safety_figure
from ppinfer.report.play_facts import counted, log_provenance, wanted_trials
from ppinfer.report.rendering import render
from ppinfer.report.trial_choice import named_trials
from ppinfer.report.written import Drawn, Progress, WrittenReport
from ppinfer.studies.assumed_reactions import assumed_reactions, robots_of_ones_own, told_reactions
from ppinfer.studies.blocks import iter_blocks
from ppinfer.studies.conditional_beliefs import infer_log_conditional, other_agent
from ppinfer.studies.faults import Report
from ppinfer.studies.game_performance import GAME_METRICS, GamePerformance, game_performance
from ppinfer.studies.goal_evidence import goal_evidence
from ppinfer.studies.interaction import (
    Interaction,
    Stretch,
    live_names,
    live_probabilities,
    read_interaction,
    stretches,
)
from ppinfer.studies.log_inference import default_agent, nominal_time_step, posterior_dataset
from ppinfer.studies.schema import FORMAT
from ppinfer.studies.scores import score_posterior
from ppinfer.studies.segment_selection import SegmentOptions, describe_left_out, select_segments
from ppinfer.studies.storage import open_log, stated_format
from ppinfer.studies.trial_selection import select_trials
from ppinfer.studies.validation import validate_log

_BLOCK_SAMPLES = 1 << 17
ROBOT, HUMAN = "robot", "human"
# robots that others are compared with, where they played
_BASELINES = ("naive", "reactive")
BELIEFS = {
    "log_belief": "without the robot",
    "log_given": "given the robot's goal",
    "log_overall": "overall",
}


#: A model that learned from people what a partner's motion tells; the other beliefs have no fitted parameter.
COUPLED = GoalCoupled.name


def is_interaction_log(source: Path) -> bool:
    """Whether a file is a study log of two agents among goals in the plane."""
    is_log = (source / "zarr.json").is_file() if source.is_dir() else stated_format(source) == FORMAT
    if not is_log:
        return False
    with open_log(source) as log:
        return "goal_position" in log and log.sizes["agent"] == 2 and log.sizes["space"] == 2


@dataclass(frozen=True, eq=False)
class _Inferred:
    """Beliefs at every sample of the log, and what the choice of interactions depends on."""

    values: dict[str, Float[np.ndarray, "sample goal"]]
    numbers: StretchNumbers
    whole: Bool[np.ndarray, " stretch"]
    attrs: dict[str, Any]


def write_interaction_page(
    source: Path,
    target: Path,
    *,
    trials: Sequence[str] | None,
    at: Sequence[float],
    selection: SegmentOptions,
    progress: Progress,
) -> WrittenReport:
    """Write the page about a log of two agents among goals; see `ppinfer.report.write_report`."""
    checked = validate_log(source)
    with open_log(source) as log:
        if not checked.ok:
            return _write_faults(source, target, log, checked)
        agent = default_agent(log)
        wanted = wanted_trials(log, selection.get("participants"), selection.get("exclude"))
        named = None if trials is None else [each.index for each in named_trials(log, trials)]
        inferred = _infer(source, log, agent)
        performance = _performance(log, wanted)
        scores, left_out = _scores(log, agent, inferred, at=at, selection=selection)
        if named is None:
            chosen = choose_stretches(
                inferred.numbers,
                wanted[[one.trial for one in inferred.numbers.stretches]],
                whole=inferred.whole,
            )
        else:
            chosen = named_stretches(inferred.numbers, named)
        shown = [_read(log, each.stretch, agent) for each in chosen]
        safe = _nearest(shown)
        drawn = Drawn(progress, total=(performance is not None) + len(shown) + (safe is not None))
        warnings = _warnings(scores, left_out)
        told = None if performance is None else _told(performance)
        page = render(
            "interaction.html.j2",
            title=str(log.attrs.get("title") or "Two agents among goals"),
            source=source.name,
            agent=agent,
            partner=inferred.attrs["partner"],
            told=told,
            metrics=GAME_METRICS,
            game_figure=None if told is None else drawn.add(game_figure(told["cells"])),
            interaction_figures=[
                drawn.add(interaction_figure(one, number=number, why=each.why))
                for number, (one, each) in enumerate(zip(shown, chosen, strict=True), start=1)
            ],
            safety_figure=None if safe is None else drawn.add(safety_figure(safe)),
            scores=scores,
            coupled=COUPLED,
            own_robots=robots_of_ones_own(log, inferred.attrs["partner"]) if live_names(log) else (),
            left_out=left_out,
            how_chosen=HOW_CHOSEN
            if trials is None
            else "Chosen by name; of each trial, the stretch in which the robot makes most of a difference.",
            faults=[],
            notes_of_check=checked.lines(),
            warnings=warnings,
            data_sheet=_sheet(log, inferred, performance),
            provenance=log_provenance(log, source),
            model=configuration_facts(inferred.attrs["configuration"]),
            command=_command(source, target, trials, at, selection),
        )
        names = tuple(dict.fromkeys(one.trial_id for one in shown))
    return WrittenReport(
        page=target / "index.html",
        figures=drawn.write(target, page),
        trials=names,
        warnings=tuple(warnings),
        game_performance=told,
        conditional_scores=tuple(scores),
    )


def _infer(source: Path, log: xr.Dataset, agent: str) -> _Inferred:
    partner = other_agent(log, agent)
    step = nominal_time_step(log)
    parts: dict[str, list[np.ndarray]] = {name: [] for name in BELIEFS}
    found: list[Stretch] = []
    differences: list[np.ndarray] = []
    gains: list[np.ndarray] = []
    attrs: dict[str, Any] = {}
    coupled: list[np.ndarray] = []
    trial = sample = 0
    for block in iter_blocks(source, max_samples=_BLOCK_SAMPLES):
        beliefs = infer_log_conditional(block, agent=agent, partner=partner, time_step=step)
        attrs = dict(beliefs.attrs)
        goals = goal_evidence(block, agent, time_step=step)
        coupled.append(infer_goals(GoalCoupled(), goals).log_posterior)
        for name, held in parts.items():
            held.append(beliefs[name].values)
        here = stretches(block, agent)
        numbers = stretch_numbers(
            here,
            np.exp(beliefs["log_belief"].values),
            np.exp(beliefs["log_given"].values),
            _true_goals(block, agent),
        )
        found += [Stretch(one.trial + trial, one.start + sample, one.stop + sample) for one in here]
        differences.append(numbers.difference)
        gains.append(numbers.gain)
        trial, sample = trial + block.sizes["trial"], sample + block.sizes["sample"]
    # a block need not hold every robot
    configuration = json.loads(attrs["configuration"])
    configuration["conditional"] = told_reactions(assumed_reactions(log, partner))
    configuration[COUPLED] = "its default parameters"
    attrs["configuration"] = json.dumps(configuration, allow_nan=False)
    held_goals = {BELIEFS[name]: np.concatenate(held) for name, held in parts.items()}
    return _Inferred(
        held_goals | {COUPLED: np.concatenate(coupled)},
        StretchNumbers(tuple(found), np.concatenate(differences), np.concatenate(gains)),
        np.array([one.stop - one.start >= MIN_SAMPLES for one in found]),
        attrs,
    )


def _true_goals(log: xr.Dataset, agent: str) -> Int[np.ndarray, " sample"]:
    """Return the true goal of the agent's segment at every sample; -1 where there is none."""
    found = np.full(log.sizes["sample"], -1, np.int64)
    if "segment_trial" not in log:
        return found
    labels = {str(goal): index for index, goal in enumerate(log["goal"].values)}
    first = np.cumsum(log["row_size"].values) - log["row_size"].values
    for at in np.flatnonzero(log["segment_agent"].values.astype(str) == agent).tolist():
        start = int(first[log["segment_trial"].values[at]])
        here = slice(
            start + int(log["segment_start"].values[at]), start + int(log["segment_stop"].values[at])
        )
        found[here] = labels.get(str(log["true_goal"].values[at]), -1)
    return found


def _read(log: xr.Dataset, stretch: Stretch, agent: str) -> Interaction:
    first = int(log["row_size"].values[: stretch.trial].sum())
    one = select_trials(log, [stretch.trial]).load()
    beliefs = infer_log_conditional(one, agent=agent, time_step=nominal_time_step(log))
    return read_interaction(one, beliefs, Stretch(0, stretch.start - first, stretch.stop - first))


def _nearest(shown: Sequence[Interaction]) -> Interaction | None:
    """Return the interaction in which the agents came nearest to each other, of those where both were seen."""
    near = [one for one in shown if not np.isnan(one.apart).all()]
    return min(near, key=lambda one: float(np.nanmin(one.apart)), default=None)


def _performance(log: xr.Dataset, wanted: Bool[np.ndarray, " trial"]) -> GamePerformance | None:
    try:
        found = game_performance(log, robot=ROBOT, human=HUMAN)
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


def _scores(
    log: xr.Dataset, agent: str, inferred: _Inferred, *, at: Sequence[float], selection: SegmentOptions
) -> tuple[list[dict[str, Any]], str]:
    """Return the scores of every belief, on the same segments, and what was left out."""
    evidence = goal_evidence(log, agent)
    held = dict(inferred.values)
    for name, said in zip(live_names(log), ("without the robot", "given the robot"), strict=False):
        with np.errstate(divide="ignore"):
            live = np.log(live_probabilities(log, name))
        if not np.isnan(live).any():
            held[f"live, {said} ({name})"] = live
    told, left_out = [], ""
    for name, values in held.items():
        posterior = posterior_dataset(log, evidence, values, agent, {"model": name})
        if not len(select_segments(posterior, **selection).index):
            return [], describe_left_out(select_segments(posterior, **selection).left_out)
        scores = score_posterior(posterior, at=at, **selection)
        left_out = describe_left_out(scores.left_out)
        told += [{"belief": name, **asdict(score)} for score in scores.overall]
    return told, left_out


def _warnings(scores: list[dict[str, Any]], left_out: str) -> list[str]:
    if not scores:
        said = left_out or "the log names no segments of it with true goals"
        return [f"no belief can be scored: {said}"]
    return [
        f"{row['belief']}: at {row['at']:g} the true goal of {row['impossible']} of {row['segments']} segments has "
        "probability zero, so the mean log posterior is -inf"
        for row in scores
        if row["impossible"]
    ]


def _sheet(log: xr.Dataset, inferred: _Inferred, performance: GamePerformance | None) -> Facts:
    sizes = log["row_size"].values
    ends = np.cumsum(sizes) - 1
    time = log["time"].values
    step = nominal_time_step(log)
    facts = [
        ("trials", f"{log.sizes['trial']:,}"),
        ("participants", f"{len(np.unique(log['participant'].values.astype(str))):,}"),
        ("samples", f"{log.sizes['sample']:,}"),
        ("recorded time", shown_time(float((time[ends] - time[ends - sizes + 1]).sum()))),
        ("time between samples", "one sample a trial" if step is None else f"{step:.3g} s (median)"),
        ("samples a trial", f"{sizes.min():,} to {sizes.max():,} (median {np.median(sizes):,.0f})"),
        ("agents", ", ".join(str(name) for name in log["agent"].values)),
        ("goals", f"{log.sizes['goal']}: {', '.join(str(goal) for goal in log['goal'].values[:12])}"),
        ("stretches with the same goals throughout", f"{len(inferred.numbers.stretches):,}"),
        ("segments", f"{log.sizes.get('segment', 0):,}"),
        ("units of position", str(log["position"].attrs.get("units", "m"))),
        ("beliefs held live", ", ".join(live_names(log)) or "none"),
    ]
    if performance is not None:
        facts[1:1] = [
            ("trials on this page", f"{len(performance.scene):,}"),
            ("robots", counted(performance.robot.tolist())),
            ("humans", counted(performance.human.tolist())),
        ]
    elif "condition" in log:
        facts.append(("trials by condition", counted(log["condition"].values.astype(str).tolist())))
    return facts


def _command(
    source: Path,
    target: Path,
    trials: Sequence[str] | None,
    at: Sequence[float],
    selection: SegmentOptions,
) -> str:
    words = ["ppinfer", "report", source.name, "-o", target.name]
    if trials is not None:
        words += ["--trials", *trials]
    words += ["--at", *(f"{share:g}" for share in at)]
    for option, value in selection.items():
        if value is None:
            continue
        values = value if isinstance(value, list | tuple) else [value]
        words += [f"--{option.replace('_', '-')}", *map(str, values)]
    return shlex.join(words)


def _write_faults(source: Path, target: Path, log: xr.Dataset, checked: Report) -> WrittenReport:
    count = sum(checked.fault_counts.values())
    warnings = [
        f"the log has {count} fault{'s' * (count != 1)}, so nothing is concluded from it; mend it "
        "(see 'ppinfer validate')"
    ]
    page = render(
        "interaction.html.j2",
        title=str(log.attrs.get("title") or "Two agents among goals"),
        source=source.name,
        agent=HUMAN,
        partner=ROBOT,
        told=None,
        metrics=GAME_METRICS,
        game_figure=None,
        interaction_figures=[],
        safety_figure=None,
        scores=[],
        coupled=COUPLED,
        own_robots=(),
        left_out="",
        how_chosen="",
        faults=checked.lines(),
        notes_of_check=[],
        warnings=warnings,
        data_sheet=[(name, f"{size:,}") for name, size in checked.sizes.items()],
        provenance=log_provenance(log, source),
        model=[],
        command="",
    )
    return WrittenReport(
        page=target / "index.html",
        figures=Drawn(None, total=0).write(target, page),
        trials=(),
        warnings=tuple(warnings),
    )
