"""The page about a posterior over theta: whom humans' choices of equilibria favour."""

from __future__ import annotations

import json
import shlex
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from ppinfer.plots.replan_beliefs import MeanBelief, ReplanBeliefs, mean_beliefs, read_beliefs
from ppinfer.report.facts import Facts, provenance
from ppinfer.report.play_facts import counted, wanted_trials
from ppinfer.report.play_figures import belief_figure, play_trial_figure
from ppinfer.report.play_trials import choose_plays, how_chosen
from ppinfer.report.rendering import render
from ppinfer.report.trial_choice import named_trials
from ppinfer.report.written import Drawn, Progress, WrittenReport
from ppinfer.studies.personality_inference import live_difference
from ppinfer.studies.posterior_layout import POSTERIOR_FORMAT
from ppinfer.studies.storage import stated_format, stated_hypothesis
from ppinfer.studies.theta_posterior import HYPOTHESIS, read_theta_posterior

ROBOT, HUMAN = "robot", "human"
# what the command calls the models that logs name
_VARIANTS = {
    "personality": "repaired",
    "personality-literal": "literal",
    "personality-predictive": "predictive",
}


def is_theta_posterior(source: Path) -> bool:
    """Whether a file is a posterior over theta."""
    return (
        source.is_file()
        and stated_format(source) == POSTERIOR_FORMAT
        and stated_hypothesis(source) == HYPOTHESIS
    )


@dataclass(frozen=True)
class _Told:
    beliefs: list[MeanBelief]


def write_theta_page(
    source: Path,
    target: Path,
    *,
    trials: Sequence[str] | None,
    participants: Sequence[str] | None,
    exclude: Sequence[str] | None,
    progress: Progress,
) -> WrittenReport:
    """Write the page about a posterior over theta; see `ppinfer.report.write_report`."""
    posterior = read_theta_posterior(source)
    viewer, other = _viewer_and_other(posterior)
    wanted = wanted_trials(posterior, participants, exclude)
    chosen = None if trials is None else named_trials(posterior, trials)
    beliefs = read_beliefs(posterior, robot=viewer, human=other).among(wanted)
    told = _Told(mean_beliefs(beliefs, other) if other in beliefs.theta else [])
    warnings = []
    if other not in beliefs.theta:
        warnings.append(f"theta has no label {other!r}, so that beliefs are not summed up")
    if chosen is None:
        chosen = choose_plays(beliefs, other, stops=None, among=wanted)
    drawn = Drawn(progress, total=len(chosen) + (1 if told.beliefs else 0))
    page = render(
        "theta.html.j2",
        title=f"Whom does the {other} favour?",
        viewer=viewer,
        other=other,
        source=source.name,
        attrs=posterior.attrs,
        told=told,
        warnings=warnings,
        how_chosen=how_chosen(other, stops=False) if trials is None else "Chosen by name.",
        belief_figure=drawn.add(belief_figure(told.beliefs)) if told.beliefs else None,
        trial_figures=[
            drawn.add(
                play_trial_figure(
                    posterior, each.index, viewer=viewer, other=other, number=number, why=each.why
                )
            )
            for number, each in enumerate(chosen, start=1)
        ],
        data_sheet=_sheet(posterior, beliefs, viewer, other),
        provenance=[*provenance(posterior, source, states=False), *_models(posterior)],
        command=_command(posterior, source),
    )
    names = posterior["trial_id"].values
    return WrittenReport(
        page=target / "index.html",
        figures=drawn.write(target, page),
        trials=tuple(str(names[each.index]) for each in chosen),
        warnings=tuple(warnings),
        beliefs=tuple(told.beliefs) if told.beliefs else None,
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
