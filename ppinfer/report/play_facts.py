"""What a page says of a log of parallel play in words: which robots are compared, and what there is besides."""

from __future__ import annotations

import numpy as np
import xarray as xr
from jaxtyping import Bool

from ppinfer.plots.replan_beliefs import ReplanBeliefs
from ppinfer.report.facts import Facts, counted
from ppinfer.studies.task_performance import METRICS, TaskPerformance

# what robots are compared with, where it is there: the norm alone, and with commitment
_BASELINES = ("norm", "norm-committed")


def baselines(performance: TaskPerformance) -> list[str]:
    """Return the robots that others are compared with: those that follow a norm, or else the first."""
    robots = list(dict.fromkeys(performance.robot.tolist()))
    return [name for name in _BASELINES if name in robots] or robots[:1]


def personal_robots(performance: TaskPerformance, beliefs: ReplanBeliefs | None) -> list[str]:
    """Return the robots to show against each human: those that held a belief, or else the first."""
    robots = list(dict.fromkeys(performance.robot.tolist()))
    if beliefs is None:
        return robots[:1]
    believers = {str(name) for name in beliefs.robot[beliefs.trial]}
    return [name for name in robots if name in believers] or robots[:1]


def inferring_trials(log: xr.Dataset) -> Bool[np.ndarray, " trial"]:
    """Return the trials in which a model held the belief; in others, as an oracle's, the robot was told it.

    A log that names no model at all may just not say: then any belief counts.
    """
    told = np.ones(log.sizes["trial"], dtype=bool)
    if "live_model" in log:
        named = np.array([bool(str(text)) for text in log["live_model"].values])
        told = named if named.any() else told
    return told


def play_facts(performance: TaskPerformance, beliefs: ReplanBeliefs | None) -> Facts:
    """Say what a log of parallel play holds besides what all logs do: scenes, robots, humans, stops, beliefs."""
    failures = round(float(performance.values[:, METRICS.index("failures")].sum()))
    facts = [
        ("scenes", f"{len(np.unique(performance.scene)):,}"),
        ("robots", counted(performance.robot.tolist())),
        ("humans", counted(performance.human.tolist())),
        ("plan sets", counted(performance.plan_sets.tolist())),
        ("trials not finished", f"{failures:,}"),
        ("safety stops", f"{int(performance.values[:, METRICS.index('stops')].sum()):,}"),
    ]
    if beliefs is not None:
        facts += [
            ("theta", ", ".join(beliefs.theta)),
            ("trials in which the robot held a belief", f"{len(np.unique(beliefs.trial)):,}"),
        ]
    return facts
