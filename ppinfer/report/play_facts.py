"""What a page says of a log of parallel play in words: what the data are, where they come from, what is compared."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from jaxtyping import Bool

from ppinfer.errors import LogError
from ppinfer.plots.replan_beliefs import ReplanBeliefs
from ppinfer.report.facts import Facts, configuration_facts, shown_time
from ppinfer.studies.task_performance import METRICS, TaskPerformance

# what robots are compared with, where it is there: the norm alone, and with commitment
_BASELINES = ("norm", "norm-committed")
_SHOWN_ATTRS = frozenset(
    [
        "title", "source", "configuration", "content_sha256", "ppinfer_version", "Conventions", "featureType",
        "ppinfer_format", "ppinfer_format_version",
    ]
)  # fmt: skip


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


def wanted_trials(
    dataset: xr.Dataset, participants: Sequence[str] | None, exclude: Sequence[str] | None
) -> Bool[np.ndarray, " trial"]:
    """Return which trials are of these participants.

    Raises
    ------
    LogError
        If a participant is unknown, or no trial is left.
    """
    people = dataset["participant"].values.astype(str)
    unknown = sorted({*(participants or ()), *(exclude or ())} - set(people.tolist()))
    if unknown:
        known = list(dict.fromkeys(people.tolist()))
        raise LogError(
            f"unknown participant{'s' * (len(unknown) != 1)} {', '.join(map(repr, unknown))}; there are "
            f"{', '.join(map(repr, known[:20]))}{' and others' * (len(known) > 20)}"
        )
    wanted = np.isin(people, people if participants is None else list(participants))
    wanted &= ~np.isin(people, list(exclude or ()))
    if not wanted.any():
        raise LogError("no trial is left: all participants are excluded")
    return wanted


def log_sheet(log: xr.Dataset, performance: TaskPerformance, beliefs: ReplanBeliefs | None) -> Facts:
    """Say what the data are: trials, scenes, robots, humans, samples, replans, what is missing."""
    sizes = log["row_size"].values
    ends = np.cumsum(sizes) - 1
    time = log["time"].values
    duration = time[ends] - time[ends - sizes + 1]
    many = sizes > 1
    step = float(np.median(duration[many] / (sizes[many] - 1))) if many.any() else float("nan")
    failures = round(float(performance.values[:, METRICS.index("failures")].sum()))
    facts = [
        ("trials", f"{log.sizes['trial']:,}"),
        ("trials on this page", f"{len(performance.scene):,}"),
        ("scenes", f"{len(np.unique(performance.scene)):,}"),
        ("robots", counted(performance.robot.tolist())),
        ("humans", counted(performance.human.tolist())),
        ("plan sets", counted(performance.plan_sets.tolist())),
        ("participants", f"{len(np.unique(log['participant'].values.astype(str))):,}"),
        ("samples", f"{log.sizes['sample']:,}"),
        ("recorded time", shown_time(float(duration.sum()))),
        (
            "time between samples",
            f"{step:.3g} s (median over trials)" if many.any() else "one sample a trial",
        ),
        ("samples a trial", f"{sizes.min():,} to {sizes.max():,} (median {np.median(sizes):,.0f})"),
        ("trials not finished", f"{failures:,}"),
        ("safety stops", f"{int(performance.values[:, METRICS.index('stops')].sum()):,}"),
        ("units of position", str(log["position"].attrs.get("units", "m"))),
    ]
    if "replan_row_size" in log:
        replans = log["replan_row_size"].values
        facts += [
            ("replans", f"{int(replans.sum()):,} (median {np.median(replans):,.0f} a trial)"),
            ("plans", f"{log.sizes['plan']:,}"),
            ("profiles", f"{log.sizes['profile']:,}"),
        ]
    if beliefs is not None:
        facts += [
            ("theta", ", ".join(beliefs.theta)),
            ("trials in which the robot held a belief", f"{len(np.unique(beliefs.trial)):,}"),
        ]
    return facts


def log_provenance(log: xr.Dataset, path: Path) -> Facts:
    """Say where a log comes from: its source, configuration, digest, version, and the models that were live."""
    attrs = log.attrs
    facts = [
        ("log", path.name),
        ("source", str(attrs.get("source") or "unknown")),
        *configuration_facts(attrs.get("configuration")),
        *_models(log),
        ("content SHA-256", str(attrs.get("content_sha256", "unknown"))),
        ("ppinfer version", str(attrs.get("ppinfer_version", "unknown"))),
    ]
    return facts + [(str(key), str(value)) for key, value in attrs.items() if key not in _SHOWN_ATTRS]


def _models(log: xr.Dataset) -> Facts:
    if "live_model" not in log:
        return []
    told = dict.fromkeys(str(text) for text in log["live_model"].values if str(text))
    found = []
    for number, text in enumerate(told, start=1):
        try:
            shown = json.dumps(json.loads(text), sort_keys=True)
        except ValueError:
            shown = text
        found.append((f"live model {number}" if len(told) > 1 else "live model", shown))
    return found


def counted(names: list[str]) -> str:
    """Say which names there are and how often each."""
    counts = {name: names.count(name) for name in dict.fromkeys(names)}
    shown = [f"{name or 'unknown'}: {count:,}" for name, count in list(counts.items())[:12]]
    return ", ".join(shown) + ", ..." * (len(counts) > 12)
