"""The page about a posterior over theta: whom humans' choices of equilibria favour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from ppinfer.errors import LogError
from ppinfer.plots.replan_beliefs import (
    MeanBelief,
    ReplanBeliefs,
    belief_variable,
    mean_beliefs,
    read_beliefs,
)
from ppinfer.report.facts import Facts, command, provenance
from ppinfer.report.play_facts import counted, wanted_trials
from ppinfer.report.play_figures import belief_figure, play_trial_figure
from ppinfer.report.play_trials import HOW_CHOSEN, choose_plays
from ppinfer.report.rendering import render
from ppinfer.report.trial_choice import named_trials
from ppinfer.report.written import Drawn, Progress, WrittenReport
from ppinfer.studies.posterior_layout import POSTERIOR_FORMAT, READ_OPTIONS
from ppinfer.studies.storage import stated_format, told_as_log_error

HUMAN = "human"


def is_theta_posterior(source: Path) -> bool:
    """Whether a file is a posterior over theta."""
    if source.is_dir() or stated_format(source) != POSTERIOR_FORMAT:
        return False
    with _open(source) as posterior:
        return posterior.attrs.get("hypothesis") == "theta"


def _open(source: Path) -> xr.Dataset:
    with told_as_log_error(source, "infer it anew with 'ppinfer infer'"):
        return xr.open_dataset(source, engine="h5netcdf", **READ_OPTIONS)


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
    with _open(source) as posterior:
        if belief_variable(posterior) is None:
            raise LogError(
                f"{source}: says that it is a posterior over theta, but has no log_posterior of it"
            )
        wanted = wanted_trials(posterior, participants, exclude)
        chosen = None if trials is None else named_trials(posterior, trials)
        beliefs = read_beliefs(posterior).among(wanted)
        told = _Told(mean_beliefs(beliefs, HUMAN) if HUMAN in beliefs.theta else [])
        warnings = []
        if not len(beliefs.trial):
            warnings.append("no replan holds a belief")
        elif HUMAN not in beliefs.theta:
            warnings.append(f"theta has no label {HUMAN!r}, so that beliefs are not summed up")
        if chosen is None:
            stops = posterior["stops"].values if "stops" in posterior else None
            chosen = choose_plays(beliefs, HUMAN, stops=stops, among=wanted)
        drawn = Drawn(progress, total=len(chosen) + (1 if told.beliefs else 0))
        page = render(
            "theta.html.j2",
            title="Whom does the human favour?",
            source=source.name,
            attrs=posterior.attrs,
            told=told,
            warnings=warnings,
            how_chosen=HOW_CHOSEN if trials is None else "Chosen by name.",
            belief_figure=drawn.add(belief_figure(told.beliefs)) if told.beliefs else None,
            trial_figures=[
                drawn.add(play_trial_figure(posterior, each.index, number=number, why=each.why))
                for number, each in enumerate(chosen, start=1)
            ],
            data_sheet=_sheet(posterior, beliefs),
            provenance=provenance(posterior, source),
            command=command(posterior, source),
        )
        names = posterior["trial_id"].values
        shown = tuple(str(names[each.index]) for each in chosen)
    return WrittenReport(
        page=target / "index.html",
        figures=drawn.write(target, page),
        trials=shown,
        warnings=tuple(warnings),
        beliefs=tuple(told.beliefs) if told.beliefs else None,
    )


def _sheet(posterior: xr.Dataset, beliefs: ReplanBeliefs) -> Facts:
    replans = posterior["replan_row_size"].values
    return [
        ("trials", f"{posterior.sizes['trial']:,}"),
        ("participants", f"{len(np.unique(posterior['participant'].values.astype(str))):,}"),
        ("robots", counted(beliefs.robot.tolist())),
        ("humans", counted(beliefs.human.tolist())),
        ("plan sets", counted(beliefs.plan_sets.tolist())),
        ("replans", f"{int(replans.sum()):,} (median {np.median(replans):,.0f} a trial)"),
        ("theta", ", ".join(beliefs.theta)),
        ("replans with a belief", f"{len(beliefs.trial):,}"),
        ("trials with a belief", f"{len(np.unique(beliefs.trial)):,}"),
    ]
