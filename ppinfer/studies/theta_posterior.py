"""The posterior over theta at every replan of a study: what its file holds, reading and writing it."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from ppinfer import guarding
from ppinfer.errors import LogError
from ppinfer.studies.checksums import content_digest
from ppinfer.studies.planned_checks import normalised
from ppinfer.studies.posterior_layout import POSTERIOR_FORMAT, refuse_other_versions
from ppinfer.studies.schema import DIGEST_ATTR
from ppinfer.studies.storage import open_plain, told_as_log_error, write_signed

HYPOTHESIS = "theta"
_REMEDY = "make it again with 'ppinfer infer --model personality'"


@dataclass(frozen=True)
class ThetaVariable:
    """One variable of a posterior over theta: dimensions, type, meaning, and whether it must be there."""

    dims: tuple[str, ...]
    kind: str
    meaning: str
    required: bool = True


THETA_VARIABLES: dict[str, ThetaVariable] = {
    "theta": ThetaVariable(("theta",), "str", "whom an agent's equilibria favour: labels"),
    "agent": ThetaVariable(("agent",), "str", "labels of the agents"),
    "trial_id": ThetaVariable(("trial",), "str", "unique name of the trial"),
    "participant": ThetaVariable(("trial",), "str", "who took part"),
    "model": ThetaVariable(("trial",), "str", "JSON of the model that was applied: model and parameters"),
    "replan_row_size": ThetaVariable(("trial",), "int64", "number of replans of the viewer in the trial"),
    "replan_time": ThetaVariable(("replan",), "float64", "since the trial began (s)"),
    "replan_sample": ThetaVariable(("replan",), "int64", "the sample it was made at, counted within the trial"),
    "replan_agent": ThetaVariable(("replan",), "str", "the viewer: whose belief it is"),
    "log_posterior": ThetaVariable(
        ("replan", "theta"), "float64", "natural logarithm of the posterior probability; -inf = not a class there"
    ),
    "live_log_posterior": ThetaVariable(
        ("replan", "theta"), "float64", "what the viewer held then; NaN = no belief", required=False
    ),
    "condition": ThetaVariable(("trial",), "str", "the experimental condition", required=False),
    "round": ThetaVariable(("trial",), "int64", "which repetition, from 0", required=False),
    "seed": ThetaVariable(("trial",), "int64", "seed of a simulated trial", required=False),
    "outcome": ThetaVariable(("trial",), "str", "how the trial ended", required=False),
    "controller": ThetaVariable(("trial", "agent"), "str", "who moved the agent", required=False),
    "instruction": ThetaVariable(("trial", "agent"), "str", "what the agent was asked to be", required=False),
    "scene": ThetaVariable(("trial",), "int64", "number of the scene", required=False),
    "plan_sets": ThetaVariable(("trial",), "str", "shared or independent", required=False),
    "live_model": ThetaVariable(("trial",), "str", "JSON of the model held live", required=False),
}  # fmt: skip
"""Every variable that a posterior over theta may hold."""


def theta_table() -> str:
    """Return the table of variables as Markdown; ``docs/log-format.md`` holds exactly this.

    Examples
    --------
    >>> print(theta_table().splitlines()[2])
    | `theta` | (theta) | str | yes | whom an agent's equilibria favour: labels |
    """
    rows = ["| variable | dimensions | type | required | meaning |", "| --- | --- | --- | --- | --- |"]
    rows += [
        f"| `{name}` | ({', '.join(spec.dims)}) | {spec.kind} | {'yes' if spec.required else ''} | {spec.meaning} |"
        for name, spec in THETA_VARIABLES.items()
    ]
    return "\n".join(rows)


def is_theta_posterior(dataset: xr.Dataset) -> bool:
    """Return whether a posterior is one over theta, by its attribute ``hypothesis``."""
    return dataset.attrs.get("hypothesis") == HYPOTHESIS


def check_theta_posterior(dataset: xr.Dataset, *, name: str = "posterior") -> None:
    """Check that a dataset in memory is a sound posterior over theta.

    Raises
    ------
    LogError
        If it is not, saying what is wrong.

    Examples
    --------
    >>> try:
    ...     check_theta_posterior(xr.Dataset(), name="empty.nc")
    ... except LogError as error:
    ...     print(str(error)[:42])
    empty.nc: is not a posterior over theta (i
    """
    form, hypothesis = dataset.attrs.get("ppinfer_format"), dataset.attrs.get("hypothesis")
    if form != POSTERIOR_FORMAT or hypothesis != HYPOTHESIS:
        raise LogError(
            f"{name}: is not a posterior over theta (its ppinfer_format is {form!r}, its hypothesis {hypothesis!r}); "
            "make one with 'ppinfer infer LOG -o POST.nc --model personality'"
        )
    refuse_other_versions(dataset.attrs.get("ppinfer_format_version", 0), name)
    faults = _faults(dataset)
    if not faults:
        sizes, replans = dataset["replan_row_size"].values, dataset.sizes["replan"]
        if sizes.size == 0 or sizes.min() < 0 or sizes.sum() != replans or not replans:
            faults.append(
                f"replan_row_size adds up to {sizes.sum()} in {sizes.size} trials; {replans} expected"
            )
        wrong = np.flatnonzero(~normalised(dataset["log_posterior"].values))
        if wrong.size:
            found = dataset["log_posterior"].values[wrong[0]].tolist()
            faults.append(
                f"log_posterior of replan {wrong[0]} is {found}; probabilities that sum to one are expected"
            )
    if faults:
        raise LogError(f"{name}: is not a sound posterior over theta: {'; '.join(faults)}; {_REMEDY}")


def _faults(dataset: xr.Dataset) -> list[str]:
    kinds = {"str": "OUT", "float64": "f", "int64": "i"}
    faults = []
    for name, spec in THETA_VARIABLES.items():
        if name not in dataset.variables:
            if spec.required:
                faults.append(f"variable {name} is missing")
            continue
        variable = dataset.variables[name]
        if variable.dims != spec.dims:
            faults.append(f"{name} has dimensions {variable.dims}; {spec.dims} expected")
        elif variable.dtype.kind not in kinds[spec.kind] and variable.size:
            faults.append(f"{name} is of type {variable.dtype}; {spec.kind} expected")
    return faults


def read_theta_posterior(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a posterior over theta into memory, checked: its structure, its numbers and its digest.

    Returns
    -------
    xarray.Dataset
        ``log_posterior(replan, theta)`` with ``replan_time``, and the trials end to end: ``replan_row_size`` says how
        many replans each has.

    Raises
    ------
    LogError
        If the file is missing, unreadable, something else, or damaged.

    Examples
    --------
    >>> read_theta_posterior("nowhere.nc")
    Traceback (most recent call last):
        ...
    ppinfer.errors.LogError: nowhere.nc: there is no such file
    """
    source = Path(path)
    if source.is_dir():
        raise LogError(f"{source}: is a folder; a posterior is one NetCDF file, as 'ppinfer infer' writes it")
    with (
        guarding.admitted("theta-posterior", source),
        told_as_log_error(source, _REMEDY),
        open_plain(source) as opened,
    ):
        dataset = opened.load()
    check_theta_posterior(dataset, name=str(source))
    found, stated = content_digest(dataset), dataset.attrs.get(DIGEST_ATTR)
    if found != stated:
        raise LogError(
            f"{source}: its content does not match its digest ({DIGEST_ATTR} {str(stated)[:12]}... against "
            f"{found[:12]}...); it was changed or damaged after it was written"
        )
    return dataset


def write_theta_posterior(dataset: xr.Dataset, path: str | os.PathLike[str]) -> None:
    """Write a posterior over theta, all or nothing.

    Raises
    ------
    LogError
        If it is not a sound one, or cannot be written there.

    Examples
    --------
    >>> from ppinfer.studies.personality_inference import infer_log_personality
    >>> from ppinfer.testing.example_plays import example_planned_log
    >>> write_theta_posterior(infer_log_personality(example_planned_log()), "theta.nc")
    >>> read_theta_posterior("theta.nc").sizes["replan"]
    12
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise LogError(f"{target}: there is no folder {str(target.parent)!r}; make it first")
    if target.is_dir() or target.suffix != ".nc":
        raise LogError(f"{target}: a posterior is one NetCDF file; give a name that ends in .nc")
    check_theta_posterior(dataset)
    write_signed(dataset, target)
