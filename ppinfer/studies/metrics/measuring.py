"""From a log to the metrics of its trials, in blocks of whole trials."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Float, Shaped

from ppinfer.errors import LogError
from ppinfer.studies.blocks import iter_blocks
from ppinfer.studies.checksums import file_sha256
from ppinfer.studies.faults import Report
from ppinfer.studies.log_inference import ppinfer_version
from ppinfer.studies.metrics.context import TrialContext
from ppinfer.studies.metrics.grouping import grouping_columns
from ppinfer.studies.metrics.idle_rule import idle_rule
from ppinfer.studies.metrics.idleness import IdleFrom, IdleRule, flag_of
from ppinfer.studies.metrics.metric import Metric
from ppinfer.studies.metrics.registry import METRICS
from ppinfer.studies.metrics.roles import ROLES, Roles
from ppinfer.studies.metrics.summaries import MetricFacts
from ppinfer.studies.metrics.trial_metrics import TrialMetrics
from ppinfer.studies.progress import ProgressCallback, silent
from ppinfer.studies.recording import is_recording, read_recording
from ppinfer.studies.storage import open_log
from ppinfer.studies.validation import validate_log

BLOCK_SAMPLES = 1_000_000
# unseen for more than this share of the time is worth a warning
_MUCH_UNSEEN = 0.005


def trial_metrics(
    log: xr.Dataset | str | os.PathLike[str],
    *,
    names: Sequence[str | Metric] | None = None,
    robot: str | None = None,
    human: str | None = None,
    idle: IdleFrom = "auto",
    idle_speed: float | None = None,
    block_samples: int = BLOCK_SAMPLES,
    progress: ProgressCallback = silent,
) -> TrialMetrics:
    """Return the metrics of every trial of a log.

    Parameters
    ----------
    log : xarray.Dataset or path
        A study log, the path of one (NetCDF or Zarr), or of a recording (``.jsonl``). What is read from a path is
        validated first.
    names : sequence of str or Metric, optional
        Which of `ppinfer.studies.metrics.METRICS`, or metrics of one's own; by default all that the log can give.
    robot, human : str, optional
        Which agents these are; by default ``robot``, and ``human`` or the only agent.
    idle, idle_speed
        What counts as idle; see `ppinfer.studies.metrics.idle_rule.idle_rule`.
    block_samples : int
        Samples in memory at a time.
    progress : callable
        Told how many samples are measured, of how many.

    Returns
    -------
    TrialMetrics
        A value a trial and metric; NaN where a metric is undefined in a trial.

    Raises
    ------
    LogError
        If the log is not sound, an agent is not in it, a metric is unknown, or one that is asked for by name
        cannot be had from this log; the message says what is missing.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> metrics = trial_metrics(example_log(participants=2, trials=2))
    >>> metrics.names[:2], metrics.not_available["stops"]
    (('duration_s', 'human_segments_per_minute'), 'the log has no stops')
    """
    asked = _asked(names)
    with _opened(log) as (opened, provenance, found):
        roles = Roles.of(opened, robot=robot, human=human)
        rule = idle_rule(opened, roles, idle=idle, idle_speed=idle_speed, max_samples=block_samples)
        reasons = {metric.name: metric.missing(opened, roles) for metric in asked}
        possible = [metric for metric in asked if not reasons[metric.name]]
        missing = {name: reason for name, reason in reasons.items() if reason}
        _refuse_missing(names, missing)
        values = _measured(opened, roles, rule, possible, block_samples, progress)
        units = str(opened["position"].attrs.get("units", "m"))
        measurements = {
            roles.filled(name)
            for metric in METRICS.values()
            for need in (*metric.needs, *metric.reads)
            for name in need.split(" or ")
        }
        columns = grouping_columns(opened, leave_out=measurements)
        # an unknown seed is -1
        simulated = "seed" in opened and bool((opened["seed"].values >= 0).all())
    undefined = {
        metric.name: "it is undefined in every trial"
        for metric, column in zip(possible, values.T, strict=True)
        if np.isnan(column).all()
    }
    _refuse_missing(names, undefined)
    kept = [at for at, metric in enumerate(possible) if metric.name not in undefined]
    missing |= undefined
    return TrialMetrics(
        values[:, kept],
        tuple(
            MetricFacts(metric.name, metric.units.replace("{position}", units), metric.meaning)
            for metric in (possible[at] for at in kept)
        ),
        columns,
        missing,
        (
            *(found if any("position" in metric.needs for metric in possible) else []),
            # who names a role has thought of the other
            *(_strangers(roles) if names is None and robot is None and human is None else []),
            *_warnings(values, possible, rule, columns["participant"], simulated),
        ),
        {
            **provenance,
            "options": {"robot": roles.robot, "human": roles.human, "idle": rule.to_json()},
        },
    )


def _asked(names: Sequence[str | Metric] | None) -> list[Metric]:
    if names is None:
        return list(METRICS.values())
    unknown = [name for name in names if isinstance(name, str) and name not in METRICS]
    if unknown:
        raise LogError(f"there is no metric {unknown[0]!r}; choose from {', '.join(METRICS)}")
    if not names:
        raise LogError(f"no metric is asked for; choose from {', '.join(METRICS)}")
    asked = [name if isinstance(name, Metric) else METRICS[name] for name in names]
    return list({metric.name: metric for metric in asked}.values())


def _refuse_missing(names: Sequence[str | Metric] | None, missing: dict[str, str]) -> None:
    if names is not None and missing:
        told = "; ".join(f"{name}: {reason}" for name, reason in missing.items())
        raise LogError(f"this log cannot give what is asked for: {told}")


@contextmanager
def _opened(
    log: xr.Dataset | str | os.PathLike[str],
) -> Iterator[tuple[xr.Dataset, dict[str, Any], list[str]]]:
    about = {"ppinfer_version": ppinfer_version()}
    if isinstance(log, xr.Dataset):
        yield log, {"log": str(log.attrs.get("title", "")), "input_sha256": None, **about}, []
        return
    source = Path(log)
    about |= {"log": source.name, "input_sha256": file_sha256(source)}
    if is_recording(source):
        recording = read_recording(source)
        yield recording, about, _jumps(validate_log(recording))
        return
    found = _jumps(validate_log(source))
    with open_log(source) as opened:
        yield opened, about, found


def _jumps(report: Report) -> list[str]:
    report.raise_if_faulty()
    return [
        f"{warning.message.removesuffix('; this is the first')}: they are part of paths, of speeds and of the time "
        "in which an agent is active"
        for warning in report.warnings
        if warning.kind == "implausible-jump"
    ]


def _measured(
    log: xr.Dataset,
    roles: Roles,
    rule: IdleRule,
    metrics: Sequence[Metric],
    block_samples: int,
    progress: ProgressCallback,
) -> Float[np.ndarray, "trial metric"]:
    wanted = {"time"}.union(*(metric.variables(roles) for metric in metrics))
    names = [name for name in sorted(wanted) if name in log.variables]
    samples, done = int(log.sizes["sample"]), 0
    parts = []
    for block in iter_blocks(log, max_samples=block_samples, variables=names):
        trials = TrialContext(block, roles, rule)
        columns = [_checked(metric, trials) for metric in metrics]
        parts.append(np.stack(columns, axis=1) if columns else np.empty((block.sizes["trial"], 0)))
        done += block.sizes["sample"]
        progress(done, samples)
    return np.concatenate(parts)


def _checked(metric: Metric, trials: TrialContext) -> Float[np.ndarray, " trial"]:
    values = np.asarray(metric.measure(trials), np.float64)
    if values.shape != trials.row_size.shape:
        raise LogError(
            f"the metric {metric.name!r} gives values of shape {values.shape}; expected one a trial, "
            f"{trials.row_size.shape}"
        )
    return values


def _strangers(roles: Roles) -> list[str]:
    absent = [role for role in ROLES if roles.index(role) is None]
    free = [agent for agent in roles.agents if agent not in (roles.robot, roles.human)]
    if not absent or not free:
        return []
    who, flags = " or the ".join(absent), " and ".join(f"--{role}" for role in absent)
    others = "the agents are" if len(absent) == len(ROLES) else "the log also has"
    return [f"nobody is the {who}: {others} {', '.join(free)}; say with {flags}"]


def _warnings(
    values: Float[np.ndarray, "trial metric"],
    metrics: Sequence[Metric],
    rule: IdleRule,
    participant: Shaped[np.ndarray, " trial"],
    simulated: bool,
) -> tuple[str, ...]:
    judged = any(flag_of(role) in metric.reads for role in ROLES for metric in metrics)
    told = [rule.unused] if rule.unused and judged else []
    names = [metric.name for metric in metrics]
    for role in ROLES:
        name = f"{role}_unseen_share"
        if name in names:
            unseen = float(np.nan_to_num(values[:, names.index(name)]).mean())
            if unseen > _MUCH_UNSEEN:
                told.append(
                    f"the {role} is not seen for {100 * unseen:.2g} % of the time: neither idle nor active then, and "
                    "its path is not bridged"
                )
    people = len(np.unique(participant.astype(str)))
    if people == 1:
        told.append("one participant only: no standard errors and intervals over participants")
    if simulated:
        told.append(
            f"the trials are simulated: the {people} participants are what the simulation calls so, and intervals over "
            "them say nothing of people"
        )
    return tuple(told)
