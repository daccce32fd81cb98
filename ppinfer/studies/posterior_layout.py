"""What a posterior file holds: its variables, their dimensions and types, and which segments are sound."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Int, Shaped

from ppinfer.errors import LogError

POSTERIOR_FORMAT = "posterior"
POSTERIOR_FORMAT_VERSION = 1
STRING = "str"

READ_OPTIONS: dict[str, Any] = {
    "decode_times": False,
    "mask_and_scale": False,
    "decode_coords": False,
    "cache": False,
}
"""How xarray opens a posterior: values as they are stored, read when used, never kept."""

AttrValue = str | int | float


def refuse_other_versions(version: object, name: str) -> None:
    """Raise `LogError` unless a posterior's ``ppinfer_format_version`` is one that this ppinfer reads.

    Examples
    --------
    >>> refuse_other_versions(1, "post.nc")
    """
    known = isinstance(version, int | np.integer) and not isinstance(version, bool)
    if not known:
        raise LogError(
            f"{name}: its attribute ppinfer_format_version is {str(version)[:60]!r}, and a whole number is expected: "
            "it is damaged or was edited; infer it anew with 'ppinfer infer'"
        )
    if int(str(version)) > POSTERIOR_FORMAT_VERSION:
        raise LogError(
            f"{name}: is written in posterior format {version}, newer than {POSTERIOR_FORMAT_VERSION}, which this "
            "ppinfer reads; upgrade ppinfer"
        )


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
