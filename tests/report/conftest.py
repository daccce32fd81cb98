"""Figures are left blank unless a test asks for them: drawing takes longer than all else, and pictures have tests."""

import gc

import pytest
from matplotlib.figure import Figure

from ppinfer.plots import labels

_SAVE = Figure.savefig
_PLAIN = labels.as_plain_text


@pytest.fixture(autouse=True)
def undrawn_figures(monkeypatch):
    """Write the first bytes of a PNG in place of every figure."""
    monkeypatch.setattr(Figure, "savefig", lambda figure, file, **options: file.write(b"\x89PNG"))
    monkeypatch.setattr(labels, "as_plain_text", lambda ax: None)
    monkeypatch.setattr("ppinfer.report.figures.as_plain_text", lambda ax: None)


@pytest.fixture
def drawn_figures(undrawn_figures, monkeypatch):
    """Draw figures after all, coarsely."""
    monkeypatch.setattr(Figure, "savefig", _SAVE)
    monkeypatch.setattr(labels, "as_plain_text", _PLAIN)
    monkeypatch.setattr("ppinfer.report.figures.as_plain_text", _PLAIN)
    monkeypatch.setattr("ppinfer.report.figures._DPI", 30)


@pytest.fixture(autouse=True)
def uncollected_garbage(monkeypatch):
    """Let statsmodels adjust p-values without collecting garbage each time: among all that tests hold it is slow."""
    monkeypatch.setattr(gc, "collect", lambda *generation: 0)
