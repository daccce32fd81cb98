"""Study logs on disk: NetCDF4 and Zarr v3, checksummed, written whole or not at all, opened lazily."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ppinfer import guarding
from ppinfer.errors import LogError, PPInferError
from ppinfer.studies.checksums import content_digest
from ppinfer.studies.replacing import replacing
from ppinfer.studies.schema import DIGEST_ATTR, FORMAT

_CHUNK_BYTES = 1 << 19
_MOST_COMPRESSED = 1100
"""zlib cannot compress further than about 1032 to 1."""
_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def write_log(log: xr.Dataset, path: str | os.PathLike[str], *, validate: bool = True) -> None:
    """Write a study log as NetCDF4 (``.nc``) or Zarr v3 (``.zarr``), all or nothing.

    It is written under a temporary name in the same folder, and renamed once it is whole. Numbers are
    compressed and checksummed (Fletcher32, CRC32C); the digest of the whole content goes into the attribute
    ``content_sha256``.

    Parameters
    ----------
    log
        The log, as `build_log` and the readers make it.
    path
        Where to; an existing log there is replaced.
    validate
        Whether to refuse an unsound log first.

    Raises
    ------
    FaultyLogError
        If the log is unsound; nothing is written.
    LogError
        If the suffix is unknown or the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from ppinfer.studies import build_log
    >>> log = build_log(agents=["human"], row_size=[2], time=[0.0, 0.1], position=np.zeros((2, 1, 2)))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_log(log, Path(folder, "log.nc"))
    ...     read_log(Path(folder, "log.nc")).sizes["sample"]
    2
    """
    target = Path(path)
    check_target(target)
    if validate:
        from ppinfer.studies.validation import validate_log

        validate_log(log).raise_if_faulty()
    write_signed(log, target)


def write_signed(log: xr.Dataset, target: Path) -> None:
    """Write a dataset as it is, with checksums and the digest of its content, all or nothing."""
    # encodings of the file it came from must not leak into the next one
    plain = plain_text(log.drop_encoding())
    plain.attrs = {name: value for name, value in log.attrs.items() if name != DIGEST_ATTR}
    plain.attrs[DIGEST_ATTR] = content_digest(plain)
    with _told_as_write_error(target), replacing(target) as temporary:
        if target.suffix == ".nc":
            _write_netcdf(plain, temporary)
        else:
            _write_zarr(plain, temporary)


def open_log(path: str | os.PathLike[str], *, load: bool = False, verify: bool = False) -> xr.Dataset:
    """Open a study log; numbers stay on disk until they are asked for.

    A log that this process has neither written nor opened before is first read to its end by another process, under
    limits of time and memory (see `ppinfer.guarding`).

    Parameters
    ----------
    path
        A NetCDF4 file or a Zarr folder.
    load
        Whether to read everything now and close the file; else close the dataset, or use it in a ``with``
        block.
    verify
        Whether to check the digest of the whole content against ``content_sha256`` (this reads the log once).

    Returns
    -------
    xarray.Dataset
        The log.

    Raises
    ------
    LogError
        If it cannot be read within the limits, is not a study log, or its content does not match its digest.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> write_log(example_log(), "log.nc")
    >>> with open_log("log.nc") as log:
    ...     log.sizes["trial"]
    12
    """
    source = Path(path)
    with guarding.admitted("log", source) as known:
        log = _opened(source)
        try:
            with told_as_log_error(source):
                if load:
                    log = log.load()
                if verify:
                    _verify(source, log, known.get("digest"))
        except BaseException:
            log.close()
            raise
    if load:
        log.close()
    return log


def _opened(source: Path) -> xr.Dataset:
    with told_as_log_error(source):
        log = open_plain(source)
        if log.attrs.get("ppinfer_format") != FORMAT:
            log.close()
            raise LogError(
                f"{source}: is not a study log: attribute ppinfer_format is "
                f"{log.attrs.get('ppinfer_format')!r}, expected {FORMAT!r}; see 'ppinfer convert'"
            )
    return log


def read_log(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a whole study log into memory, checked: its digest, its structure and its numbers.

    Raises
    ------
    FaultyLogError
        If it is unsound; the exception's ``faults`` lists everything found.
    LogError
        If it cannot be read at all.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> write_log(example_log(), "whole.nc")
    >>> read_log("whole.nc").sizes["sample"]
    240
    """
    from ppinfer.studies.validation import validate_log

    validate_log(path).raise_if_faulty()
    return open_log(path, load=True)


