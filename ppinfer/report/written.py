"""What was written: a report's page and figures, and the numbers on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ppinfer.plots.replan_beliefs import MeanBelief
from ppinfer.report.drawing import Drawn
from ppinfer.report.folder import write_folder
from ppinfer.report.parts import Contents
from ppinfer.report.sections.condition_tests import Tested
from ppinfer.report.sections.metrics import Measured
from ppinfer.report.source import Source
from ppinfer.studies.calibration import Calibration
from ppinfer.studies.faults import Fault
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
    faults, fault_warnings
        What the checks of the file found; of a log with faults nothing else is said.
    scores, calibration
        What the page says of a posterior over goals, in the file or inferred of it; None when no segment can be scored,
        and of other files.
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
    metrics
        The metrics of the trials, and what they are compared by; None where nothing is measured.
    tests
        Whether conditions differ in them; None where nothing is measured.
    warnings
        What a reader has to know.
    """

    page: Path
    figures: tuple[Path, ...]
    trials: tuple[str, ...]
    warnings: tuple[str, ...]
    faults: tuple[Fault, ...] = ()
    fault_warnings: tuple[Fault, ...] = ()
    scores: Scores | None = None
    calibration: Calibration | None = None
    task_performance: dict[str, list[dict[str, Any]]] | None = None
    beliefs: tuple[MeanBelief, ...] | None = None
    game_performance: dict[str, list[dict[str, Any]]] | None = None
    conditional_scores: tuple[dict[str, Any], ...] | None = None
    metrics: Measured | None = None
    tests: Tested | None = None

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
            "metrics": None if self.metrics is None else self.metrics.to_json(),
            "tests": None if self.tests is None else self.tests.to_json(),
            "faults": [asdict(fault) for fault in self.faults],
            "fault_warnings": [asdict(fault) for fault in self.fault_warnings],
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True)
class PageWriter:
    """Writes the page about a file to a folder.

    Parameters
    ----------
    source
        What the page is about.
    target
        The folder.
    progress
        Told how many figures are drawn, of how many.
    """

    source: Source
    target: Path
    progress: Progress

    def write(self, contents: Contents, *, trials: Sequence[str] = (), **numbers: Any) -> WrittenReport:
        """Draw the figures, write the page, and return it with the numbers on it."""
        drawn = Drawn(self.progress, total=contents.pictures)
        page = contents.html(self.source.given, drawn)
        write_folder(self.target, page, drawn.figures)
        return WrittenReport(
            page=self.target / "index.html",
            figures=tuple(self.target / "figures" / figure.name for figure in drawn.figures),
            trials=tuple(trials),
            warnings=tuple(contents.warnings),
            faults=self.source.checked.faults,
            fault_warnings=self.source.checked.warnings,
            **numbers,
        )
