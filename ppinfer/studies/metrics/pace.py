"""How long a trial took, and how many goals were picked in a minute of it."""

from __future__ import annotations

import numpy as np
import xarray as xr
from jaxtyping import Float

from ppinfer.studies.metrics.context import TrialContext, share
from ppinfer.studies.metrics.metric import Metric, metric_of_each_role
from ppinfer.studies.metrics.roles import Role, Roles

SECONDS_A_MINUTE = 60.0


def picks_per_minute(trials: TrialContext, role: Role) -> Float[np.ndarray, " trial"]:
    """Return how many goals an agent picked in a minute; NaN for a trial of one sample."""
    picks = trials.total(trials.values(f"{{{role}}}_pick") >= 0)
    return share(SECONDS_A_MINUTE * picks, trials.duration)


def segments_per_minute(trials: TrialContext, role: Role) -> Float[np.ndarray, " trial"]:
    """Return how many of an agent's segments there are in a minute; NaN for a trial of one sample."""
    whose = trials.values("segment_agent").astype(str) == trials.roles.label(role)
    of_trial = trials.values("segment_trial")[whose].astype(np.int64)
    count = np.bincount(of_trial, minlength=trials.row_size.size)
    return share(SECONDS_A_MINUTE * count, trials.duration)


def _lacks_segments(role: Role, log: xr.Dataset, roles: Roles) -> str:
    label = roles.label(role)
    has = (log["segment_agent"].values.astype(str) == label).any()
    return "" if has else f"the log has no segments of {label!r}"


DURATION = Metric(
    "duration_s", "s", "from the trial's first sample to its last", lambda trials: trials.duration
)
PICKS_PER_MINUTE = metric_of_each_role(
    "{role}_picks_per_minute",
    "1/min",
    "goals that the {role} picked, as logged, in a minute of the trial",
    picks_per_minute,
    needs=("{{role}}_pick",),
)
SEGMENTS_PER_MINUTE = metric_of_each_role(
    "{role}_segments_per_minute",
    "1/min",
    "segments of the {role} (stretches of motion towards one goal) in a minute of the trial",
    segments_per_minute,
    needs=("segment_agent", "segment_trial"),
    lacks=_lacks_segments,
)