def stated_format(path: Path) -> str | None:
    """Return what a NetCDF file says it is, e.g. ``"study-log"``, or None where it does not say."""
    return _stated(path, "ppinfer_format")


def stated_hypothesis(path: Path) -> str | None:
    """Return what a posterior says it is over, ``"goal"`` or ``"theta"``, or None where it does not say."""
    return _stated(path, "hypothesis")


_TOLD = ("ppinfer_format", "hypothesis")


def _stated(path: Path, attribute: str) -> str | None:
    try:
        # both are asked for, one after the other: one question answers both
        with guarding.admitted("stated", path, names=_TOLD) as known:
            told = known[attribute] if known else stated_attribute(path, attribute)
    except PPInferError:
        # whoever reads it next says why it cannot be read
        return None
    return told if isinstance(told, str) else None


def stated_attribute(path: Path, attribute: str) -> str | None:
    """Return a text attribute of a NetCDF file, or None where it has none; nothing else of the file is read."""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            told = file.attrs.get(attribute)
    except Exception:
        # whoever reads it next says why it cannot be read
        return None
    return told if isinstance(told, str) else None


def check_target(target: Path) -> str:
    """Return the suffix of a log to be written, refusing a name or folder that cannot work."""
    if target.suffix not in (".nc", ".zarr"):
        raise LogError(
            f"{target}: a study log is written as .nc (NetCDF4) or .zarr (Zarr); give one of these suffixes"
        )
    if not target.parent.is_dir():
        raise LogError(f"{target}: there is no folder {str(target.parent)!r}; make it first")
    if target.suffix == ".nc" and target.is_dir():
        raise LogError(f"{target}: is a folder; a NetCDF log is one file")
    if target.suffix == ".zarr" and target.exists() and not (target / "zarr.json").is_file():
        raise LogError(f"{target}: exists and is not a Zarr store; it is not replaced")
    return target.suffix


@contextmanager
def _told_as_write_error(target: Path) -> Iterator[None]:
    try:
        yield
    except PPInferError:
        raise
    except (OSError, ValueError, RuntimeError, TypeError) as error:
        raise LogError(f"{target}: cannot be written: {_reason(error)}") from error


def plain_text(log: xr.Dataset) -> xr.Dataset:
    """Return the log with all text held as Python strings, whatever the store made of it."""
    # text lies on trials and segments, of which there are few beside the samples
    texts = {
        name: xr.Variable(variable.dims, variable.values.astype(object), variable.attrs)
        for name, variable in log.variables.items()
        if variable.dtype.kind in "OUT"
    }
    log = log.assign({name: text for name, text in texts.items() if name not in log.coords})
    return log.assign_coords({name: text for name, text in texts.items() if name in log.coords})


