"""What a Zarr store may hold: a folder of plain files, arrays of numbers and text, unpacked in the usual ways."""

from __future__ import annotations

import json
import math
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ppinfer.errors import LogError
from ppinfer.guarding.fingerprints import MOST_ENTRIES
from ppinfer.guarding.limits import Limits, how_to_allow_more, told_bytes

MOST_ARRAYS = 4096
MOST_METADATA_BYTES = 1 << 24
MOST_CHUNKS = 1_000_000
MOST_DEPTH = 16
_CODECS = frozenset(
    {"bytes", "vlen-utf8", "zstd", "gzip", "blosc", "crc32c", "transpose", "sharding_indexed"}
)
_SIZES = {
    "bool": 1, "int8": 1, "int16": 2, "int32": 4, "int64": 8, "uint8": 1, "uint16": 2, "uint32": 4, "uint64": 8,
    "float16": 2, "float32": 4, "float64": 8, "string": 16,
}  # fmt: skip
_TEXT = "fixed_length_utf32"


def check_zarr(path: Path, limits: Limits) -> None:
    """Refuse what no store of ours holds: links, pipes, nested groups, other codecs, absurd sizes.

    A link within a store would read what lies elsewhere; codecs not known to be harmless are refused by name.

    Raises
    ------
    LogError
        Naming the first of them.

    Examples
    --------
    >>> Path("store.zarr").mkdir()
    >>> Path("store.zarr", "time").symlink_to("/etc")
    >>> check_zarr(Path("store.zarr"), Limits(1.0, 1 << 30))
    Traceback (most recent call last):
        ...
    ppinfer.errors.LogError: store.zarr: 'time' is a link; a store holds all of its content itself
    """
    documents = [place for place in _files(path) if place.name == "zarr.json"]
    root = path / "zarr.json"
    if len(documents) > MOST_ARRAYS:
        raise LogError(f"{path}: holds {len(documents)} arrays, more than the {MOST_ARRAYS} that are read")
    claimed = chunks = 0
    for place in sorted(documents):
        inside = place.parent.relative_to(path).as_posix()
        told = _document(path, place)
        if place == root:
            if told.get("node_type") != "group":
                raise LogError(f"{path}: is no Zarr group; a log is one group of arrays")
            if told.get("consolidated_metadata"):
                raise LogError(
                    f"{path}: describes its arrays twice (consolidated metadata); write it without"
                )
            continue
        if told.get("node_type") != "array":
            raise LogError(f"{path}: {inside!r} is a group within the group; a log has none")
        size, parts = _claims(path, inside, told)
        claimed, chunks = claimed + size, chunks + parts
    if claimed > limits.memory:
        raise LogError(
            f"{path}: claims {told_bytes(claimed)}, more than the {told_bytes(limits.memory)} that a store of its size "
            "may unpack to: " + how_to_allow_more("MEMORY", f"{(2 * claimed >> 30) + 1}G")
        )
    if chunks > MOST_CHUNKS:
        raise LogError(
            f"{path}: is cut into {chunks} chunks, more than the {MOST_CHUNKS} that are read; use larger ones"
        )


def _files(path: Path) -> Iterator[Path]:
    """Yield every file below a folder; whatever is no plain file or folder is refused."""
    folders, count = [(path, 0)], 0
    while folders:
        folder, depth = folders.pop()
        if depth > MOST_DEPTH:
            raise LogError(f"{path}: its folders lie more than {MOST_DEPTH} deep")
        with os.scandir(folder) as found:
            for entry in found:
                count += 1
                if count > MOST_ENTRIES:
                    raise LogError(f"{path}: holds more than {MOST_ENTRIES} files and folders")
                mode = entry.stat(follow_symlinks=False).st_mode
                place = Path(entry.path)
                inside = place.relative_to(path).as_posix()
                if "\\" in entry.name:
                    # what is a folder within a folder on another system
                    raise LogError(f"{path}: {inside!r} is a name that leads out of the store")
                if stat.S_ISLNK(mode):
                    raise LogError(f"{path}: {inside!r} is a link; a store holds all of its content itself")
                if stat.S_ISDIR(mode):
                    folders.append((place, depth + 1))
                elif stat.S_ISREG(mode):
                    yield place
                else:
                    raise LogError(f"{path}: {inside!r} is a pipe, a socket or a device; a store holds files")


