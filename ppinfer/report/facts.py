"""What a report says in words and numbers: what the posterior is, and what the data are."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import numpy as np
import xarray as xr
from jaxtyping import Float

from ppinfer.studies.posterior import rows, trial_starts
from ppinfer.studies.segment_selection import select_segments

Facts = list[tuple[str, str]]

_MODES = {
    "filter": "filter: each instant uses the past only, as a robot would online",
    "smooth": "smooth: each instant uses the whole trial, past and future",
}
# said elsewhere on the page, or of no use to a reader
_SHOWN_ATTRS = frozenset(
    [
        "hypothesis",
        "agent",
        "mode",
        "model",
        "configuration",
        "seed",
        "ppinfer_version",
        "input",
        "input_sha256",
        "state_source",
        "content_sha256",
        "outliers_gated",
        "samples_missing",
        "command",
        "title",
        "Conventions",
        "featureType",
        "ppinfer_format",
        "ppinfer_format_version",
    ]
)


def provenance(posterior: xr.Dataset, path: Path, *, states: bool = True) -> Facts:
    """Say where a posterior comes from: model, parameters, mode, input and its hash, version and seed.

    ``states``: whether it was inferred from velocities and controls, of which there is something to say.
    """
    attrs = posterior.attrs
    facts = [
        ("posterior file", path.name),
        ("hypothesis", str(attrs.get("hypothesis", "unknown"))),
        ("agent", str(attrs.get("agent", "unknown"))),
        ("model", str(attrs.get("model", "unknown"))),
        ("mode", _MODES.get(str(attrs.get("mode")), str(attrs.get("mode", "unknown")))),
        *configuration_facts(attrs.get("configuration")),
        *([("velocity and control", str(attrs.get("state_source", "unknown")))] if states else []),
        ("seed", str(attrs.get("seed", "unknown"))),
        ("input", str(attrs.get("input", "unknown"))),
        ("input SHA-256", str(attrs.get("input_sha256", "unknown"))),
        ("posterior's content SHA-256", str(attrs.get("content_sha256", "unknown"))),
        ("ppinfer version", str(attrs.get("ppinfer_version", "unknown"))),
    ]
    return facts + [(str(key), str(value)) for key, value in attrs.items() if key not in _SHOWN_ATTRS]


def command(posterior: xr.Dataset, path: Path) -> str:
    """Return the command that makes the posterior, as recorded or put together from its attributes."""
    attrs = posterior.attrs
    if "command" in attrs:
        return str(attrs["command"])
    words = ["ppinfer", "infer", str(attrs.get("input", "LOG.nc")), "-o", path.name]
    for option in ("model", "agent", "mode", "seed"):
        if option in attrs:
            words += [f"--{option}", str(attrs[option])]
    configuration = _parsed(attrs.get("configuration"))
    parameters = configuration.get("parameters")
    if isinstance(parameters, dict):
        words += ["--set", *(f"{name}={value}" for name, value in parameters.items())]
    if "restart" in configuration:
        words += ["--restart", str(configuration["restart"])]
    if configuration.get("carry") is True:
        words.append("--carry")
    return shlex.join(words)


def data_sheet(posterior: xr.Dataset) -> Facts:
    """Say what the data are: trials, participants, samples, segments, goals, what is missing."""
    starts = trial_starts(posterior)
    sizes = posterior["row_size"].values
    began = rows(posterior["time"], starts)
    ended = rows(posterior["time"], starts + sizes - 1)
    duration = ended - began
    many = sizes > 1
    step = float(np.median(duration[many] / (sizes[many] - 1))) if many.any() else float("nan")
    n_samples = posterior.sizes["sample"]
    missing = int((posterior["observed"].values == 0).sum())
    labels = [str(goal) for goal in posterior["goal"].values]
    known = int(sum(str(goal) != "" for goal in posterior["true_goal"].values))
    facts = [
        ("trials", f"{posterior.sizes['trial']:,}"),
        ("participants", f"{len(np.unique(posterior['participant'].values.astype(str))):,}"),
        ("samples", f"{n_samples:,}"),
        ("recorded time", shown_time(float(duration.sum()))),
        (
            "time between samples",
            f"{step:.3g} s (median over trials)" if np.isfinite(step) else "one sample a trial",
        ),
        ("samples a trial", f"{sizes.min():,} to {sizes.max():,} (median {np.median(sizes):,.0f})"),
        ("segments", f"{posterior.sizes['segment']:,} ({known:,} with a known true goal)"),
        ("goals", f"{len(labels)}: {', '.join(labels[:12])}{', ...' * (len(labels) > 12)}"),
        ("goals' places", _places(posterior)),
        ("units of position", str(posterior["position"].attrs.get("units", "m"))),
        ("samples not seen", f"{missing:,} ({100 * missing / n_samples:.2g} %)"),
        ("outliers gated", f"{int(posterior.attrs.get('outliers_gated', 0)):,}"),
    ]
    if "condition" in posterior:
        names, counts = np.unique(posterior["condition"].values.astype(str), return_counts=True)
        shown = [f"{name or 'none'}: {count:,}" for name, count in zip(names[:12], counts[:12], strict=True)]
        facts.append(("trials by condition", ", ".join(shown) + ", ..." * (len(names) > 12)))
    return facts


def guessing(posterior: xr.Dataset) -> tuple[float, float]:
    """Return accuracy and mean log posterior of a uniform guess among the goals that are present."""
    selection = select_segments(posterior)
    present = posterior["goal_present"]
    trial = posterior["segment_trial"].values[selection.index]
    leading = selection.first if present.dims[0] == "sample" else trial
    choices: Float[np.ndarray, " segment"] = np.maximum(1, (rows(present, leading) != 0).sum(axis=1))
    return float((1 / choices).mean()), float(-np.log(choices).mean())


def configuration_facts(text: object) -> Facts:
    """Say what a configuration in JSON says, one line a value."""
    parsed = _parsed(text)
    if not parsed:
        return [("configuration", str(text))] if text else []
    return _flat({key: value for key, value in parsed.items() if key not in _SHOWN_ATTRS})


def _parsed(text: object) -> dict[str, object]:
    try:
        parsed = json.loads(str(text))
    except ValueError:
        return {}
    return parsed if isinstance(parsed, dict) else {}


def _flat(tree: dict[str, object], prefix: str = "") -> Facts:
    facts: Facts = []
    for key, value in tree.items():
        if isinstance(value, dict):
            facts += _flat(value, f"{prefix}{key}: ")
        else:
            # ten digits: 0.1 that was measured as 0.10000000000000053 reads as 0.1
            shown = f"{value:.10g}" if isinstance(value, float) else json.dumps(value)
            facts.append((f"{prefix}{key}", value if isinstance(value, str) else shown))
    return facts


def _places(posterior: xr.Dataset) -> str:
    return (
        "may change within trials"
        if posterior["goal_position"].dims[0] == "sample"
        else "fixed within each trial"
    )


def shown_time(seconds: float) -> str:
    """Return a duration in the unit that suits it."""
    if seconds < 120:
        return f"{seconds:.3g} s"
    return f"{seconds / 60:.1f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
