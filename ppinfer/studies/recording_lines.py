"""The lines of a recording: the header or a trial as one JSON object, led by a CRC-32.

Numbers are JSON's own, ``null`` for NaN and ``"inf"`` for infinity; the many numbers of replans are base64.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from typing import IO, Any, NoReturn

import numpy as np
import xarray as xr
from jaxtyping import Shaped

from ppinfer.errors import LogError
from ppinfer.guarding.limits import told_bytes
from ppinfer.studies.replans import ReplanTable
from ppinfer.studies.trials import Segment, Trial, log_of_trials

RECORDING_FORMAT = "ppinfer-recording"
RECORDING_VERSION = 1
LINE_PREFIX = '{"crc32": "'
MOST_LINE = 1 << 28
"""Bytes of the longest line that is read; a trial of an hour at 100 Hz has a tenth of it."""
_TYPES = frozenset(
    {"str", "bool", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "float16", "float32",
     "float64"}
)  # fmt: skip
_SAMPLED = ("time", "position", "observed", "velocity", "control", "goal_position", "goal_present")


@dataclass(frozen=True)
class RecordingHeader:
    """What a recording says once: its agents, goals and how it was made.

    Parameters
    ----------
    agents, goals, space, theta
        Labels.
    has_velocity, has_control
        For which agents these are logged; by default for those with any number in them.
    control_quantity, position_units, title, source
        As in `build_log`.
    configuration
        How the study was made, in values that JSON has.

    Examples
    --------
    >>> RecordingHeader(agents=("human",), goals=("cup", "pan")).space
    ('x', 'y')
    """

    agents: tuple[str, ...]
    goals: tuple[str, ...] = ()
    space: tuple[str, ...] = ("x", "y")
    theta: tuple[str, ...] = ()
    has_velocity: tuple[bool, ...] | None = None
    has_control: tuple[bool, ...] | None = None
    control_quantity: str = "acceleration"
    position_units: str = "m"
    title: str = ""
    source: str = ""
    configuration: Mapping[str, Any] = field(default_factory=dict)


def log_of_recording(
    header: RecordingHeader, trials: Sequence[Trial], attrs: Mapping[str, str] | None = None
) -> xr.Dataset:
    """Return the study log of some trials of a recording."""
    described = {item.name: getattr(header, item.name) for item in fields(header)}
    return log_of_trials(trials, **described, attrs=attrs)


def header_line(header: RecordingHeader) -> bytes:
    """Return the first line of a recording."""
    described = asdict(header)
    if not header.theta:
        # a header without it is that of every recording from before there were replans
        del described["theta"]
    return _line({"format": RECORDING_FORMAT, "version": RECORDING_VERSION, **described})


def trial_line(trial: Trial, header: RecordingHeader) -> bytes:
    """Return the line of a trial; a ``LogError`` says what JSON cannot hold."""
    try:
        return _line(_trial_json(trial, header))
    except (TypeError, ValueError) as error:
        raise LogError(f"trial {trial.trial_id!r}: cannot be recorded: {error}") from error


def _line(told: Mapping[str, Any]) -> bytes:
    body = json.dumps(told, allow_nan=False, ensure_ascii=False)
    check = zlib.crc32(body.encode())
    return f'{LINE_PREFIX}{check:08x}", {body[1:]}\n'.encode()


def lines_of(file: IO[bytes], name: str, *, first: int = 1) -> Iterator[bytes]:
    r"""Yield the lines of a recording, of which the first has a number; one that is too long is a `LogError`.

    Examples
    --------
    >>> from pathlib import Path
    >>> _ = Path("two.jsonl").write_text("one\ntwo")
    >>> with open("two.jsonl", "rb") as file:
    ...     list(lines_of(file, "two.jsonl"))
    [b'one\n', b'two']
    """
    number = first - 1
    while line := file.readline(MOST_LINE + 1):
        number += 1
        if len(line) > MOST_LINE:
            raise LogError(
                f"{name}: line {number}: is longer than {told_bytes(MOST_LINE)}, the most that is read of a trial"
            )
        yield line


def told_line(line: bytes) -> dict[str, Any]:
    """Return what a line says; a ``ValueError`` says that it is damaged."""
    text = line.decode()
    start = len(LINE_PREFIX)
    body = "{" + text[start + 11 :]
    if not text.startswith(LINE_PREFIX) or text[start + 8 : start + 11] != '", ':
        raise ValueError("does not begin with its checksum")
    if text[start : start + 8] != f"{zlib.crc32(body.encode()):08x}":
        raise ValueError("does not match its checksum")
    try:
        told = json.loads(body, parse_constant=_refuse, object_pairs_hook=_once)
    except RecursionError:
        raise ValueError("is nested too deeply") from None
    if not isinstance(told, dict):
        raise TypeError("is not a JSON object")
    return told


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    told = dict(pairs)
    if len(told) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"says {twice!r} twice")
    return told


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"holds {constant}; numbers are finite, null stands for none")


def told_header(told: Mapping[str, Any]) -> RecordingHeader:
    """Return the header that a line says."""
    if told.get("format") != RECORDING_FORMAT or told.get("version") != RECORDING_VERSION:
        raise ValueError(
            f"is format {told.get('format')!r} version {told.get('version')!r}, "
            f"expected {RECORDING_FORMAT!r} version {RECORDING_VERSION}"
        )
    known = {item.name for item in fields(RecordingHeader)}
    values: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value
        for name, value in told.items()
        if name in known
    }
    return RecordingHeader(**values)


def _trial_json(trial: Trial, header: RecordingHeader) -> dict[str, Any]:
    told: dict[str, Any] = {}
    for item in fields(trial):
        value = getattr(trial, item.name)
        if item.name not in ("trial_id", "participant") and (value is None or _is_empty(value)):
            continue
        if item.name == "replans":
            table = trial.replan_table(agents=header.agents, theta=header.theta)
            if table.sizes["replan"]:
                told[item.name] = {part.name: _packed(getattr(table, part.name)) for part in fields(table)}
            continue
        if item.name in _SAMPLED:
            told[item.name] = _numbers(value)
        elif item.name == "segments":
            told[item.name] = [asdict(segment) for segment in value]
        elif item.name == "variables":
            told[item.name] = {name: _variable_json(*given) for name, given in value.items()}
        else:
            told[item.name] = dict(value) if isinstance(value, Mapping) else value
    return told


def _is_empty(value: Any) -> bool:
    return isinstance(value, str | Sequence | Mapping) and len(value) == 0


def _variable_json(
    dims: Sequence[str], values: Any, attrs: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    array = np.asarray(values)
    kind = "str" if array.dtype.kind in "OUT" else ("int8" if array.dtype.kind == "b" else array.dtype.name)
    plain = {name: np.asarray(value).tolist() for name, value in (attrs or {}).items()}
    return {"dims": list(dims), "type": kind, "values": _numbers(array), "attrs": plain}


def _numbers(value: Any) -> Any:
    array = np.asarray(value)
    if array.dtype.kind == "b":
        array = array.astype(np.int8)
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        # JSON has neither: null stands for a number that is not there, and infinity is spelt out
        plain = array.astype(object)
        plain[np.isnan(array)] = None
        plain[np.isposinf(array)] = "inf"
        plain[np.isneginf(array)] = "-inf"
        array = plain
    return array.tolist()


def _packed(array: Shaped[np.ndarray, "*_"]) -> dict[str, Any]:
    if array.dtype.kind in "OUT":
        return {"text": array.tolist()}
    kind = {"f": "<f8", "i": "<i8"}[array.dtype.kind]
    content = base64.b64encode(np.ascontiguousarray(array, kind).tobytes()).decode("ascii")
    return {"type": kind, "shape": list(array.shape), "base64": content}


def _unpacked(told: Mapping[str, Any]) -> Shaped[np.ndarray, "*_"]:
    if "text" in told:
        return np.array(told["text"], object)
    content = base64.b64decode(told["base64"], validate=True)
    kind = {"<f8": np.float64, "<i8": np.int64}[told["type"]]
    return np.frombuffer(content, told["type"]).reshape(told["shape"]).astype(kind, copy=False)


def _described(name: str, told: Any) -> dict[str, Any]:
    if not isinstance(told, dict):
        raise ValueError(f"the attributes of variable {name!r} are {told!r}; an object is expected")
    return told


def _known_type(name: str, told: Any) -> str:
    if not isinstance(told, str) or told not in _TYPES:
        raise ValueError(
            f"variable {name!r} is of type {told!r}; expected one of {', '.join(sorted(_TYPES))}"
        )
    return told


def told_trial(told: Mapping[str, Any]) -> Trial:
    """Return the trial that a line says."""
    given = dict(told)
    for name in _SAMPLED:
        if name in given:
            given[name] = np.array(
                given[name], np.int8 if name in ("observed", "goal_present") else np.float64
            )
    if given["position"].ndim != 3:
        raise ValueError(f"position has shape {given['position'].shape}, expected (sample, agent, space)")
    given["segments"] = tuple(Segment(**segment) for segment in given.get("segments", ()))
    given["variables"] = {
        name: (
            tuple(one["dims"]),
            np.array(one["values"], object if one["type"] == "str" else _known_type(name, one["type"])),
            _described(name, one.get("attrs", {})),
        )
        for name, one in given.get("variables", {}).items()
    }
    if "replans" in given:
        known = {part.name for part in fields(ReplanTable)}
        given["replans"] = ReplanTable(
            **{name: _unpacked(one) for name, one in given["replans"].items() if name in known}
        )
    return Trial(**given)
