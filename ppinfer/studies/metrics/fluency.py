"""Fluency of a team, as shares of the time in which both have a task (Hoffman 2019, IEEE THMS 49(3), 209-218)."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.studies.metrics.context import TrialContext, share
from ppinfer.studies.metrics.idleness import flag_of
from ppinfer.studies.metrics.metric import Metric, metric_of_each_role
from ppinfer.studies.metrics.roles import ROLES, Role

_NEEDS = ("position", "observed")
_READS = (*map(flag_of, ROLES), "finish_time")


def _share_of_time(trials: TrialContext, marked: Bool[np.ndarray, " sample"]) -> Float[np.ndarray, " trial"]:
    during = trials.total(np.where(marked & trials.both_busy, trials.interval, 0.0))
    return share(during, trials.busy_time)


def idle_share(trials: TrialContext, role: Role) -> Float[np.ndarray, " trial"]:
    """Return the share of the time in which an agent was idle (Hoffman's H-IDLE and R-IDLE)."""
    return _share_of_time(trials, trials.idle_and_active(role)[0])


def active_share(trials: TrialContext, role: Role) -> Float[np.ndarray, " trial"]:
    """Return the share of the time in which an agent was active."""
    return _share_of_time(trials, trials.idle_and_active(role)[1])


def unseen_share(trials: TrialContext, role: Role) -> Float[np.ndarray, " trial"]:
    """Return the share of the time in which an agent was neither idle nor active, because it was not seen."""
    idle, active = trials.idle_and_active(role)
    return _share_of_time(trials, ~(idle | active))


def concurrent_share(trials: TrialContext) -> Float[np.ndarray, " trial"]:
    """Return the share of the time in which both were active (Hoffman's C-ACT)."""
    return _share_of_time(trials, trials.idle_and_active("robot")[1] & trials.idle_and_active("human")[1])


def functional_delay(trials: TrialContext) -> Float[np.ndarray, " trial"]:
    """Return the delay from one agent's actions to the other's as a share of the time (Hoffman's F-DEL).

    1. An action is a run of intervals in which an agent is active, within the time in which both have a task.
    2. Actions of both are sorted by their beginnings (then ends). Where an action of one agent is followed by an action
       of the other, the delay is the time from the end of the first to the beginning of the second; where they
       overlap, it is minus the length of the overlap.
    3. The delays are added up and divided by the time in which both have a task. NaN where no action of one follows an
       action of the other.
    """
    runs = [_actions(trials, role) for role in ROLES]
    who = np.repeat(np.arange(len(runs)), [len(run[0]) for run in runs])
    trial, begin, end = (np.concatenate([run[part] for run in runs]) for part in range(3))
    order = np.lexsort((end, begin, trial))
    who, trial, begin, end = who[order], trial[order], begin[order], end[order]
    turn = (np.diff(trial) == 0) & (np.diff(who) != 0)
    # an action inside another overlaps it by its own length
    delay = (begin[1:] - np.minimum(end[:-1], end[1:]))[turn]
    of_trial, trials_here = trial[1:][turn], trials.row_size.size
    # without any weights, bincount counts in whole numbers
    summed = np.bincount(of_trial, weights=delay, minlength=trials_here).astype(np.float64)
    turns = np.bincount(of_trial, minlength=trials_here)
    return np.where(turns > 0, share(summed, trials.busy_time), np.nan)


def _actions(
    trials: TrialContext, role: Role
) -> tuple[Int[np.ndarray, " action"], Float[np.ndarray, " action"], Float[np.ndarray, " action"]]:
    active = trials.idle_and_active(role)[1] & trials.both_busy
    # first samples end no interval, so that runs never cross from one trial into the next
    edge = np.diff(active.astype(np.int8), prepend=0, append=0)
    first, last = np.flatnonzero(edge == 1), np.flatnonzero(edge == -1) - 1
    return trials.trial[first], trials.elapsed[first - 1], trials.elapsed[last]


IDLE_SHARE = metric_of_each_role(
    "{role}_idle_share",
    "",
    "share of the time in which both have a task that the {role} is idle",
    idle_share,
    needs=_NEEDS,
    reads=_READS,
)
ACTIVE_SHARE = metric_of_each_role(
    "{role}_active_share",
    "",
    "share of that time in which the {role} is active",
    active_share,
    needs=_NEEDS,
    reads=_READS,
)
UNSEEN_SHARE = metric_of_each_role(
    "{role}_unseen_share",
    "",
    "share of that time in which the {role} is not seen: neither idle nor active",
    unseen_share,
    needs=_NEEDS,
    reads=_READS,
)
CONCURRENT_SHARE = Metric(
    "concurrent_share",
    "",
    "share of that time in which both are active",
    concurrent_share,
    roles=ROLES,
    needs=_NEEDS,
    reads=_READS,
)
FUNCTIONAL_DELAY = Metric(
    "functional_delay",
    "",
    "from the end of one's actions to the beginning of the other's, as a share of that time; negative = they overlap",
    functional_delay,
    roles=ROLES,
    needs=_NEEDS,
    reads=_READS,
)
