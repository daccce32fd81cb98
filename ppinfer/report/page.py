"""Writing a report: collecting what it says, drawing it and putting it into one page."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import xarray as xr

from ppinfer.errors import LogError
from ppinfer.report.facts import command, data_sheet, guessing, provenance
from ppinfer.report.figures import (
    ReportFigure,
    calibration_figure,
    participants_figure,
    score_figure,
    trial_figure,
)
from ppinfer.report.folder import GENERATOR, refuse_foreign_folder, write_folder
from ppinfer.report.trial_choice import ChosenTrial, choose_trials
from ppinfer.studies.calibration import Calibration, calibrate_posterior
from ppinfer.studies.posterior import open_posterior
from ppinfer.studies.scores import DEFAULT_SHARES, Scores, score_posterior
from ppinfer.studies.segment_selection import SegmentOptions, describe_left_out, select_segments

_CURVE_SHARES = tuple(percent / 100 for percent in range(5, 101, 5))


@dataclass(frozen=True)
class WrittenReport:
    """What `write_report` wrote.

    Attributes
    ----------
    page
        The page.
    figures
        The figure files.
    trials
        Names of the trials that are shown.
    scores, calibration
        What the page says; None when no segment can be scored.
    warnings
        What a reader has to know.
    """

    page: Path
    figures: tuple[Path, ...]
    trials: tuple[str, ...]
    scores: Scores | None
    calibration: Calibration | None
    warnings: tuple[str, ...]

    def to_json(self) -> dict[str, object]:
        """Return what ``ppinfer report --json`` prints."""
        return {
            "page": str(self.page),
            "figures": [str(path) for path in self.figures],
            "trials": list(self.trials),
            "scores": None if self.scores is None else self.scores.to_json(),
            "expected_calibration_error": None
            if self.calibration is None
            else self.calibration.expected_calibration_error,
            "warnings": list(self.warnings),
        }


def write_report(
    path: str | os.PathLike[str],
    directory: str | os.PathLike[str],
    *,
    trials: Sequence[str] | None = None,
    at: Sequence[float] = DEFAULT_SHARES,
    min_samples: int | None = None,
    min_distance: float | None = None,
    participants: Sequence[str] | None = None,
    exclude: Sequence[str] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> WrittenReport:
    """Write one self-contained page about a posterior, and its figures as files.

    Parameters
    ----------
    path
        The posterior file.
    directory
        The folder of the report. A new one appears whole; in an existing one only an earlier report is
        replaced.
    trials
        Names of the trials to show; by default a typical, the best and the worst scored one.
    at, min_samples, min_distance, participants, exclude
        What is scored, as in `ppinfer.studies.scores.score_posterior`.
    progress
        Called after every figure with how many are drawn and how many there are.

    Returns
    -------
    WrittenReport
        Where the page and figures are, and the scores on it.

    Raises
    ------
    LogError
        If the posterior cannot be read, a trial or participant is unknown, or the folder is a file or holds
        another page. Nothing is written then.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR
    >>> from ppinfer.studies import infer_log, write_posterior
    >>> from ppinfer.testing import example_log
    >>> write_posterior(infer_log(example_log(), GoalLQR()), "post.nc")
    >>> write_report("post.nc", "report").page.name
    'index.html'
    """
    source, target = Path(path), Path(directory)
    refuse_foreign_folder(target)
    selection: SegmentOptions = {
        "min_samples": min_samples,
        "min_distance": min_distance,
        "participants": participants,
        "exclude": exclude,
    }
    with open_posterior(source) as posterior:
        chosen_by_name = None if trials is None else _named_trials(posterior, trials)
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
        drawn = _Drawn(progress, total=len(chosen) + (3 if scores is not None else 0))
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
    write_folder(target, page, drawn.figures)
    return WrittenReport(
        page=target / "index.html",
        figures=tuple(target / "figures" / figure.name for figure in drawn.figures),
        trials=shown,
        scores=scores,
        calibration=calibration,
        warnings=tuple(warnings),
    )


class _Drawn:
    """The figures so far; each one added moves the progress on."""

    def __init__(self, progress: Callable[[int, int], None] | None, *, total: int) -> None:
        self.figures: list[ReportFigure] = []
        self._progress = progress
        self._total = total

    def add(self, figure: ReportFigure) -> ReportFigure:
        self.figures.append(figure)
        if self._progress is not None:
            self._progress(len(self.figures), self._total)
        return figure


def _named_trials(posterior: xr.Dataset, trials: Sequence[str]) -> list[ChosenTrial]:
    index = {str(name): i for i, name in enumerate(posterior["trial_id"].values)}
    unknown = [name for name in trials if name not in index]
    if unknown:
        known = list(index)
        raise LogError(
            f"unknown trial{'s' * (len(unknown) != 1)} {', '.join(map(repr, unknown))}; the posterior has "
            f"{len(known)}: {', '.join(map(repr, known[:10]))}{', ...' * (len(known) > 10)}"
        )
    return [ChosenTrial(index[name], "chosen by name") for name in dict.fromkeys(trials)]


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
    import jinja2

    # everything from a log is text: escaping is never off
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("ppinfer.report", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["number"] = _number
    return environment.get_template("report.html.j2").render(
        generator=GENERATOR,
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


def _number(value: float, digits: int = 3) -> str:
    # NaN is a standard error that does not exist
    return "–" if value != value else f"{value:.{digits}f}".replace("-", "−")
