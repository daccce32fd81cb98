"""What the helper process of `ppinfer.guarding` does with a file: read it to its end, by the code that reads it later.

Each function takes a path, the limits and a progress callback, and returns JSON; what is wrong it raises.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ppinfer.errors import LogError
from ppinfer.guarding.limits import Limits, how_to_allow_more, told_bytes
from ppinfer.studies.checksums import content_digest, slabs
from ppinfer.studies.faults import Fault, Faults, Report
from ppinfer.studies.hdf5_structure import check_hdf5
from ppinfer.studies.schema import DIGEST_ATTR
from ppinfer.studies.storage import open_log, plain_text, stated_attribute
from ppinfer.studies.zarr_structure import check_zarr

_Progress = Callable[[int, int], None]
_HDF5 = b"\x89HDF\r\n\x1a\n"
_ZIP = b"PK\x03\x04"


def check_structure(path: str, limits: Limits) -> None:
    """Refuse a NetCDF file or a Zarr folder that holds what no log holds, or claims more than it may unpack to.

    Raises
    ------
    LogError
        Naming what is refused. What is neither is left to whoever reads it.

    Examples
    --------
    >>> _ = Path("log.zip").write_bytes(_ZIP)
    >>> check_structure("log.zip", Limits(1.0, 1 << 20))
    Traceback (most recent call last):
        ...
    ppinfer.errors.LogError: log.zip: is a zip archive; unpack it and give the folder or file in it
    """
    source = Path(path)
    if source.is_dir():
        if (source / "zarr.json").exists():
            check_zarr(source, limits)
        return
    try:
        with source.open("rb") as file:
            start = file.read(8)
    except OSError:
        return
    if start.startswith(_ZIP):
        raise LogError(f"{path}: is a zip archive; unpack it and give the folder or file in it")
    if start == _HDF5:
        from ppinfer.studies.storage import told_as_log_error

        with told_as_log_error(source):
            check_hdf5(source, limits)


@cache
def open_example() -> None:
    """Open a file made in memory, once, so that whatever xarray loads for the first one is there."""
    import h5netcdf
    import h5py

    held = BytesIO()
    with h5netcdf.File(held, "w") as file:
        file.dimensions["trial"] = 1
        file.create_variable("time", ("trial",), "f8")
        file.create_variable("trial_id", ("trial",), h5py.string_dtype())
    with xr.open_dataset(held, engine="h5netcdf", decode_times=False, decode_timedelta=False) as opened:
        content_digest(plain_text(opened))


def walk_log(path: str, *, limits: Limits, progress: _Progress) -> dict[str, Any]:
    """Read every variable of a log; return the digest of its content."""
    check_structure(path, limits)
    with open_log(path) as log:
        _refuse_large(path, log, limits)
        return {"digest": content_digest(log)}


def report_of_log(path: str, *, limits: Limits, progress: _Progress) -> dict[str, Any]:
    """Validate a log; return the report, and that it can be opened where all of it could be read."""
    from ppinfer.studies.validation import validate_log

    return _report(path, limits, lambda: validate_log(path, progress=progress))


def report_of_file(path: str, *, limits: Limits, progress: _Progress) -> dict[str, Any]:
    """Validate a log, a posterior or a recording."""
    from ppinfer.studies.file_checks import validate_file

    return _report(path, limits, lambda: validate_file(path, progress=progress))


def stated_attributes(
    path: str, *, limits: Limits, progress: _Progress, names: Sequence[str]
) -> dict[str, Any]:
    """Return text attributes of a NetCDF file; those that it does not have are None."""
    return {name: stated_attribute(Path(path), name) for name in names}


def walk_posterior(path: str, *, limits: Limits, progress: _Progress, verify: bool) -> dict[str, Any]:
    """Read every variable of a posterior, and verify it if asked to."""
    from ppinfer.studies.posterior import open_posterior

    check_structure(path, limits)
    with open_posterior(path, verify=verify) as posterior:
        _refuse_large(path, posterior, limits)
        if not verify:
            _walk(posterior)
    return {"verified": verify}


def walk_theta_posterior(path: str, *, limits: Limits, progress: _Progress) -> dict[str, Any]:
    """Read a posterior over theta."""
    from ppinfer.studies.theta_posterior import read_theta_posterior

    check_structure(path, limits)
    read_theta_posterior(path)
    return {}


def walk_study(
    path: str, *, limits: Limits, progress: _Progress, reader: str, mapping: str | None
) -> dict[str, Any]:
    """Read a study with one of the readers."""
    from ppinfer.studies.readers import read_study

    log = read_study(path, reader, mapping=mapping, progress=progress)
    _refuse_large(path, log, limits)
    return {}


def walk_table(
    path: str,
    *,
    limits: Limits,
    progress: _Progress,
    wanted: Sequence[Sequence[str]],
    options: Mapping[str, Any],
) -> dict[str, Any]:
    """Read columns of a CSV or Parquet file, as numbers and as text."""
    from ppinfer.studies.readers.mapping import FileOptions
    from ppinfer.studies.readers.tables import read_table

    faults = Faults()
    columns = [(str(column), str(entry)) for column, entry in wanted]
    table = read_table(Path(path), columns, FileOptions.model_validate(options), faults)
    if table is None:
        return {"faults": faults.to_json()}
    for column in table.columns:
        table.columns[column].validate(full=True)
        table.text(column)
    return {}


def walk_recording(path: str, *, limits: Limits, progress: _Progress) -> dict[str, Any]:
    """Read a recording."""
    from ppinfer.studies.recording import load_recording

    load_recording(path)
    return {}


def walk_recording_lines(path: str, *, limits: Limits, progress: _Progress) -> dict[str, Any]:
    """Read the lines of a recording one by one; which of them are damaged is found again by whoever goes on with it."""
    from contextlib import suppress

    from ppinfer.studies.recording_lines import lines_of, told_line

    with Path(path).open("rb") as file:
        for line in lines_of(file, path):
            with suppress(ValueError, TypeError):
                told_line(line.removesuffix(b"\n"))
    return {}


def walk_examples(path: str, *, limits: Limits, progress: _Progress) -> dict[str, Any]:
    """Read a store of prediction examples, a batch at a time."""
    from ppinfer.studies.prediction_examples import ExampleStore

    check_structure(path, limits)
    store = ExampleStore(path)
    batch = max(1, min(store.header.batch, 4096))
    for start in range(0, len(store), batch):
        store.read(start, start + batch)
        store.kinds(start, start + batch)
        store.interaction(start, start + batch)
        progress(start, len(store))
    return {}


def _report(path: str, limits: Limits, validate: Callable[[], Report]) -> dict[str, Any]:
    try:
        check_structure(path, limits)
    except LogError as error:
        fault = Fault("unreadable", str(error).removeprefix(f"{path}: "), file=path)
        return Report.of(path, Faults([fault]), Faults()).told()
    report = validate()
    readable = not {"checksum", "unreadable"} & set(report.fault_counts)
    # all was read and compared with what the file says of itself
    known = {"log": {"digest": stated_attribute(Path(path), DIGEST_ATTR)}} if readable else {}
    return {**report.told(), "admits": known}


def _walk(dataset: xr.Dataset) -> None:
    for name in map(str, dataset.variables):
        for rows in slabs(dataset, name):
            np.asarray(dataset.variables[name][rows].values)


def _refuse_large(path: str, log: xr.Dataset, limits: Limits) -> None:
    if log.nbytes > limits.memory:
        raise LogError(
            f"{path}: unpacks to {told_bytes(log.nbytes)}, more than the {told_bytes(limits.memory)} that a file of "
            "its size may: " + how_to_allow_more("MEMORY", f"{(2 * log.nbytes >> 30) + 1}G")
        )
