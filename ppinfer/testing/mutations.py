"""Damage and edits that a reader has to withstand: from a valid file and a seed to a mutated one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

Effect = Literal["same", "damage", "edit"]
Mutator = Callable[[bytes, np.random.Generator], tuple[str, Effect, bytes]]
"""From the content of a file: what was done, what that means for a reader, and the new content."""


@dataclass(frozen=True)
class Mutation:
    """One input made of valid ones.

    Parameters
    ----------
    name
        What was done, for messages.
    effect
        ``"same"``: it says what it said, in other bytes; ``"damage"``: bytes changed as no writer would, so that any
        checksum must notice; ``"edit"``: rewritten with another content (and its checksum, where it has one).
    files
        The content of each file, by its name within the folder.
    """

    name: str
    effect: Effect
    files: dict[str, bytes]


def mutate(files: Mapping[str, bytes], rng: np.random.Generator) -> Mutation:
    r"""Mutate one of some valid files: damage its bytes, or edit it as its format allows.

    Formats are told by suffix: ``.csv``, ``.txt``, ``.jsonl``, ``.json``, ``.toml``, ``.nc``, ``.npz``, ``.parquet``
    and ``.safetensors``; a folder with ``zarr.json`` is a Zarr store. Of others, bytes alone are damaged.

    Parameters
    ----------
    files
        The content of each file, by its name within a folder.
    rng
        What draws all of it.

    Returns
    -------
    Mutation
        The files anew, and what was done.

    Examples
    --------
    >>> mutation = mutate({"reaches.csv": b"t,x\n0,1\n1,2\n"}, np.random.default_rng(4))
    >>> mutation.name
    'reaches.csv: 64 bytes appended'
    """
    chosen = dict(files)
    stores = sorted(
        {name[: -len("zarr.json")] for name in files if name.split("/")[-1] == "zarr.json"}, key=len
    )
    if stores and rng.random() < 0.4:
        from ppinfer.testing.array_mutations import mutated_store

        root = stores[0]
        inside = {name[len(root) :]: content for name, content in files.items() if name.startswith(root)}
        told, effect, changed = mutated_store(inside, rng)
        chosen = {name: content for name, content in files.items() if not name.startswith(root)}
        return Mutation(
            f"{root or 'store'}: {told}",
            effect,
            chosen | {root + name: part for name, part in changed.items()},
        )
    if len(files) > 1 and rng.random() < 0.08:
        return _among(chosen, rng)
    name = sorted(files)[rng.integers(len(files))]
    ways = _editors(name)
    edit = ways[int(rng.integers(len(ways)))] if ways and rng.random() < 0.6 else damaged_bytes
    told, effect, chosen[name] = edit(files[name], rng)
    return Mutation(f"{name}: {told}", effect, chosen)


def _editors(name: str) -> Sequence[Mutator]:
    # imported when wanted: each needs the library of its format
    suffix = "." + name.split("/")[-1].rpartition(".")[2].lower()
    if suffix in (".csv", ".txt", ".jsonl", ".json", ".toml"):
        from ppinfer.testing import text_mutations as text

        return {
            ".csv": (text.mutated_table, text.mutated_table, text.mutated_text),
            ".txt": (text.mutated_columns, text.mutated_columns, text.mutated_text),
            ".jsonl": (text.mutated_lines, text.mutated_lines, text.mutated_text),
            ".json": (text.mutated_json,),
            ".toml": (text.mutated_toml, text.mutated_toml, text.mutated_text),
        }[suffix]
    if suffix in (".nc", ".npz", ".parquet", ".safetensors"):
        from ppinfer.testing import array_mutations as arrays

        return {
            ".nc": (arrays.mutated_netcdf, arrays.mutated_netcdf, arrays.mutated_hdf5),
            ".npz": (arrays.mutated_npz,),
            ".parquet": (arrays.mutated_parquet,),
            ".safetensors": (arrays.mutated_safetensors,),
        }[suffix]
    return ()


def _among(files: dict[str, bytes], rng: np.random.Generator) -> Mutation:
    """Lose, swap or add files of a folder."""
    one, other = (sorted(files)[index] for index in rng.choice(len(files), 2, replace=False))
    way = rng.integers(3)
    if way == 0:
        del files[one]
        return Mutation(f"{one}: lost", "damage", files)
    if way == 1:
        files[one], files[other] = files[other], files[one]
        return Mutation(f"{one}: swapped with {other}", "damage", files)
    files[one] = files[other]
    return Mutation(f"{one}: overwritten with {other}", "damage", files)


def damaged_bytes(content: bytes, rng: np.random.Generator) -> tuple[str, Effect, bytes]:
    r"""Damage bytes: cut, flip, insert, remove, zero, double, swap, overwrite with huge numbers, append, replace.

    Examples
    --------
    >>> damaged_bytes(b"0123456789", np.random.default_rng(3))
    ('2 bytes overwritten with 32767 at 2', 'damage', b'01\xff\x7f456789')
    """
    if not content:
        return "garbage in its place", "damage", rng.bytes(int(rng.integers(1, 100)))
    ways = (_cut, _flip, _flip, _insert, _remove, _zero, _double, _swap, _huge, _append, _replace)
    told, changed = ways[rng.integers(len(ways))](content, rng)
    return told, "damage", changed


def _place(content: bytes, rng: np.random.Generator) -> int:
    # headers and the ends of files decide most, and are a small part of them
    size = len(content)
    where = rng.random()
    if where < 0.35:
        return int(rng.integers(min(size, 2048)))
    if where < 0.45:
        return int(size - 1 - rng.integers(min(size, 512)))
    return int(rng.integers(size))


def _span(content: bytes, rng: np.random.Generator) -> tuple[int, int]:
    start = _place(content, rng)
    longest = int(2 ** rng.integers(0, 13))
    return start, min(len(content), start + int(rng.integers(1, longest + 1)))


def _cut(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    length = _place(content, rng)
    return f"cut off after {length} of {len(content)} bytes", content[:length]


def _flip(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    changed = bytearray(content)
    bits = [8 * _place(content, rng) + int(rng.integers(8)) for _ in range(int(2 ** rng.integers(0, 5)))]
    for bit in bits:
        changed[bit // 8] ^= 1 << bit % 8
    return f"bits {bits} flipped", bytes(changed)


def _insert(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    at, count = _place(content, rng), int(2 ** rng.integers(0, 10))
    return f"{count} bytes inserted at {at}", content[:at] + rng.bytes(count) + content[at:]


def _remove(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    start, stop = _span(content, rng)
    return f"{stop - start} bytes removed at {start}", content[:start] + content[stop:]


def _zero(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    start, stop = _span(content, rng)
    return f"{stop - start} bytes zeroed at {start}", content[:start] + bytes(stop - start) + content[stop:]


def _double(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    start, stop = _span(content, rng)
    return f"{stop - start} bytes doubled at {start}", content[:stop] + content[start:]


def _swap(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    (start, stop), other = _span(content, rng), _place(content, rng)
    block = content[start:stop]
    rest = content[:start] + content[stop:]
    return f"{stop - start} bytes moved from {start} to {other}", rest[:other] + block + rest[other:]


def _huge(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    size = int(rng.choice([2, 4, 8]))
    number = int(rng.choice([2 ** (8 * size - 1) - 1, 2 ** (8 * size - 2), 2 ** (4 * size), 10**4]))
    at = _place(content, rng)
    told = f"{size} bytes overwritten with {number} at {at}"
    return told, (content[:at] + number.to_bytes(size, "little") + content[at + size :])


def _append(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    count = int(2 ** rng.integers(0, 12))
    return f"{count} bytes appended", content + (rng.bytes(count) if rng.random() < 0.5 else bytes(count))


def _replace(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    kept = int(rng.choice([0, 4, 8, 64]))
    return f"garbage after {kept} bytes", content[:kept] + rng.bytes(int(2 ** rng.integers(0, 12)))
