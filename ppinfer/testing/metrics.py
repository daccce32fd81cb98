"""The laws that every metric of trials obeys; to be run on one's own."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ppinfer.errors import LogError
from ppinfer.studies.metrics import Metric, trial_metrics
from ppinfer.studies.metrics.idleness import IdleFrom, flag_of
from ppinfer.studies.metrics.roles import ROLES, Roles
from ppinfer.studies.trial_selection import select_trials
from ppinfer.testing.example_teams import example_team_log

# the speed up to which the made-up agents are idle: a threshold that depends on the log would break the laws
_IDLE_SPEED = 0.5
_ON_THE_CLOCK = ("time", "finish_time", "first_score_s")


def check_metric(metric: Metric, log: xr.Dataset | None = None) -> None:
    """Hold a metric to what every metric of trials obeys; a broken one fails and is told which.

    The laws: it gives one number a trial, finite or NaN, and the same each time; it says what it is; a trial's value
    depends on that trial alone, so that permuting trials permutes the values and trials by themselves have the same;
    and starting the clock at another time changes nothing. A log without what it needs is refused with the reason.

    Parameters
    ----------
    metric : Metric
        The metric.
    log : xarray.Dataset, optional
        A log that has what it needs; by default one with all that the registered metrics need.

    Raises
    ------
    AssertionError
        Naming the metric and the law.

    Examples
    --------
    >>> from ppinfer.studies.metrics import METRICS
    >>> check_metric(METRICS["concurrent_share"])
    """
    tried = example_team_log() if log is None else log
    assert metric.name.isidentifier(), (
        f"{metric.name!r} is no name: letters, digits and underscores are expected"
    )
    assert len(metric.meaning.splitlines()) == 1, f"{metric.name}: its meaning is not one line"
    missing = metric.missing(tried, Roles.of(tried))
    assert not missing, f"{metric.name}: {missing}; give a log that has it"
    values = _check_values(metric, tried, "motion")
    if {"is_robot_waiting", "is_human_waiting"} <= set(tried.variables):
        if any(flag_of(role) in metric.reads for role in ROLES):
            _check_values(metric, tried, "flags")
        else:
            told = (
                f"{metric.name}: it depends on who is idle, and does not say that it reads flags of waiting"
            )
            _same(values, _values(metric, tried, "flags"), told)
    _check_refusal(metric, tried)


def _values(metric: Metric, log: xr.Dataset, source: IdleFrom, samples: int = 1_000_000) -> np.ndarray:
    speed = _IDLE_SPEED if source == "motion" else None
    return trial_metrics(log, names=[metric], idle=source, idle_speed=speed, block_samples=samples).values[
        :, 0
    ]


def _check_values(metric: Metric, log: xr.Dataset, source: IdleFrom) -> np.ndarray:
    values = _values(metric, log, source)
    assert not np.isinf(values).any(), (
        f"{metric.name}: a value is infinite; expected a number, or NaN = undefined"
    )
    _same(values, _values(metric, log, source), f"{metric.name}: asked again, it gives other values")
    order = np.random.default_rng(0).permutation(values.size)
    _same(
        values[order],
        _values(metric, select_trials(log, order), source),
        f"{metric.name}: in another order of trials it gives other values",
    )
    # each block holds one trial
    _same(
        values, _values(metric, log, source, samples=1), f"{metric.name}: a trial by itself has another value"
    )
    later = log.assign({name: log[name] + 1024.0 for name in _ON_THE_CLOCK if name in log.variables})
    _same(values, _values(metric, later, source), f"{metric.name}: it depends on when the clock starts")
    return values


def _check_refusal(metric: Metric, log: xr.Dataset) -> None:
    roles = Roles.of(log)
    for need in metric.needs:
        names = [name for name in roles.filled(need).split(" or ") if name in log.variables]
        if {"time", "position", "observed"} & set(names):
            continue
        told = _refusal(metric, log.drop_vars(names))
        assert told, f"{metric.name}: it says that it needs {names[0]}, and gives values without"
        assert names[0] in told, f"{metric.name}: without {names[0]} it does not say what is missing"


def _refusal(metric: Metric, log: xr.Dataset) -> str:
    try:
        trial_metrics(log, names=[metric])
    except LogError as error:
        return str(error)
    return ""


def _same(expected: np.ndarray, got: np.ndarray, told: str) -> None:
    assert np.allclose(expected, got, rtol=1e-12, atol=1e-12, equal_nan=True), told
