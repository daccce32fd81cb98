"""How a page was made: the command, and where what it is about comes from."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import xarray as xr

from ppinfer.report.facts import Facts, configuration_facts, parsed_configuration
from ppinfer.report.options import ReportOptions
from ppinfer.report.parts import Part
from ppinfer.report.source import Source
from ppinfer.studies.log_inference import ppinfer_version

_MODES = {
    "filter": "filter: each instant uses the past only, as a robot would online",
    "smooth": "smooth: each instant uses the whole trial, past and future",
}
# said elsewhere on the page, or of no use to a reader
_SHOWN_ATTRS = frozenset(
    [
        "hypothesis", "agent", "mode", "model", "configuration", "seed", "ppinfer_version", "input", "input_sha256",
        "state_source", "content_sha256", "outliers_gated", "samples_missing", "command", "title", "source", "notes",
        "Conventions", "featureType", "ppinfer_format", "ppinfer_format_version",
    ]
)  # fmt: skip


def made_part(
    source: Source,
    options: ReportOptions,
    rows: Facts,
    *,
    posterior_command: str = "",
    more: list[tuple[str, Facts]] | None = None,
) -> Part:
    """Return the part that says how a page was made.

    Parameters
    ----------
    source, options
        What the page is about, and what was asked of it.
    rows
        Where that comes from: `log_provenance` or `posterior_provenance`.
    posterior_command
        Of a posterior, the command that made it.
    more
        Further facts, under headings of their own.
    """
    page = [
        ("file", source.given.name),
        ("file's SHA-256", source.sha256),
        ("page written by", f"ppinfer {ppinfer_version()}"),
        ("seed of its resampling and rollouts", "0"),
    ]
    return Part(
        "sections/made.html.j2",
        {
            "command": options.command(source.given),
            "posterior_command": posterior_command,
            "rows": [*page, *rows],
            "more": [(heading, group) for heading, group in more or [] if group],
        },
    )


def log_provenance(log: xr.Dataset) -> Facts:
    """Say where a log comes from: its source, configuration, digest, version, and the models that were live."""
    attrs = log.attrs
    facts = [
        ("source", str(attrs.get("source") or "unknown")),
        *configuration_facts(attrs.get("configuration"), without=_SHOWN_ATTRS),
        *_live_models(log),
        ("content SHA-256", str(attrs.get("content_sha256", "unknown"))),
        ("ppinfer version of the log", str(attrs.get("ppinfer_version", "unknown"))),
    ]
    return facts + _other_attrs(log)


def posterior_provenance(posterior: xr.Dataset, *, states: bool = True) -> Facts:
    """Say where a posterior comes from: model, parameters, mode, input and its hash, version and seed.

    ``states``: whether it was inferred from velocities and controls, of which there is something to say.
    """
    attrs = posterior.attrs
    facts = [
        ("hypothesis", str(attrs.get("hypothesis", "unknown"))),
        ("agent", str(attrs.get("agent", "unknown"))),
        ("model", str(attrs.get("model", "unknown"))),
        ("mode", _MODES.get(str(attrs.get("mode")), str(attrs.get("mode", "unknown")))),
        *configuration_facts(attrs.get("configuration"), without=_SHOWN_ATTRS),
        *([("velocity and control", str(attrs.get("state_source", "unknown")))] if states else []),
        ("seed", str(attrs.get("seed", "unknown"))),
        ("input", str(attrs.get("input", "unknown"))),
        ("input SHA-256", str(attrs.get("input_sha256", "unknown"))),
        ("posterior's content SHA-256", str(attrs.get("content_sha256", "unknown"))),
        ("ppinfer version of the posterior", str(attrs.get("ppinfer_version", "unknown"))),
    ]
    return facts + _other_attrs(posterior)


def infer_command(posterior: xr.Dataset, path: Path) -> str:
    """Return the command that makes a posterior over goals, as recorded or put together from its attributes."""
    attrs = posterior.attrs
    if "command" in attrs:
        return str(attrs["command"])
    words = ["ppinfer", "infer", str(attrs.get("input", "LOG.nc")), "-o", path.name]
    for option in ("model", "agent", "mode", "seed"):
        if option in attrs:
            words += [f"--{option}", str(attrs[option])]
    configuration = parsed_configuration(attrs.get("configuration"))
    parameters = configuration.get("parameters")
    if isinstance(parameters, dict):
        words += ["--set", *(f"{name}={value}" for name, value in parameters.items())]
    if "restart" in configuration:
        words += ["--restart", str(configuration["restart"])]
    if configuration.get("carry") is True:
        words.append("--carry")
    return shlex.join(words)


def _other_attrs(data: xr.Dataset) -> Facts:
    return [(str(key), str(value)) for key, value in data.attrs.items() if key not in _SHOWN_ATTRS]


def _live_models(log: xr.Dataset) -> Facts:
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
