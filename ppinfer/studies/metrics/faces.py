"""Metrics of trials as JSON and as HTML."""

from __future__ import annotations

from dataclasses import asdict
from html import escape
from typing import Any

import numpy as np

from ppinfer.studies.metrics.grouping import FIRST
from ppinfer.studies.metrics.trial_metrics import TrialMetrics

# all pairs of more groups than these make a table that nobody reads
MAX_PAIRED = 12


def metrics_json(
    metrics: TrialMetrics,
    by: str | None,
    *,
    learning_by: str | None,
    learning_over: str | None,
    resamples: int,
    seed: int,
    level: float,
) -> dict[str, Any]:
    """Return what ``ppinfer metrics --json`` prints; see `TrialMetrics.to_json`."""
    options: dict[str, Any] = {"resamples": resamples, "seed": seed, "level": level}
    warnings = list(metrics.warnings)
    groups = metrics.by(by, **options)
    paired = by is not None and len({row.group for row in groups}) <= MAX_PAIRED
    if by is not None and not paired:
        warnings.append(f"{by!r} has more than {MAX_PAIRED} values: differences between pairs are left out")
    differences = metrics.differences(by, **options) if by and paired else []
    if paired and not differences and len({row.group for row in groups}) > 1:
        warnings.append(f"no participant is in two groups of {by!r}: there are no paired differences")
    learned = metrics.learning(learning_by, over=learning_over, level=level) if learning_by else []
    return {
        **metrics.provenance,
        "options": {
            **metrics.provenance.get("options", {}),
            **options,
            "learning_by": learning_by,
            "learning_over": metrics.rounds_are(learning_by, learning_over) if learning_by else None,
        },
        "by": by,
        "metrics": [asdict(metric) for metric in metrics.metrics],
        "not_available": dict(metrics.not_available),
        "trials": _trials(metrics),
        "groups": [asdict(row) for row in groups],
        "differences": [asdict(row) for row in differences],
        "learning": [{**asdict(row), "rounds": [asdict(one) for one in row.rounds]} for row in learned],
        "warnings": warnings,
    }


def metrics_html(metrics: TrialMetrics) -> str:
    """Return a small table of all means; what comes from the log is text."""
    rows = "".join(
        f"<tr><td>{escape(row.metric)}</td><td>{_shown(row.mean)}</td><td>{_shown(row.sem)}</td>"
        f"<td>{escape(metric.units)}</td><td>{row.trials}</td><td>{escape(metric.meaning)}</td></tr>"
        for row, metric in zip(metrics.by(resamples=0), metrics.metrics, strict=True)
    )
    people = len(set(metrics.participant.tolist()))
    return (
        f"<p>{len(metrics.values):,} trials of {people:,} participants</p><table><thead><tr><th>metric</th>"
        "<th>mean</th><th>SEM</th><th>units</th><th>trials</th><th>meaning</th></tr></thead>"
        f"<tbody>{rows}</tbody></table>"
    )


def _trials(metrics: TrialMetrics) -> list[dict[str, Any]]:
    names = [name for name in FIRST if name in metrics.columns]
    ids = [metrics.columns[name].tolist() for name in names]
    return [
        {**dict(zip(names, told, strict=True)), "values": dict(zip(metrics.names, row, strict=True))}
        for *told, row in zip(*ids, metrics.values.tolist(), strict=True)
    ]


def _shown(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.4g}"
