"""The page about any log: what was recorded, and where there are goals, the posterior that a model infers."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr
from jaxtyping import Bool

from ppinfer.errors import ImpossibleEvidenceError
from ppinfer.report.facts import configuration_facts
from ppinfer.report.goal_parts import (
    ScoredPosterior,
    calibration_parts,
    headline_parts,
    posterior_parts,
    scored_posterior,
)
from ppinfer.report.log_figures import overview_figure, trial_paths_figure
from ppinfer.report.options import HUMAN, NO_SEGMENTS, SEGMENT_OPTIONS, ReportOptions
from ppinfer.report.parts import Contents, Draw, Part, sentence
from ppinfer.report.score_metrics import score_metrics
from ppinfer.report.sections.condition_tests import Tested, compare_conditions, tests_parts
from ppinfer.report.sections.data_sheet import data_part, log_sheet
from ppinfer.report.sections.faults import faults_part
from ppinfer.report.sections.metrics import Measured, measured_log, metrics_parts
from ppinfer.report.sections.provenance import log_provenance, made_part
from ppinfer.report.source import Source
from ppinfer.report.trial_choice import ChosenTrial, named_trials, wanted_trials
from ppinfer.report.written import PageWriter, WrittenReport
from ppinfer.studies.infer import infer_posterior
from ppinfer.studies.posterior import open_posterior

_MAX_TRIALS = 3


def write_log_page(
    source: Source, log: xr.Dataset, options: ReportOptions, writer: PageWriter
) -> WrittenReport:
    """Write the page about any log; see `ppinfer.report.write_report`."""
    wanted = wanted_trials(log, options.participants, options.exclude)
    if "goal_position" not in log:
        return _write_without_goals(source, options, writer, log, wanted)
    agent = _whose_goals(log, options)
    with _inferred(source, options, agent) as (posterior, impossible):
        scored = None if posterior is None else scored_posterior(posterior, options)
        measured = measured_log(
            log,
            wanted,
            robot=options.robot,
            human=agent,
            more=None if scored is None else score_metrics(scored),
        )
        tested = compare_conditions(measured)
        parts = [sentence(f"{impossible}.")]
        if scored is not None:
            parts = posterior_parts(scored, options, _note(source, options, agent, log))
        figures = [partial(overview_figure, log)]
        contents = _contents(source, options, log, parts, scored, figures, measured, tested, impossible)
        return writer.write(
            contents,
            trials=() if scored is None else scored.shown,
            scores=None if scored is None else scored.scores,
            calibration=None if scored is None else scored.calibration,
            metrics=measured,
            tests=tested,
        )


def _write_without_goals(
    source: Source,
    options: ReportOptions,
    writer: PageWriter,
    log: xr.Dataset,
    wanted: Bool[np.ndarray, " trial"],
) -> WrittenReport:
    options.refuse(source.given, SEGMENT_OPTIONS, NO_SEGMENTS)
    options.refuse(
        source.given, ("model", "parameters"), "choose{s} how goals are inferred, and this log has none"
    )
    chosen = _chosen(log, options, wanted)
    measured = measured_log(log, wanted, robot=options.robot, human=options.human)
    tested = compare_conditions(measured)
    figures = [partial(overview_figure, log), partial(trial_paths_figure, log, chosen)]
    parts = [sentence(_why_no_posterior(log))]
    contents = _contents(source, options, log, parts, None, figures, measured, tested)
    names = log["trial_id"].values
    return writer.write(
        contents, trials=[str(names[each.index]) for each in chosen], metrics=measured, tests=tested
    )


def _contents(
    source: Source,
    options: ReportOptions,
    log: xr.Dataset,
    parts: Sequence[Part],
    scored: ScoredPosterior | None,
    figures: Sequence[Draw],
    measured: Measured,
    tested: Tested,
    impossible: str = "",
) -> Contents:
    agents = [str(name) for name in log["agent"].values]
    who = agents[0] if len(agents) == 1 else f"{len(agents)} agents"
    goals = f" among {log.sizes['goal']} goals" if "goal_position" in log else ""
    model = [] if scored is None else configuration_facts(scored.posterior.attrs["configuration"])
    trials = log.sizes["trial"]
    shown = len(measured.metrics.values)
    return Contents(
        title=str(log.attrs.get("title") or "A study log"),
        lead=f"The log {source.given.name}: {who}{goals}, in {trials:,} trial{'s' * (trials != 1)}.",
        headline=[] if scored is None else headline_parts(scored),
        warnings=[*([impossible] if impossible else []), *([] if scored is None else scored.warnings)],
        sections={
            "data": [data_part(log_sheet(log, shown=shown if shown < trials else None), figures)],
            "faults": [faults_part(source.checked, what="the log", notes=str(log.attrs.get("notes", "")))],
            "posteriors": parts,
            "calibration": [sentence("Nothing was inferred, so there is nothing to check.")]
            if scored is None
            else calibration_parts(scored),
            "metrics": [*_roles(measured), *metrics_parts(measured)],
            "tests": tests_parts(tested),
            "made": [
                made_part(source, options, log_provenance(log), more=[("The posterior on this page", model)])
            ],
        },
    )


def _roles(measured: Measured) -> list[Part]:
    """Say which agents metrics call robot and human, where the log calls them something else."""
    options = measured.metrics.provenance.get("options", {})
    told = [
        f"the {role} is {options[role]}"
        for role in ("robot", "human")
        if options.get(role) not in (None, role)
    ]
    return [sentence(f"In the names of metrics, {' and '.join(told)}.")] if told else []


def _whose_goals(log: xr.Dataset, options: ReportOptions) -> str:
    """Return whose goals are inferred: as asked, the human, or the agent with most segments."""
    agents = [str(name) for name in log["agent"].values]
    if options.human is not None or HUMAN in agents:
        return options.human or HUMAN
    if "segment_agent" not in log:
        return agents[0]
    moving = log["segment_agent"].values.astype(str)
    return max(agents, key=lambda agent: int((moving == agent).sum()))


@contextmanager
def _inferred(source: Source, options: ReportOptions, agent: str) -> Iterator[tuple[xr.Dataset | None, str]]:
    """Yield the posterior that a model infers of a log, in a file that goes again; or why there is none."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "posterior.nc")
        try:
            infer_posterior(source.path, path, options.goal_model(), agent=agent)
        except ImpossibleEvidenceError as error:
            yield None, f"the model rules every goal out, so nothing is inferred: {error}"
            return
        with open_posterior(path) as posterior:
            posterior.attrs["input"] = source.given.name
            yield posterior, ""