def _chunks(variable: xr.Variable) -> tuple[int, ...]:
    row_bytes = max(1, variable.dtype.itemsize * int(np.prod(variable.shape[1:], dtype=np.int64)))
    return (max(1, min(variable.shape[0], _CHUNK_BYTES // row_bytes)), *variable.shape[1:])


def _write_netcdf(log: xr.Dataset, path: Path) -> None:
    encoding: dict[Any, dict[str, Any]] = {}
    for name, variable in log.variables.items():
        if variable.dtype.kind == "O":
            encoding[name] = {"dtype": str}
            continue
        encoding[name] = {"_FillValue": None}
        if variable.size and variable.ndim:
            encoding[name] |= {
                "chunksizes": _chunks(variable),
                "zlib": True,
                "complevel": 1,
                "shuffle": True,
                "fletcher32": True,
            }
    log.to_netcdf(path, engine="h5netcdf", format="NETCDF4", encoding=encoding)


def _write_zarr(log: xr.Dataset, path: Path) -> None:
    from zarr.codecs import Crc32cCodec, ZstdCodec

    encoding: dict[Any, dict[str, Any]] = {}
    for name, variable in dict(log.variables).items():
        encoding[name] = {"compressors": [ZstdCodec(level=3), Crc32cCodec()]}
        if variable.dtype.kind == "O":
            # xarray guesses the type of Python strings from the first one; where there is none it guesses
            # numbers
            text = xr.Variable(variable.dims, variable.values.astype(np.dtypes.StringDType()), variable.attrs)
            log = log.assign_coords({name: text}) if name in log.coords else log.assign({name: text})
        else:
            encoding[name]["_FillValue"] = None
            if variable.size and variable.ndim:
                encoding[name]["chunks"] = _chunks(variable)
    log.to_zarr(path, mode="w-", zarr_format=3, consolidated=False, encoding=encoding)


def open_plain(source: Path) -> xr.Dataset:
    """Open a NetCDF4 file or a Zarr folder of whatever content, with all text as Python strings."""
    options: dict[str, Any] = {"decode_times": False, "decode_timedelta": False}
    if source.is_dir():
        if not (source / "zarr.json").is_file():
            raise LogError(
                f"{source}: is a folder without zarr.json, so no study log; convert it with 'ppinfer convert'"
            )
        log = xr.open_dataset(source, engine="zarr", consolidated=False, chunks=None, **options)
    else:
        refuse_other_files(source)
        log = xr.open_dataset(source, engine="h5netcdf", **options)
    try:
        if source.is_file():
            _refuse_impossible_sizes(source, log)
        plain = plain_text(log)
        # a Dataset made from another does not know how to close its file
        plain.set_close(log.close)
        return plain
    except BaseException:
        log.close()
        raise


def refuse_other_files(source: Path) -> None:
    """Raise `LogError` or what HDF5 raises unless the file looks like NetCDF4 from the outside."""
    import h5py

    if not source.exists():
        raise LogError(f"{source}: there is no such file")
    with source.open("rb") as file:
        start = file.read(len(_HDF5_SIGNATURE))
    if not start:
        raise LogError(f"{source}: the file is empty")
    if start != _HDF5_SIGNATURE:
        raise LogError(
            f"{source}: is not a NetCDF4 file (it begins with {start!r}); other formats go "
            "through 'ppinfer convert'"
        )
    with h5py.File(source, "r") as file:
        # h5netcdf reads this attribute first, and when that fails it prints a traceback as it is thrown away
        file.attrs.get("_nc3_strict")


def _refuse_impossible_sizes(source: Path, log: xr.Dataset) -> None:
    # a flipped bit in a length would have the reader allocate all memory there is
    stored = source.stat().st_size
    for name, variable in log.variables.items():
        if variable.dtype.kind not in "OUT" and variable.nbytes > _MOST_COMPRESSED * stored:
            raise LogError(
                f"{source}: {name} claims {variable.nbytes} bytes, more than a file of {stored} bytes can hold: the "
                "file is damaged; get it again from its source"
            )


def _verify(source: Path, log: xr.Dataset, found: str | None) -> None:
    stated = log.attrs.get(DIGEST_ATTR)
    if stated is None:
        raise LogError(
            f"{source}: has no {DIGEST_ATTR}, so its content cannot be verified; write it with ppinfer"
        )
    if found is None:
        found = content_digest(log)
    if found != stated:
        raise LogError(
            f"{source}: the content does not match its checksum (found {found[:12]}, stated {stated[:12]}): "
            "the file is damaged or was edited; get it again from its source"
        )


@contextmanager
def told_as_log_error(source: Path, remedy: str = "get it again from its source") -> Iterator[None]:
    """Turn whatever goes wrong while a file is read into one `LogError` that names it and says what to do."""
    # a damaged HDF5 or Zarr store fails in as many ways as it has bytes; all of them mean the same to the
    # user
    try:
        yield
    except PPInferError:
        raise
    except Exception as error:
        raise LogError(
            f"{source}: cannot be read: {_reason(error)}; the file is truncated or damaged: {remedy}"
        ) from error


def _reason(error: BaseException) -> str:
    if isinstance(error, OSError) and error.strerror and error.errno:
        return error.strerror
    text = " ".join(str(error).split())
    return f"{text[:200]} ({type(error).__name__})" if text else type(error).__name__
