"""What a posterior file holds: its variables, their dimensions and types, and the digest of its content."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int, Shaped

POSTERIOR_FORMAT = "posterior"
POSTERIOR_FORMAT_VERSION = 1
STRING = "str"

AttrValue = str | int | float


@dataclass(frozen=True)
class VariableSpec:
    """One variable of a posterior: its dimensions, storage type and attributes.

    ``compress`` says whether zlib pays: the logarithms of a posterior shrink by a tenth and take fourteen
    times as long to write, so they are stored as they are (with checksums), while counts and flags nearly
    vanish.
    """

    dims: tuple[str, ...]
    dtype: str
    required: bool = True
    compress: bool = False
    attrs: tuple[tuple[str, str], ...] = ()


def posterior_variables(goal_position_dims: str = "trial") -> dict[str, VariableSpec]:
    """Return every variable that a posterior may hold, by name.

    Parameters
    ----------
    goal_position_dims
        Whether goals stand still within a trial (``"trial"``) or may move with the sample (``"sample"``).

    Examples
    --------
    >>> posterior_variables("sample")["goal_position"].dims
    ('sample', 'goal', 'space')
    """
    where = goal_position_dims
    return {
        "goal": VariableSpec(("goal",), STRING),
        "space": VariableSpec(("space",), STRING),
        "trial_id": VariableSpec(("trial",), STRING, attrs=(("cf_role", "trajectory_id"),)),
        "row_size": VariableSpec(
            ("trial",),
            "int64",
            compress=True,
            attrs=(("sample_dimension", "sample"), ("long_name", "samples of the trial")),
        ),
        "participant": VariableSpec(("trial",), STRING),
        "condition": VariableSpec(("trial",), STRING, required=False),
        "round": VariableSpec(("trial",), "int64", required=False, compress=True),
        "time": VariableSpec(
            ("sample",),
            "float64",
            compress=True,
            attrs=(("units", "s"), ("long_name", "time since the trial's start")),
        ),
        "position": VariableSpec(
            ("sample", "space"), "float64", attrs=(("long_name", "position of the inferred agent"),)
        ),
        "observed": VariableSpec(
            ("sample",), "int8", compress=True, attrs=(("long_name", "1 = seen, 0 = dropout"),)
        ),
        "outlier": VariableSpec(
            ("sample",),
            "int8",
            required=False,
            compress=True,
            attrs=(("long_name", "1 = gated as an outlier"),),
        ),
        "log_posterior": VariableSpec(
            ("sample", "goal"),
            "float64",
            attrs=(
                ("long_name", "natural logarithm of the goal's posterior probability; -inf = absent goal"),
            ),
        ),
        "goal_position": VariableSpec((where, "goal", "space"), "float64", compress=True),
        "goal_present": VariableSpec((where, "goal"), "int8", compress=True),
        "segment_trial": VariableSpec(
            ("segment",), "int64", compress=True, attrs=(("long_name", "index of the segment's trial"),)
        ),
        "segment_start": VariableSpec(
            ("segment",),
            "int64",
            compress=True,
            attrs=(("long_name", "first sample, counted within the trial"),),
        ),
        "segment_stop": VariableSpec(
            ("segment",),
            "int64",
            compress=True,
            attrs=(("long_name", "one past the last sample, within the trial"),),
        ),
        "true_goal": VariableSpec(
            ("segment",), STRING, attrs=(("long_name", "label of the goal reached; empty = unknown"),)
        ),
    }


def segment_faults(
    row_size: Int[np.ndarray, " trial"],
    trial: Int[np.ndarray, " segment"],
    start: Int[np.ndarray, " segment"],
    stop: Int[np.ndarray, " segment"],
    true_goal: Shaped[np.ndarray, " segment"],
    *,
    goals: Sequence[str],
) -> list[str]:
    """Say what is wrong with segments: unknown trials, spans outside their trial, goals that are no label.

    Examples
    --------
    >>> one = np.array([1])
    >>> segment_faults(np.array([5]), 0 * one, 0 * one, 9 * one, np.array(["cup"], object), goals=["cup"])
    ['segment 0: samples [0, 9) do not lie in trial 0 of 5 samples']
    """
    known = (trial >= 0) & (trial < len(row_size))
    faults = [
        f"segment {index}: trial index {int(trial[index])} of {len(row_size)} trials"
        for index in np.flatnonzero(~known)[:1].tolist()
    ]
    size = row_size[np.where(known, trial, 0)] if len(row_size) else np.zeros_like(trial)
    outside = known & ~((start >= 0) & (start < stop) & (stop <= size))
    faults += [
        f"segment {index}: samples [{int(start[index])}, {int(stop[index])}) do not lie in trial "
        f"{int(trial[index])} of {int(size[index])} samples"
        for index in np.flatnonzero(outside)[:1].tolist()
    ]
    unknown = sorted(set(true_goal.tolist()) - {"", *goals})
    if unknown:
        faults.append(f"true_goal {unknown[0]!r} is not among the goals {list(goals)}")
    return faults


class ContentDigest:
    """SHA-256 of a posterior, taken block by block while it is written or read.

    Each variable has a running digest of its bytes in row order; the whole is the digest of all variables'
    names, dimensions, types, shapes and digests, and of all attributes but the digest itself.

    Examples
    --------
    >>> digest = ContentDigest()
    >>> digest.update("time", np.array([0.0, 0.1]))
    >>> whole = digest.hexdigest({"time": ("sample",)}, {"time": (2,)}, {"agent": "human"})
    >>> len(whole)
    64
    """

    def __init__(self) -> None:
        self._running: dict[str, tuple[str, hashlib._Hash]] = {}

    def update(self, name: str, values: Shaped[np.ndarray, "*shape"]) -> None:
        """Add the next block of a variable's rows."""
        kind = STRING if values.dtype.kind in "OUTS" else values.dtype.newbyteorder("<").str
        held, running = self._running.setdefault(name, (kind, hashlib.sha256()))
        if held != kind:
            raise TypeError(f"variable {name!r}: a block of type {kind} after blocks of type {held}")
        if kind == STRING:
            encoded = [str(value).encode() for value in values.ravel().tolist()]
            running.update(np.array([len(text) for text in encoded], "<i8").tobytes())
            running.update(b"".join(encoded))
        else:
            running.update(np.ascontiguousarray(values, dtype=kind).data)

    def hexdigest(
        self,
        dims: Mapping[str, Iterable[str]],
        shapes: Mapping[str, Iterable[int]],
        attrs: Mapping[str, object],
    ) -> str:
        """Return the digest of the whole, given the variables' dimensions and shapes and the attributes."""
        whole = hashlib.sha256()
        for name in sorted(self._running):
            kind, running = self._running[name]
            shape = "x".join(str(int(size)) for size in shapes[name])
            whole.update(f"{name}|{','.join(dims[name])}|{kind}|{shape}|{running.hexdigest()}\n".encode())
        for name in sorted(attrs):
            if name != "content_sha256":
                whole.update(f"{name}={_plain_text(attrs[name])}\n".encode())
        return whole.hexdigest()


def _plain_text(value: object) -> str:
    # a file gives back 5 as int64(5) or array([5]); all of these must have one text
    if isinstance(value, str | bytes):
        return f"str:{value if isinstance(value, str) else value.decode()}"
    array = np.asarray(value)
    return f"{array.dtype.kind}:{array.ravel().tolist()}"
