"""Two agents that each have a task: when they were done, and how often a safety stop held them."""

from __future__ import annotations

from functools import partial

import numpy as np
from jaxtyping import Float

from ppinfer.studies.metrics.context import TrialContext
from ppinfer.studies.metrics.metric import Metric, metric_of_each_role
from ppinfer.studies.metrics.roles import ROLES, Role


def finish_s(trials: TrialContext, role: Role) -> Float[np.ndarray, " trial"]:
    """Return when an agent had finished; the trial's length where it had not."""
    finish = trials.values("finish_time")[:, trials.agent(role)] - trials.began
    return np.asarray(np.where(np.isnan(finish), trials.duration, finish))


def total_s(trials: TrialContext) -> Float[np.ndarray, " trial"]:
    """Return when both had finished; the trial's length where one had not."""
    return np.asarray(np.maximum(finish_s(trials, "robot"), finish_s(trials, "human")))


def failures(trials: TrialContext) -> Float[np.ndarray, " trial"]:
    """Return 1 for a trial that somebody did not finish."""
    who = [trials.agent(role) for role in ROLES]
    finished = ~np.isnan(trials.values("finish_time")[:, who])
    return np.asarray(1.0 - finished.all(axis=1))


def logged(trials: TrialContext, name: str) -> Float[np.ndarray, " trial"]:
    """Return a number that the log has for each trial."""
    return trials.values(name).astype(np.float64)


TASK_TIMES = (
    Metric(
        "total_s",
        "s",
        "until robot and human both had finished (the trial's length where one had not)",
        total_s,
        roles=ROLES,
        needs=("finish_time",),
    ),
    *metric_of_each_role(
        "{role}_s",
        "s",
        "until the {role} had finished (the trial's length where it had not)",
        finish_s,
        needs=("finish_time",),
    ),
)
STOPS = Metric("stops", "", "safety stops, as logged", partial(logged, name="stops"), needs=("stops",))
STOP_EPISODES = Metric(
    "stop_episodes",
    "",
    "runs of safety stops, as logged",
    partial(logged, name="stop_episodes"),
    needs=("stop_episodes",),
)
FAILURES = Metric(
    "failures", "", "1 = robot or human did not finish", failures, roles=ROLES, needs=("finish_time",)
)
