"""The page about a posterior over goals: collecting what it says, drawing it and putting it together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import xarray as xr

from ppinfer.report.facts import command, data_sheet, guessing, provenance
from ppinfer.report.figures import (
    ReportFigure,
    calibration_figure,
    participants_figure,
    score_figure,
    trial_figure,
)
from ppinfer.report.rendering import render
from ppinfer.report.trial_choice import choose_trials, named_trials
from ppinfer.report.written import Drawn, Progress, WrittenReport
from ppinfer.studies.calibration import Calibration, calibrate_posterior
from ppinfer.studies.posterior import open_posterior
from ppinfer.studies.scores import Scores, score_posterior
from ppinfer.studies.segment_selection import SegmentOptions, describe_left_out, select_segments

_CURVE_SHARES = tuple(percent / 100 for percent in range(5, 101, 5))


def write_goal_page(
    source: Path,
    target: Path,
    *,
    trials: Sequence[str] | None,
    at: Sequence[float],
    selection: SegmentOptions,
    progress: Progress,
) -> WrittenReport:
    """Write the page about a posterior over goals; see `ppinfer.report.write_report`."""
    with open_posterior(source) as posterior:
        chosen_by_name = None if trials is None else named_trials(posterior, trials)
        selected = select_segments(posterior, **selection)
        scores: Scores | None = None
        calibration: Calibration | None = None
        warnings: list[str] = []
        if len(selected.index):
            scores = score_posterior(posterior, at=at, **selection)
            calibration = calibrate_posterior(posterior, at=at, **selection)
            warnings += scores.warnings
        else:
            warnings.append(
                "no segment can be scored: "
                + (describe_left_out(selected.left_out) or "the log names no segments with true goals")
            )
        chosen = chosen_by_name or choose_trials(posterior, scores)
        drawn = Drawn(progress, total=len(chosen) + (3 if scores is not None else 0))
        trial_figures = [
            drawn.add(trial_figure(posterior, each.index, number=number, why=each.why))
            for number, each in enumerate(chosen, start=1)
        ]
        sections = {}
        if scores is not None and calibration is not None:
            curve = score_posterior(posterior, at=_CURVE_SHARES, **selection)
            middle = scores.overall[len(scores.overall) // 2].at
            people = [each for each in scores.by_participant if each.at == middle]
            sections = {
                "score_figure": drawn.add(score_figure(curve.overall, guessing(posterior))),
                "calibration_figure": drawn.add(calibration_figure(calibration)),
                "participants_figure": drawn.add(participants_figure(people)),
            }
        page = _render(
            title=f"Where is the {posterior.attrs.get('agent', 'agent')} going?",
            source=source,
            posterior=posterior,
            scores=scores,
            calibration=calibration,
            warnings=warnings,
            left_out="" if scores is None else describe_left_out(scores.left_out),
            trial_figures=trial_figures,
            sections=sections,
        )
        names = posterior["trial_id"].values
        shown = tuple(str(names[each.index]) for each in chosen)
    return WrittenReport(
        page=target / "index.html",
        figures=drawn.write(target, page),
        trials=shown,
        scores=scores,
        calibration=calibration,
        warnings=tuple(warnings),
    )


def _render(
    *,
    title: str,
    source: Path,
    posterior: xr.Dataset,
    scores: Scores | None,
    calibration: Calibration | None,
    warnings: Sequence[str],
    left_out: str,
    trial_figures: Sequence[ReportFigure],
    sections: dict[str, ReportFigure],
) -> str:
    return render(
        "goals.html.j2",
        title=title,
        source=source.name,
        attrs=posterior.attrs,
        command=command(posterior, source),
        provenance=provenance(posterior, source),
        data_sheet=data_sheet(posterior),
        scores=scores,
        calibration=calibration,
        warnings=warnings,
        left_out=left_out,
        trial_figures=trial_figures,
        **{"score_figure": None, "calibration_figure": None, "participants_figure": None, **sections},
    )
