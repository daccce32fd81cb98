"""How far and how fast agents moved."""

from __future__ import annotations

from functools import partial

import numpy as np
from jaxtyping import Float

from ppinfer.studies.metrics.context import TrialContext, share
from ppinfer.studies.metrics.metric import metric_of_each_role
from ppinfer.studies.metrics.roles import Role

_NEEDS = ("position", "observed")


def path_length(trials: TrialContext, role: Role, positions: str = "position") -> Float[np.ndarray, " trial"]:
    """Return how far an agent moved between samples at which it was seen; NaN where no two such follow each other."""
    length = trials.step_length(role, positions)
    known = ~np.isnan(length)
    walked = trials.total(np.where(known, length, 0.0))
    return np.where(trials.total(known) > 0, walked, np.nan)


def mean_speed(trials: TrialContext, role: Role) -> Float[np.ndarray, " trial"]:
    """Return the path length over the time in which the agent was seen; NaN where there is none."""
    return share(path_length(trials, role), trials.total(np.where(trials.seen(role), trials.interval, 0.0)))


PATH_LENGTH = metric_of_each_role(
    "{role}_path_length",
    "{position}",
    "how far the {role} moved while it was seen; a gap is not bridged",
    path_length,
    needs=_NEEDS,
)
HAND_PATH = metric_of_each_role(
    "{role}_hand_path_m",
    "m",
    "how far the {role}'s hand moved over the table",
    partial(path_length, positions="end_effector"),
    needs=("end_effector",),
)
MEAN_SPEED = metric_of_each_role(
    "{role}_mean_speed",
    "{position}/s",
    "the {role}'s path length over the time in which it was seen",
    mean_speed,
    needs=_NEEDS,
)
