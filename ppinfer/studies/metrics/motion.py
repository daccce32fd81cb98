"""How far and how fast agents moved."""

from __future__ import annotations

from functools import partial

import numpy as np
from jaxtyping import Float

from ppinfer.studies.metrics.context import TrialContext, share
from ppinfer.studies.metrics.metric import Metric
from ppinfer.studies.metrics.roles import ROLES, Role

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


PATH_LENGTH = tuple(
    Metric(
        f"{role}_path_length",
        "{position}",
        f"how far the {role} moved while it was seen; a gap is not bridged",
        partial(path_length, role=role),
        roles=(role,),
        needs=_NEEDS,
    )
    for role in ROLES
)
HAND_PATH = tuple(
    Metric(
        f"{role}_hand_path_m",
        "m",
        f"how far the {role}'s hand moved over the table",
        partial(path_length, role=role, positions="end_effector"),
        roles=(role,),
        needs=("end_effector",),
    )
    for role in ROLES
)
MEAN_SPEED = tuple(
    Metric(
        f"{role}_mean_speed",
        "{position}/s",
        f"the {role}'s path length over the time in which it was seen",
        partial(mean_speed, role=role),
        roles=(role,),
        needs=_NEEDS,
    )
    for role in ROLES
)
