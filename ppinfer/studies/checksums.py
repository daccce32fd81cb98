"""Hashes of files, folders and of what a log says, whatever it is stored in."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import xarray as xr
from jaxtyping import Shaped

from ppinfer.errors import LogError
from ppinfer.studies.schema import DIGEST_ATTR

_SLAB_BYTES = 1 << 24


def file_sha256(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file, or of a folder over its sorted relative names and contents.

    Raises
    ------
    LogError
        If there is no such file or folder.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "log.txt").write_text("abc")
    ...     file_sha256(Path(folder, "log.txt"))[:16]
    'ba7816bf8f01cfea'
    """
    source = Path(path)
    if source.is_dir():
        whole = hashlib.sha256()
        for name in sorted(
            item.relative_to(source).as_posix() for item in source.rglob("*") if item.is_file()
        ):
            whole.update(f"{name}\n{file_sha256(source / name)}\n".encode())
        return whole.hexdigest()
    try:
        with source.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise LogError(f"{source}: cannot be read: {error.strerror}") from error


class ContentDigest:
    """SHA-256 of a log's content, taken variable by variable and slab by slab.

    Each variable has a running digest of its bytes in row order; the whole is the digest of all variables'
    names, dimensions, types, shapes, attributes and digests, and of the log's attributes but the digest
    itself. So the same log has the same digest in memory, in NetCDF and in Zarr.
    """

    def __init__(self) -> None:
        self._running: dict[str, hashlib._Hash] = {}

    def update(self, name: str, values: Shaped[np.ndarray, "*_"]) -> None:
        """Add the next rows of a variable."""
        running = self._running.setdefault(name, hashlib.sha256())
        kind = type_name(values.dtype)
        if kind == "str":
            # each text with its own length, so that the digest does not depend on how the rows were cut
            encoded = (str(value).encode("utf-8", "surrogatepass") for value in values.ravel().tolist())
            running.update(b"".join(len(text).to_bytes(8, "little") + text for text in encoded))
        elif values.dtype.kind == "V":
            # no log of ours holds records, but one that was damaged may, and its digest is wanted
            running.update(values.astype(values.dtype.newbyteorder("<")).tobytes())
        else:
            running.update(np.ascontiguousarray(values, dtype=kind).data.cast("B") if values.size else b"")

    def hexdigest(self, log: xr.Dataset) -> str:
        """Return the digest of the whole log, whose variables have all been added."""
        whole = hashlib.sha256()
        for name in sorted(map(str, log.variables)):
            variable = log.variables[name]
            shape = "x".join(map(str, variable.shape))
            running = self._running.get(name, hashlib.sha256()).hexdigest()
            kind = type_name(variable.dtype)
            whole.update(f"{name}|{','.join(map(str, variable.dims))}|{kind}|{shape}|{running}\n".encode())
            whole.update(_attrs_text(variable.attrs).encode())
        whole.update(_attrs_text(log.attrs).encode())
        return whole.hexdigest()


def content_digest(log: xr.Dataset) -> str:
    """Return the SHA-256 of what a log says; a log on disk is read a slab at a time.

    Examples
    --------
    >>> log = xr.Dataset({"time": ("sample", [0.0, 0.1])})
    >>> content_digest(log) == content_digest(log.assign(time=("sample", [0.0, 0.2])))
    False
    """
    digest = ContentDigest()
    for name in map(str, log.variables):
        for rows in slabs(log, name):
            digest.update(name, np.asarray(log.variables[name][rows].values))
    return digest.hexdigest(log)


def slabs(log: xr.Dataset, name: str) -> Iterator[tuple[slice, ...]]:
    """Yield slices of a variable's first dimension, about 16 MiB each."""
    shape = log.variables[name].shape
    if not shape or log.variables[name].dtype.kind in "OUT":
        # text is read whole: its rows have no size of their own
        yield ()
        return
    row_bytes = max(1, log.variables[name].dtype.itemsize * int(np.prod(shape[1:], dtype=np.int64)))
    step = max(1, _SLAB_BYTES // row_bytes)
    for start in range(0, shape[0], step):
        yield (slice(start, min(start + step, shape[0])),)


def type_name(dtype: np.dtype[np.generic]) -> str:
    """Return ``"str"`` for text however it is held, else the little-endian name of a type, e.g. ``"<f8"``."""
    return "str" if dtype.kind in "OUT" else dtype.newbyteorder("<").str


def _attrs_text(attrs: Mapping[object, object]) -> str:
    return "".join(
        f"{name}={_plain_text(attrs[name])}\n" for name in sorted(attrs, key=str) if name != DIGEST_ATTR
    )


def _plain_text(value: object) -> str:
    # a file gives back 5 as int64(5) or array([5]), and text as bytes; all of these have one text
    array = np.asarray(value)
    if array.dtype.kind in "SUO":
        items = [item.decode() if isinstance(item, bytes) else str(item) for item in array.ravel().tolist()]
        return f"str:{items}"
    return f"{array.dtype.kind}:{array.ravel().tolist()}"