def _note(source: Source, options: ReportOptions, agent: str, log: xr.Dataset) -> str:
    model = options.goal_model().name
    unsaid = log.sizes["agent"] > 1 and options.human is None and HUMAN not in log["agent"].values
    whose = f"{agent} (the agent with most segments; --human says another)" if unsaid else agent
    note = (
        "The log comes without a posterior over goals. For this page, that over the goals of "
        f"{whose} was inferred by {model}, {options.model_origin()}."
    )
    if options.is_fitted:
        return note
    return f"{note} (“ppinfer fit {source.given.name} --model {model} -o MODEL.toml”, then “--model MODEL.toml” here.)"


def _why_no_posterior(log: xr.Dataset) -> str:
    if "replan_row_size" in log:
        return (
            "The log has replans and no goals. --robot and --human say which of its agents these are: then the page "
            "has what was believed over theta. “ppinfer infer --model personality” infers that anew."
        )
    return "The log has no goals, so nothing is inferred."


def _chosen(
    log: xr.Dataset, options: ReportOptions, wanted: Bool[np.ndarray, " trial"]
) -> tuple[ChosenTrial, ...]:
    if options.trials is not None:
        return tuple(named_trials(log, options.trials))
    among = np.flatnonzero(wanted)
    places = np.unique(np.linspace(0, len(among) - 1, min(_MAX_TRIALS, len(among))).astype(int))
    return tuple(ChosenTrial(int(among[place]), "chosen by their places in the file") for place in places)
