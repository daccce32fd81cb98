"""What a team that picks goals came to: points, collisions, and how soon it scored."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from ppinfer.studies.metrics.context import TrialContext
from ppinfer.studies.metrics.metric import Metric

_SCORES = "first_score_s or scored or {human}_pick"


def collisions(trials: TrialContext) -> Float[np.ndarray, " trial"]:
    """Return the runs of samples in collision, however long each is; else the number that was logged."""
    if trials.has("collision"):
        return trials.runs(trials.values("collision") != 0).astype(np.float64)
    name = "collisions" if trials.has("collisions") else "n_collisions"
    return trials.values(name).astype(np.float64)


def first_score(trials: TrialContext) -> Float[np.ndarray, " trial"]:
    """Return seconds until the first score, as logged, or at which the first goal was picked; NaN = never."""
    if trials.has("first_score_s"):
        return np.asarray(trials.values("first_score_s").astype(np.float64) - trials.began)
    marked = trials.values("scored") != 0 if trials.has("scored") else trials.values("{human}_pick") >= 0
    first: np.ndarray = np.minimum.reduceat(np.where(marked, trials.elapsed, np.inf), trials.start)
    return np.where(np.isfinite(first), first, np.nan)


def first_score_s(trials: TrialContext) -> Float[np.ndarray, " trial"]:
    """Return seconds until the first score; the trial's length where there is none."""
    first = first_score(trials)
    return np.where(np.isnan(first), trials.duration, first)


SCORE = Metric(
    "score",
    "",
    "points of the team, as logged",
    lambda trials: trials.values("team_score").astype(np.float64),
    needs=("team_score",),
)
COLLISIONS = Metric(
    "collisions",
    "",
    "episodes of collision: runs of samples marked so, however long; else as logged",
    collisions,
    needs=("collision or collisions or n_collisions",),
)
FIRST_SCORE = Metric(
    "first_score_s",
    "s",
    "until the team first scored, or the human first picked (the trial's length where never)",
    first_score_s,
    needs=(_SCORES,),
)
SCORELESS = Metric(
    "scoreless",
    "",
    "1 = the team never scored",
    lambda trials: np.isnan(first_score(trials)).astype(np.float64),
    needs=(_SCORES,),
)
