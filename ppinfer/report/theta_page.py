"""The page about a posterior over theta: whom humans' choices of equilibria favour."""

from __future__ import annotations

import json
import shlex
from collections import Counter
from pathlib import Path

import numpy as np
import xarray as xr

from ppinfer.plots.replan_beliefs import ReplanBeliefs, mean_beliefs, read_beliefs
from ppinfer.report.facts import Facts, counted
from ppinfer.report.options import HUMAN, NO_SEGMENTS, OF_LOGS_ONLY, ROBOT, SEGMENT_OPTIONS, ReportOptions
from ppinfer.report.parts import Contents, sentence
from ppinfer.report.play_parts import NO_TRUE_THETA, belief_parts, play_trials_part
from ppinfer.report.play_trials import choose_plays, how_chosen
from ppinfer.report.score_metrics import belief_metrics
from ppinfer.report.sections.condition_tests import compare_conditions, tests_parts
from ppinfer.report.sections.data_sheet import data_part
from ppinfer.report.sections.faults import faults_part
from ppinfer.report.sections.metrics import Measured, among, metrics_parts
from ppinfer.report.sections.provenance import made_part, posterior_provenance
from ppinfer.report.source import Source
from ppinfer.report.trial_choice import named_trials, wanted_trials
from ppinfer.report.written import PageWriter, WrittenReport
from ppinfer.studies.personality_inference import live_difference
from ppinfer.studies.theta_posterior import read_theta_posterior

# what the command calls the models that logs name
_VARIANTS = {
    "personality": "repaired",
    "personality-literal": "literal",
    "personality-predictive": "predictive",
}


def write_theta_page(source: Source, options: ReportOptions, writer: PageWriter) -> WrittenReport:
    """Write the page about a posterior over theta; see `ppinfer.report.write_report`."""
    options.refuse(source.given, SEGMENT_OPTIONS, NO_SEGMENTS)
    options.refuse(source.given, ("model", "parameters", "robot", "human"), OF_LOGS_ONLY)
    posterior = read_theta_posterior(source.path)
    viewer, other = _viewer_and_other(posterior)
    wanted = wanted_trials(posterior, options.participants, options.exclude)
    beliefs = read_beliefs(posterior, robot=viewer, human=other).among(wanted)
    told = mean_beliefs(beliefs, other) if other in beliefs.theta else []
    warnings = []
    if other not in beliefs.theta:
        warnings.append(f"theta has no label {other!r}, so that beliefs are not summed up")
    measured = None
    if told:
        metrics = belief_metrics(posterior, beliefs, other)
        measured = Measured.of(among(metrics, wanted & ~np.isnan(metrics.values[:, 0])))
    tested = None if measured is None else compare_conditions(measured)
    if options.trials is None:
        chosen = choose_plays(beliefs, other, stops=None, among=wanted)
    else:
        chosen = named_trials(posterior, options.trials)
    attrs = posterior.attrs
    contents = Contents(
        title=f"Whom does the {other} favour?",
        lead=(
            f"The posterior over theta in {source.given.name}, inferred by the model “{attrs.get('model', 'unknown')}” "
            f"from {attrs.get('input', 'a study log')}: at every replan of the {viewer}, whom the {other}'s choice of "
            "equilibria favours, given what was seen so far."
        ),
        warnings=warnings,
        sections={
            "data": [data_part(_sheet(posterior, beliefs, viewer, other))],
            "faults": [faults_part(source.checked, what="the posterior")],
            "posteriors": [
                *belief_parts(told, viewer, other),
                play_trials_part(posterior, chosen, viewer, other, how_chosen(other, stops=False), options),
            ],
            "calibration": [sentence(NO_TRUE_THETA)],
            "metrics": metrics_parts(measured)
            if measured
            else [sentence("There are no beliefs to measure.")],
            "tests": tests_parts(tested)
            if tested
            else [sentence("Nothing is tested, since nothing is measured.")],
            "made": [
                made_part(
                    source,
                    options,
                    [*posterior_provenance(posterior, states=False), *_models(posterior)],
                    posterior_command=_command(posterior, source.given),
                )
            ],
        },
    )
    names = posterior["trial_id"].values
    return writer.write(
        contents,
        trials=[str(names[each.index]) for each in chosen],
        beliefs=tuple(told) if told else None,
        metrics=measured,
        tests=tested,
    )


def _viewer_and_other(posterior: xr.Dataset) -> tuple[str, str]:
    """Return whose beliefs they are, and the first of those that they are about."""
    viewer = str(posterior.attrs.get("agent", ROBOT))
    others = [str(agent) for agent in posterior["agent"].values if str(agent) != viewer]
    return viewer, others[0] if others else HUMAN


def _sheet(posterior: xr.Dataset, beliefs: ReplanBeliefs, viewer: str, other: str) -> Facts:
    replans = posterior["replan_row_size"].values
    compared, difference = live_difference(posterior)
    facts = [
        ("trials", f"{posterior.sizes['trial']:,}"),
        ("participants", f"{len(np.unique(posterior['participant'].values.astype(str))):,}"),
        (f"who controlled the {viewer}", counted(beliefs.robot.tolist())),
        (f"who controlled the {other}", counted(beliefs.human.tolist())),
        ("plan sets", counted(beliefs.plan_sets.tolist())),
        ("replans", f"{int(replans.sum()):,} (median {np.median(replans):,.0f} a trial)"),
        ("theta", ", ".join(beliefs.theta)),
    ]
    if difference is not None:
        facts.append(
            (
                "against what was believed live",
                f"probabilities differ by at most {difference:.2g}, at {compared:,} replans",
            )
        )
    return facts


def _models(posterior: xr.Dataset) -> Facts:
    counts = Counter(str(text) for text in posterior["model"].values)
    return [(f"applied to {count:,} trial{'s' * (count != 1)}", text) for text, count in counts.most_common()]


def _command(posterior: xr.Dataset, path: Path) -> str:
    attrs = posterior.attrs
    words = ["ppinfer", "infer", str(attrs.get("input", "LOG.nc")), "-o", path.name, "--model", "personality"]
    try:
        applied = json.loads(str(attrs.get("configuration")))["applied"]
        if applied is not None:
            words += ["--variant", _VARIANTS[applied["model"]], "--set"]
            words += [f"{name}={_setting(value)}" for name, value in applied["parameters"].items()]
    except (ValueError, KeyError, TypeError, AttributeError):
        # a model of somebody's own: its page says what it was, no command makes it
        return "(made by a program with a model of its own)"
    return shlex.join([*words, "--agent", str(attrs.get("agent")), "--seed", str(attrs.get("seed", 0))])


def _setting(value: object) -> str:
    return "none" if value is None else value if isinstance(value, str) else json.dumps(value)
