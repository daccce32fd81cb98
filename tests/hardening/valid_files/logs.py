"""Study logs and posteriors, in the formats that ppinfer writes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from .case import Case, made

DATA = Path(__file__).parents[3] / "data"


def _log(name: str, log: Any) -> Case:
    from ppinfer.studies import read_log, write_log

    return Case(
        f"read_log {name}",
        made(lambda folder: write_log(log, folder / name)),
        read_log,
        name,
        {"signed": True},
    )


def logs() -> list[Case]:
    """Study logs of every kind, in both formats."""
    from ppinfer.studies import open_log
    from ppinfer.testing import example_interaction_log, example_log, example_planned_log

    small = example_log(participants=2, trials=2)
    named = [("log.nc", small), ("log.zarr", small), ("game.nc", example_interaction_log())]
    cases = [
        _log(name, log) for name, log in [*named, ("plays.nc", example_planned_log(trials=2, replans=2))]
    ]
    opened = replace(
        cases[0],
        name="open_log",
        read=lambda path: open_log(path, load=True, verify=True),
        # what it opens need not be sound: that is for validation to say
        options={"signed": True, "sound": lambda log: None},
    )
    return [*cases, opened]


def shipped() -> list[Case]:
    """The logs that the repository holds."""
    from ppinfer.studies import read_log

    return [
        Case(f"read_log {path.name}", {path.name: path.read_bytes()}, read_log, None, {"signed": True})
        for path in sorted(DATA.glob("*.nc"))
    ]


def posteriors() -> list[Case]:
    """Posteriors over goals and over theta."""
    from ppinfer.goals import GoalLQR
    from ppinfer.studies import infer_log
    from ppinfer.studies.personality_inference import infer_log_personality
    from ppinfer.studies.posterior import open_posterior, write_posterior
    from ppinfer.studies.theta_posterior import read_theta_posterior, write_theta_posterior
    from ppinfer.testing import example_log, example_planned_log

    goals = infer_log(example_log(participants=2, trials=2), GoalLQR())
    theta = infer_log_personality(example_planned_log(trials=2, replans=2))
    return [
        Case(
            "open_posterior",
            made(lambda folder: write_posterior(goals, folder / "post.nc")),
            lambda path: open_posterior(path, load=True, verify=True),
            "post.nc",
            {"signed": True},
        ),
        Case(
            "read_theta_posterior",
            made(lambda folder: write_theta_posterior(theta, folder / "theta.nc")),
            read_theta_posterior,
            "theta.nc",
            {"signed": True},
        ),
    ]
