"""What a NetCDF file may hold: arrays of numbers and text in the file itself, compressed in the usual ways."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from ppinfer.errors import LogError
from ppinfer.guarding.limits import Limits, how_to_allow_more, told_bytes

MOST_VARIABLES = 4096
MOST_ATTRIBUTES = 4096
MOST_ATTRIBUTE_BYTES = 1 << 26
_FILTERS = {1: "deflate", 2: "shuffle", 3: "fletcher32"}
_KNOWN_FILTERS = {
    4: "szip", 5: "nbit", 6: "scaleoffset", 305: "lzo", 307: "bzip2", 32000: "lzf", 32001: "blosc", 32004: "lz4",
    32008: "bitshuffle", 32013: "zfp", 32015: "zstd", 32026: "blosc2",
}  # fmt: skip


def check_hdf5(path: Path, limits: Limits) -> None:
    """Refuse what no log holds: links, groups, other files' content, other filters, absurd sizes.

    Links to other files, external storage and virtual arrays would read other files than this one; filters beyond
    HDF5's own deflate, shuffle and fletcher32 would load code from elsewhere.

    Raises
    ------
    LogError
        Naming the first of them.

    Examples
    --------
    >>> import h5py
    >>> with h5py.File("links.nc", "w") as file:
    ...     file["time"] = h5py.ExternalLink("/etc/passwd", "/")
    >>> check_hdf5(Path("links.nc"), Limits(1.0, 1 << 30))
    Traceback (most recent call last):
        ...
    ppinfer.errors.LogError: links.nc: 'time' is a link to another file; a log holds all of its content itself
    """
    import h5py

    with h5py.File(path, "r") as file:
        if len(file) > MOST_VARIABLES:
            raise LogError(
                f"{path}: holds {len(file)} variables, more than the {MOST_VARIABLES} that are read"
            )
        _check_attributes(path, "the file", file)
        claimed = 0
        for name in file:
            link = file.get(name, getlink=True)
            if isinstance(link, h5py.ExternalLink):
                raise LogError(
                    f"{path}: {name!r} is a link to another file; a log holds all of its content itself"
                )
            if not isinstance(link, h5py.HardLink):
                raise LogError(f"{path}: {name!r} is a link; a log holds all of its content itself")
            held: Any = file[name]
            if isinstance(held, h5py.Group):
                raise LogError(f"{path}: {name!r} is a group; a log has none")
            if not isinstance(held, h5py.Dataset):
                continue
            _check_storage(path, name, held)
            _check_attributes(path, repr(name), held)
            claimed += held.id.get_type().get_size() * math.prod(held.shape or ())
        if claimed > limits.memory:
            raise LogError(
                f"{path}: claims {told_bytes(claimed)}, more than the {told_bytes(limits.memory)} that a file of its "
                "size may unpack to: " + how_to_allow_more("MEMORY", f"{(2 * claimed >> 30) + 1}G")
            )


def _check_storage(path: Path, name: str, held: Any) -> None:
    import h5py

    made = held.id.get_create_plist()
    if made.get_layout() == h5py.h5d.VIRTUAL:
        raise LogError(
            f"{path}: {name!r} is a virtual array of other files' content; a log holds all of it itself"
        )
    if made.get_external_count():
        raise LogError(f"{path}: {name!r} is stored in another file; a log holds all of its content itself")
    for index in range(made.get_nfilters()):
        code, _, _, told = made.get_filter(index)
        if code not in _FILTERS:
            called = _KNOWN_FILTERS.get(code) or told.decode(errors="replace") or "unknown"
            raise LogError(
                f"{path}: {name!r} is packed with the filter {called!r} ({code}), which is not read; pack it with "
                f"{', '.join(_FILTERS.values())}"
            )
    kind = held.id.get_type().get_class()
    if kind not in (h5py.h5t.INTEGER, h5py.h5t.FLOAT, h5py.h5t.STRING, h5py.h5t.ENUM):
        names = {
            h5py.h5t.COMPOUND: "compound", h5py.h5t.VLEN: "lists", h5py.h5t.REFERENCE: "references",
            h5py.h5t.OPAQUE: "opaque", h5py.h5t.ARRAY: "arrays", h5py.h5t.BITFIELD: "bit fields",
        }  # fmt: skip
        told = names.get(kind, str(kind))
        raise LogError(
            f"{path}: {name!r} holds values of another kind ({told}); a log holds numbers and text"
        )


def _check_attributes(path: Path, whose: str, held: Any) -> None:
    import h5py

    count = h5py.h5a.get_num_attrs(held.id)
    if count > MOST_ATTRIBUTES:
        raise LogError(
            f"{path}: {whose} has {count} attributes, more than the {MOST_ATTRIBUTES} that are read"
        )
    size = sum(h5py.h5a.open(held.id, index=index).get_storage_size() for index in range(count))
    if size > MOST_ATTRIBUTE_BYTES:
        raise LogError(
            f"{path}: {whose} has attributes of {told_bytes(size)}, more than the {told_bytes(MOST_ATTRIBUTE_BYTES)} "
            "that are read"
        )
