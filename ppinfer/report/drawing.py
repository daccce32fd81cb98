"""Drawing the figures of a page, one after the other, and saying how far it is."""

from __future__ import annotations

from collections.abc import Callable

from ppinfer.report.figures import ReportFigure


class Drawn:
    """The figures so far; each one added moves the progress on."""

    def __init__(self, progress: Callable[[int, int], None] | None, *, total: int) -> None:
        self.figures: list[ReportFigure] = []
        self._progress = progress
        self._total = total

    def add(self, figure: ReportFigure) -> ReportFigure:
        """Keep a figure and return it."""
        self.figures.append(figure)
        if self._progress is not None:
            self._progress(len(self.figures), self._total)
        return figure