def _document(path: Path, place: Path) -> dict[str, Any]:
    inside = place.relative_to(path).as_posix()
    size = place.stat().st_size
    if size > MOST_METADATA_BYTES:
        raise LogError(
            f"{path}: {inside!r} is {told_bytes(size)} large, more than the {told_bytes(MOST_METADATA_BYTES)} that "
            "are read of metadata"
        )
    try:
        told = json.loads(place.read_bytes(), object_pairs_hook=_once)
    except RecursionError as error:
        raise LogError(f"{path}: {inside!r} is nested too deeply") from error
    except ValueError as error:
        raise LogError(f"{path}: {inside!r} is damaged: {error}; get it again from its source") from error
    if not isinstance(told, dict):
        raise LogError(f"{path}: {inside!r} is damaged: it is no JSON object; get it again from its source")
    return told


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    told = dict(pairs)
    if len(told) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{twice!r} is there twice")
    return told


def _claims(path: Path, inside: str, told: dict[str, Any]) -> tuple[int, int]:
    """Return how many bytes an array claims and how many chunks, having refused what it may not be."""
    shape = _whole_numbers(path, inside, "shape", told.get("shape"), least=0)
    grid = told.get("chunk_grid")
    if not isinstance(grid, dict) or grid.get("name") != "regular":
        raise LogError(f"{path}: {inside!r} has a chunk grid that is not read; 'regular' is")
    chunk = _whole_numbers(path, inside, "chunk_shape", _entry(grid, "chunk_shape"), least=1)
    if len(chunk) != len(shape):
        raise LogError(f"{path}: {inside!r} has shape {shape} but chunks of shape {chunk}")
    keys = told.get("chunk_key_encoding")
    if not isinstance(keys, dict) or keys.get("name") not in ("default", "v2"):
        raise LogError(f"{path}: {inside!r} has a chunk key encoding that is not read; 'default' is")
    if (separator := _entry(keys, "separator")) not in (None, "/", "."):
        raise LogError(f"{path}: {inside!r} separates chunk keys by {separator!r}; '/' and '.' are read")
    if told.get("storage_transformers"):
        raise LogError(f"{path}: {inside!r} has storage transformers, which are not read")
    _check_codecs(path, inside, told.get("codecs"))
    size = _item_size(path, inside, told.get("data_type"))
    # a chunk is unpacked whole, however little of it lies within the array
    return size * max(math.prod(shape), math.prod(chunk)), math.prod(
        -(-length // part) for length, part in zip(shape, chunk, strict=True)
    )


def _entry(told: dict[str, Any], name: str) -> Any:
    configuration = told.get("configuration")
    return configuration.get(name) if isinstance(configuration, dict) else None


def _whole_numbers(path: Path, inside: str, name: str, told: Any, *, least: int) -> tuple[int, ...]:
    if (
        not isinstance(told, list)
        or len(told) > 16
        or any(type(one) is not int or one < least for one in told)
    ):
        raise LogError(
            f"{path}: {inside!r} has {name} {str(told)[:80]}; whole numbers from {least} are expected"
        )
    return tuple(told)


def _item_size(path: Path, inside: str, told: Any) -> int:
    if isinstance(told, dict) and told.get("name") == _TEXT:
        length = _entry(told, "length_bytes")
        if type(length) is int and 0 < length <= 1 << 20:
            return length
    if isinstance(told, str) and told in _SIZES:
        return _SIZES[told]
    name = told.get("name") if isinstance(told, dict) else told
    raise LogError(f"{path}: {inside!r} is of type {str(name)[:80]!r}; a store holds numbers and text")


def _check_codecs(path: Path, inside: str, told: Any) -> None:
    if not isinstance(told, list):
        raise LogError(f"{path}: {inside!r} has no list of codecs; get it again from its source")
    for one in told:
        name = one.get("name") if isinstance(one, dict) else one
        if not isinstance(name, str) or name not in _CODECS:
            raise LogError(
                f"{path}: {inside!r} is packed with the codec {str(name)[:80]!r}, which is not read; pack it with "
                f"{', '.join(sorted(_CODECS))}"
            )
        if name == "sharding_indexed":
            for inner in ("codecs", "index_codecs"):
                _check_codecs(path, inside, _entry(one, inner))
