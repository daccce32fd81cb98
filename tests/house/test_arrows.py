"""The arrows of the architecture hold: a package imports only what lies below it."""

from __future__ import annotations

import pytest

from .pages import ROOT

cli = pytest.importorskip("importlinter.cli", reason="needs import-linter: install ppinfer[dev]")


def test_every_import_points_down(capsys, monkeypatch):
    monkeypatch.chdir(ROOT)
    status = cli.lint_imports(config_filename=str(ROOT / "pyproject.toml"), no_cache=True)
    assert status == 0, capsys.readouterr().out
