"""A page is seven sections, the same on every page; a section is parts, each a template with what it shows.

A part is computed before anything is drawn, so that progress counts all figures from the first one on.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ppinfer.report.figures import ReportFigure
from ppinfer.report.rendering import render

if TYPE_CHECKING:
    from pathlib import Path

    from ppinfer.report.drawing import Drawn

#: Anchors and headings of the sections, in the order of every page.
SECTIONS = {
    "data": "The data",
    "faults": "Faults",
    "posteriors": "Posteriors",
    "calibration": "Calibration",
    "metrics": "Metrics",
    "tests": "Tests",
    "made": "How it was made",
}

Draw = Callable[[], ReportFigure]


@dataclass(frozen=True)
class Part:
    """One part of a section.

    Parameters
    ----------
    template
        Its template.
    context
        What the template shows.
    figures
        By name: what draws the figures of each list that the template shows.
    """

    template: str
    context: Mapping[str, object] = field(default_factory=dict)
    figures: Mapping[str, Sequence[Draw]] = field(default_factory=dict)

    @property
    def pictures(self) -> int:
        """How many figures it has."""
        return sum(len(several) for several in self.figures.values())


def sentence(text: str) -> Part:
    """Return a part that is one paragraph: mostly why a section is empty."""
    return Part("sections/sentence.html.j2", {"text": text})


@dataclass(frozen=True)
class Contents:
    """What is on a page.

    Parameters
    ----------
    title, lead
        What it is called, and what it is about in a sentence.
    sections
        The parts of each section by its anchor; all of `SECTIONS`.
    headline
        What stands before the sections; the most important numbers.
    warnings
        What a reader has to know.
    """

    title: str
    lead: str
    sections: Mapping[str, Sequence[Part]]
    headline: Sequence[Part] = ()
    warnings: Sequence[str] = ()

    @property
    def pictures(self) -> int:
        """How many figures there are on the page."""
        parts = [*self.headline, *(part for name in SECTIONS for part in self.sections[name])]
        return sum(part.pictures for part in parts)

    def html(self, source: Path, drawn: Drawn) -> str:
        """Draw the figures in the order of the page and return the page."""
        return render(
            "page.html.j2",
            title=self.title,
            lead=self.lead,
            source=source.name,
            warnings=self.warnings,
            headline=[_html(part, drawn) for part in self.headline],
            sections=[
                {
                    "anchor": anchor,
                    "heading": heading,
                    "parts": [_html(part, drawn) for part in self.sections[anchor]],
                }
                for anchor, heading in SECTIONS.items()
            ],
        )


def _html(part: Part, drawn: Drawn) -> object:
    pictures = {name: [drawn.add(draw()) for draw in several] for name, several in part.figures.items()}
    return render(part.template, **part.context, **pictures)
