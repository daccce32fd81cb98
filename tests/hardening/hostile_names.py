"""Logs whose participants, conditions, goals and trials have names that nobody should trust."""

from __future__ import annotations

import numpy as np
import xarray as xr

NAMES = (
    "<script>alert(1)</script>",
    "=cmd()",
    "[bold]x[/bold]",
    "$x^$",
    "$\\frac{",
    "%s{}",
    "\x1b[31mred\x07",
    "a\nb\tc",
    "\u202eright to left",
    "x" * 10_000,
    "💥 中文",
    "{{7*7}}",
    "../../etc",
    "\u009b31m",
    "_hidden",
    "&amp;\"'",
    "+1",
    "@SUM(1)",
)
GOALS = ("<b>$\\frac{</b>", "=1+1\x1b[2J", "_💥{}")


def hostile(log: xr.Dataset) -> xr.Dataset:
    """Return a log with hostile names wherever a name is free."""
    trials = log.sizes["trial"]
    names = [NAMES[index % len(NAMES)] for index in range(trials)]
    log = log.assign(
        trial_id=("trial", np.array([f"{name} {index}" for index, name in enumerate(names)], object)),
        participant=(
            "trial",
            np.array([NAMES[(index // 2) % len(NAMES)] for index in range(trials)], object),
        ),
        condition=("trial", np.array([NAMES[index % 2] for index in range(trials)], object)),
        controller=(
            ("trial", "agent"),
            np.array([[name] * log.sizes["agent"] for name in names], object),
        ),
    ).assign_attrs(title=NAMES[0], source=NAMES[6])
    if "goal" in log.sizes:
        named = dict(zip(log["goal"].values.tolist(), GOALS, strict=False))
        assert len(named) == log.sizes["goal"], "give GOALS more names"
        log = log.assign_coords(goal=np.array(list(named.values()), object))
        if "true_goal" in log:
            true = [named.get(goal, goal) for goal in log["true_goal"].values.tolist()]
            log = log.assign(true_goal=("segment", np.array(true, object)))
    return log
