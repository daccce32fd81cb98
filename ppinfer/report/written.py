"""What was written: a report's page and figures, and the numbers on it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ppinfer.plots.replan_beliefs import MeanBelief
from ppinfer.report.figures import ReportFigure
from ppinfer.report.folder import write_folder
from ppinfer.studies.calibration import Calibration
from ppinfer.studies.scores import Scores

Progress = Callable[[int, int], None] | None


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
        What the page says of a posterior over goals; None when no segment can be scored, and of other files.
    task_performance
        What the page says of a log of parallel play: ``pooled``, ``cells`` and ``differences``, as `ppsim study`
        prints them; None of other files.
    beliefs
        The mean belief that the human favours itself, for each robot, human and way of sharing plans; None where
        there are no beliefs over theta.
    game_performance
        What the page says of games with scores: ``pooled``, ``cells`` and ``differences``, as `ppsim reach` prints
        them; None of other files.
    conditional_scores
        Of a log of two agents among goals: the score of each belief about the human's goal after each share of the
        segments; None of other files.
    warnings
        What a reader has to know.
    """

    page: Path
    figures: tuple[Path, ...]
    trials: tuple[str, ...]
    warnings: tuple[str, ...]
    scores: Scores | None = None
    calibration: Calibration | None = None
    task_performance: dict[str, list[dict[str, Any]]] | None = None
    beliefs: tuple[MeanBelief, ...] | None = None
    game_performance: dict[str, list[dict[str, Any]]] | None = None
    conditional_scores: tuple[dict[str, Any], ...] | None = None

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
            "task_performance": self.task_performance,
            "beliefs": None if self.beliefs is None else [one.to_json() for one in self.beliefs],
            "game_performance": self.game_performance,
            "conditional_scores": None
            if self.conditional_scores is None
            else [
                {key: value for key, value in row.items() if key != "impossible"}
                for row in self.conditional_scores
            ],
            "warnings": list(self.warnings),
        }


class Drawn:
    """The figures so far; each one added moves the progress on."""

    def __init__(self, progress: Progress, *, total: int) -> None:
        self.figures: list[ReportFigure] = []
        self._progress = progress
        self._total = total

    def add(self, figure: ReportFigure) -> ReportFigure:
        """Keep a figure and return it."""
        self.figures.append(figure)
        if self._progress is not None:
            self._progress(len(self.figures), self._total)
        return figure

    def write(self, target: Path, page: str) -> tuple[Path, ...]:
        """Write the page with its figures and return the figures' files."""
        write_folder(target, page, self.figures)
        return tuple(target / "figures" / figure.name for figure in self.figures)
