"""Small valid files of every format that is read, by the name of their reader: what mutations begin with."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from .case import Case
from .folders import folders
from .logs import logs, posteriors, shipped
from .models import models
from .recordings import recordings
from .tables import tables

GROUPS: dict[str, tuple[Callable[[], list[Case]], tuple[str, ...]]] = {
    "logs": (
        logs,
        ("read_log log.nc", "read_log log.zarr", "read_log game.nc", "read_log plays.nc", "open_log"),
    ),
    "posteriors": (posteriors, ("open_posterior", "read_theta_posterior")),
    "recordings": (recordings, ("load_recording", "read_recording")),
    "tables": (tables, ("read_tidy csv", "read_tidy parquet", "read_measures", "read_survey", "Instrument")),
    "folders": (folders, ("read_reaching_study", "read_eth", "read_reaching_study real", "read_eth real")),
    "models": (
        models,
        ("read_model", "ExampleStore", "read_nfg outcomes", "read_nfg payoffs", "read_predictor"),
    ),
    "shipped": (
        shipped,
        ("read_log arms-small.nc", "read_log reach-games-small.nc", "read_log reaching-small.nc"),
    ),
}
"""What makes the cases of a kind, and their names: made when a test wants one, not when tests are collected."""


@cache
def group(name: str) -> dict[str, Case]:
    """Return the cases of a group by name, and hold that the names are those announced."""
    make, names = GROUPS[name]
    cases = {case.name: case for case in make()}
    assert set(cases) <= set(names), name
    return cases


def case(name: str) -> Case | None:
    """Return a case; None where it needs data or an extra that is not here."""
    return next(group(kind).get(name) for kind, (_, names) in GROUPS.items() if name in names)
