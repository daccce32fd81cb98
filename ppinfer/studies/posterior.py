"""Posterior files: what ``ppinfer infer`` writes and every score, comparison and report starts from."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal, cast

import numpy as np
import xarray as xr
from jaxtyping import Int, Shaped

from ppinfer import guarding
from ppinfer.distributions.ragged import row_starts
from ppinfer.errors import LogError
from ppinfer.studies.checksums import content_digest
from ppinfer.studies.posterior_layout import (
    POSTERIOR_FORMAT,
    READ_OPTIONS,
    STRING,
    posterior_variables,
    refuse_other_versions,
    segment_faults,
)
from ppinfer.studies.posterior_writer import PosteriorWriter
from ppinfer.studies.schema import DIGEST_ATTR
from ppinfer.studies.storage import refuse_other_files, told_as_log_error

__all__ = [
    "PosteriorWriter",
    "check_posterior",
    "open_posterior",
    "rows",
    "trial_starts",
    "verify_posterior",
    "write_posterior",
]

_BLOCK_SAMPLES = 1 << 18
_NORMALISATION_TOLERANCE = 1e-6
_REMEDY = "infer it anew with 'ppinfer infer'"


def open_posterior(path: str | os.PathLike[str], *, load: bool = False, verify: bool = False) -> xr.Dataset:
    """Open a posterior file and check that its parts fit together.

    Parameters
    ----------
    path
        A NetCDF file written by ``ppinfer infer`` or `PosteriorWriter`.
    load
        Whether to read everything into memory; otherwise variables are read when they are used, and the
        file stays open until the dataset is closed (it is a context manager).
    verify
        Whether to read every sample and check the posterior's values and the content digest
        (`verify_posterior`).

    Returns
    -------
    xarray.Dataset
        ``log_posterior(sample, goal)``, ``time(sample)``, ``position(sample, space)``, trials and segments.

    Raises
    ------
    LogError
        If the file is missing, unreadable, not a posterior, damaged, or its parts do not fit together.

    Examples
    --------
    >>> open_posterior("nowhere.nc")
    Traceback (most recent call last):
        ...
    ppinfer.errors.LogError: nowhere.nc: there is no such file
    """
    where = Path(path)
    if where.is_dir():
        raise LogError(f"{where}: is a folder; a posterior is one NetCDF file, as 'ppinfer infer' writes it")
    with guarding.admitted("posterior", where, verify=verify) as known:
        with told_as_log_error(where, _REMEDY):
            refuse_other_files(where)
            dataset = xr.open_dataset(where, engine="h5netcdf", **READ_OPTIONS)
        try:
            with told_as_log_error(where, _REMEDY):
                if load:
                    dataset.load()
                check_posterior(dataset, name=str(where))
                if verify and not known:
                    verify_posterior(dataset, name=str(where))
        except BaseException:
            dataset.close()
            raise
    return dataset


def check_posterior(dataset: xr.Dataset, *, name: str = "posterior") -> None:
    """Check that a dataset is a posterior: format, variables, dimensions, types, row sizes and segments.

    Reads what belongs to trials and segments only, never the samples.

    Parameters
    ----------
    dataset
        The posterior.
    name
        What to call it in messages.

    Raises
    ------
    LogError
        If it is not a posterior, saying what is wrong.

    Examples
    --------
    >>> try:
    ...     check_posterior(xr.Dataset(), name="empty.nc")
    ... except LogError as error:
    ...     print(str(error)[:40])
    empty.nc: is not a posterior file (attri
    """
    form = dataset.attrs.get("ppinfer_format")
    if form != POSTERIOR_FORMAT:
        found = "is missing" if form is None else f"is {form!r}"
        raise LogError(
            f"{name}: is not a posterior file (attribute ppinfer_format {found}; 'posterior' is expected); "
            "make one with 'ppinfer infer LOG -o POST.nc'"
        )
    if (hypothesis := dataset.attrs.get("hypothesis", "goal")) != "goal":
        raise LogError(
            f"{name}: is a posterior over {hypothesis}, and one over goals is expected: no log knows a true "
            f"{hypothesis} to score or compare with; draw it with 'ppinfer report', read it with read_theta_posterior"
        )
    refuse_other_versions(dataset.attrs.get("ppinfer_format_version", 0), name)
    faults = _structure_faults(dataset)
    if not faults:
        sizes = dataset["row_size"].values
        if sizes.size == 0 or sizes.min() < 1 or sizes.sum() != dataset.sizes["sample"]:
            faults.append(
                f"row_size adds up to {int(sizes.sum())} samples in {sizes.size} trials; "
                f"{dataset.sizes['sample']} expected"
            )
        else:
            faults = segment_faults(
                sizes,
                dataset["segment_trial"].values,
                dataset["segment_start"].values,
                dataset["segment_stop"].values,
                dataset["true_goal"].values,
                goals=[str(goal) for goal in dataset["goal"].values],
            )
    if faults:
        raise LogError(f"{name}: is not a sound posterior: {'; '.join(faults)}")


def verify_posterior(dataset: xr.Dataset, *, name: str = "posterior") -> None:
    """Read every sample of a posterior; check that it is normalised and undamaged.

    Parameters
    ----------
    dataset
        The posterior, as `open_posterior` gives it.
    name
        What to call it in messages.

    Raises
    ------
    LogError
        Naming the first sample whose probabilities do not sum to one, or the digest that differs.
    """
    from scipy.special import logsumexp

    for start in range(0, dataset.sizes["sample"], _BLOCK_SAMPLES):
        logs = dataset["log_posterior"][start : start + _BLOCK_SAMPLES].values
        # NaN compares false, so it is caught as well
        wrong = ~(np.abs(logsumexp(logs, axis=1)) < _NORMALISATION_TOLERANCE)
        if wrong.any():
            row = int(np.flatnonzero(wrong)[0])
            raise LogError(
                f"{name}: log_posterior of sample {start + row} is {logs[row].tolist()}; probabilities that "
                "sum to one are expected"
            )
    held = dataset.attrs.get(DIGEST_ATTR)
    found = content_digest(dataset)
    if held is not None and held != found:
        raise LogError(
            f"{name}: its content does not match its digest ({DIGEST_ATTR} {str(held)[:12]}... against "
            f"{found[:12]}...); it was changed or damaged after it was written"
        )


def write_posterior(dataset: xr.Dataset, path: str | os.PathLike[str]) -> None:
    """Write a posterior held in memory to a file (atomically; see `PosteriorWriter` for blocks).

    Parameters
    ----------
    dataset
        A posterior (`check_posterior` is applied).
    path
        Where it goes; an existing file is replaced.

    Raises
    ------
    LogError
        If the dataset is not a sound posterior or cannot be written there.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR
    >>> from ppinfer.studies import infer_log
    >>> from ppinfer.testing import example_log
    >>> write_posterior(infer_log(example_log(), GoalLQR()), "post.nc")
    >>> with open_posterior("post.nc", verify=True) as posterior:
    ...     posterior.sizes["segment"]
    12
    """
    check_posterior(dataset)
    where = cast(Literal["trial", "sample"], str(dataset["goal_position"].dims[0]))
    reserved = {DIGEST_ATTR, "ppinfer_format", "ppinfer_format_version", "Conventions", "featureType"}
    with PosteriorWriter(
        path,
        n_samples=dataset.sizes["sample"],
        goals=[str(goal) for goal in dataset["goal"].values],
        space=[str(axis) for axis in dataset["space"].values],
        goal_position_dims=where,
        attrs={str(key): value for key, value in dataset.attrs.items() if key not in reserved},
        has_outliers="outlier" in dataset,
        position_units=str(dataset["position"].attrs.get("units", "m")),
    ) as out:
        goals = {name: dataset[name].values for name in ("goal_position", "goal_present")}
        optional = {name: dataset[name].values for name in ("condition", "round") if name in dataset}
        out.write_trials(
            trial_id=dataset["trial_id"].values,
            row_size=dataset["row_size"].values,
            participant=dataset["participant"].values,
            **optional,
            **(goals if where == "trial" else {}),
        )
        out.write_samples(
            0,
            time=dataset["time"].values,
            position=dataset["position"].values,
            observed=dataset["observed"].values,
            log_posterior=dataset["log_posterior"].values,
            outlier=dataset["outlier"].values if "outlier" in dataset else None,
            **(goals if where == "sample" else {}),
        )
        out.write_segments(
            trial=dataset["segment_trial"].values,
            start=dataset["segment_start"].values,
            stop=dataset["segment_stop"].values,
            true_goal=dataset["true_goal"].values,
        )


def trial_starts(dataset: xr.Dataset) -> Int[np.ndarray, " trial"]:
    """Return the index of each trial's first sample.

    Examples
    --------
    >>> trial_starts(xr.Dataset({"row_size": ("trial", np.array([3, 2]))}))
    array([0, 3])
    """
    return row_starts(dataset["row_size"].values)


def rows(
    variable: xr.DataArray, index: Int[np.ndarray, " row"], *, block_samples: int = _BLOCK_SAMPLES
) -> Shaped[np.ndarray, "row ..."]:
    """Read chosen rows of a variable, holding at most one block of it in memory.

    Reading a file point by point is slow and reading all of it may not fit: contiguous blocks that hold any
    of the rows are read one after the other.

    Parameters
    ----------
    variable
        An array whose first dimension is indexed; lazy or in memory.
    index
        The rows, in any order, with repetitions as they come.
    block_samples
        The rows read at a time.

    Examples
    --------
    >>> rows(xr.DataArray(np.arange(10.0)), np.array([7, 2]), block_samples=4)
    array([7., 2.])
    """
    out = np.empty((len(index), *variable.shape[1:]), variable.dtype)
    block_of = index // block_samples
    order = np.argsort(block_of, kind="stable")
    firsts = np.flatnonzero(np.diff(block_of[order])) + 1
    for members in np.split(order, firsts) if len(index) else []:
        start = int(block_of[members[0]]) * block_samples
        wanted = index[members] - start
        out[members] = variable[start : start + int(wanted.max()) + 1].values[wanted]
    return out


def _structure_faults(dataset: xr.Dataset) -> list[str]:
    moving = "goal_position" in dataset and dataset["goal_position"].dims[:1] == ("sample",)
    faults = []
    for name, spec in posterior_variables("sample" if moving else "trial").items():
        if name not in dataset.variables:
            if spec.required:
                faults.append(f"variable {name} is missing")
            continue
        array = dataset.variables[name]
        if array.dims != spec.dims:
            faults.append(f"{name} has dimensions {array.dims}; {spec.dims} expected")
        kinds = "OUT" if spec.dtype == STRING else "f" if spec.dtype.startswith("float") else "iu"
        if array.dtype.kind not in kinds and array.size:
            faults.append(f"{name} is of type {array.dtype}; {spec.dtype} expected")
    return faults
