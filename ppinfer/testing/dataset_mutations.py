"""Edits of a dataset: variables of other types, swapped, lost, renamed; rows shuffled; numbers that are none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ppinfer.studies.checksums import content_digest
from ppinfer.studies.schema import DIGEST_ATTR
from ppinfer.studies.storage import plain_text
from ppinfer.testing.mutations import Effect

_NUMBERS = (np.nan, np.inf, -np.inf, 1e308, -1e308, 1e-320, -1.0, 0.0, 2.0**31, -(2.0**62), 127.0, -128.0)
_ATTRS: tuple[Any, ...] = (
    "",
    "x",
    0,
    -1,
    1.5,
    np.nan,
    [1, 2],
    ["a", "b"],
    "{",
    "[]",
    "x" * 10_000,
    2**62,
    "null",
    "3",
)


def mutated_dataset(dataset: xr.Dataset, rng: np.random.Generator) -> tuple[str, Effect, xr.Dataset]:
    """Edit a dataset in one way; its digest, where it has one, is made anew in most cases.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> told, effect, changed = mutated_dataset(example_log(), np.random.default_rng(1))
    >>> told
    "attribute long_name = '0'"
    """
    dataset = plain_text(dataset.drop_encoding())
    stated = dataset.attrs.get(DIGEST_ATTR)
    told, changed = _edited(dataset, rng)
    if told == "written anew":
        return told, "same", changed
    if stated is None:
        return told, "edit", changed
    if rng.random() < 0.2:
        return f"{told}, not signed anew", "damage", changed
    changed.attrs[DIGEST_ATTR] = content_digest(plain_text(changed))
    return told, "edit", changed


def _edited(dataset: xr.Dataset, rng: np.random.Generator) -> tuple[str, xr.Dataset]:
    names = sorted(map(str, dataset.variables))
    name = names[rng.integers(len(names))]
    variable = dataset.variables[name]
    way = rng.integers(12)
    if way == 0:
        return "written anew", dataset
    if way == 1:
        return f"{name} lost", dataset.drop_vars(name)
    if way == 2:
        return f"{name} renamed", xr.Dataset(
            {f"{key}_" if key == name else key: item for key, item in dataset.variables.items()},
            attrs=dataset.attrs,
        )
    if way == 3:
        alike = [other for other in names if other != name and dataset.variables[other].dims == variable.dims]
        other = alike[rng.integers(len(alike))] if alike else name
        swapped = {name: dataset.variables[other], other: dataset.variables[name]}
        return f"{name} and {other} swapped", _with(dataset, swapped)
    if way == 4:
        dims = sorted(map(str, dataset.dims))
        dim = dims[rng.integers(len(dims))]
        return f"dimension {dim} renamed", dataset.rename_dims({dim: f"{dim}_"}) if (
            dim not in dataset.coords
        ) else dataset.drop_vars(dim)
    if way == 5:
        dims = sorted(map(str, dataset.dims))
        dim = dims[rng.integers(len(dims))]
        size = dataset.sizes[dim]
        kind = rng.integers(4)
        rows: Any = {
            0: rng.permutation(size),
            1: np.sort(np.append(np.arange(size), rng.integers(0, max(size, 1), 3 if size else 0))),
            2: np.arange(size // 2),
            3: np.arange(0),
        }[int(kind)]
        told = ("shuffled", "doubled", "halved", "all lost")[kind]
        return f"rows of {dim} {told}", dataset.isel({dim: rows})
    if way == 6:
        holder = dataset if rng.random() < 0.7 else dataset[name]
        keys = sorted(map(str, holder.attrs)) or ["units"]
        key = keys[rng.integers(len(keys))]
        value = _ATTRS[rng.integers(len(_ATTRS))]
        changed = dataset.copy()
        (changed if holder is dataset else changed.variables[name]).attrs[key] = value
        return f"attribute {key} = {str(value)[:30]!r}", changed
    if way == 7:
        held = variable.transpose(*variable.dims[::-1])
        return f"{name} transposed", _with(dataset, {name: held})
    told, array = changed_array(variable.values, rng)
    if array.shape != variable.shape:
        axes = tuple(f"{name}_{axis}" for axis in range(array.ndim))
        return f"{name} {told}", _with(dataset, {name: xr.Variable(axes, array, variable.attrs)})
    return f"{name} {told}", _with(dataset, {name: xr.Variable(variable.dims, array, variable.attrs)})


def _with(dataset: xr.Dataset, changed: dict[str, xr.Variable]) -> xr.Dataset:
    # made of variables alone, so that no index keeps a label as it was
    return xr.Dataset({**dataset.variables, **changed}, attrs=dict(dataset.attrs))


def changed_array(array: np.ndarray, rng: np.random.Generator) -> tuple[str, np.ndarray]:
    """Return an array with some cells, its type or its shape changed, and what was done.

    Examples
    --------
    >>> changed_array(np.arange(3.0), np.random.default_rng(3))
    ('with 1 cells of -inf', array([-inf,   1.,   2.]))
    """
    way = rng.integers(8)
    if way == 0:
        return "reversed", np.asarray(np.flip(array))
    if way == 1:
        return "cut", array[: array.shape[0] // 2] if array.ndim else array[None]
    if way == 2:
        wanted = str(rng.choice(["int32", "float32", "complex128", "uint8", "bool", "int64", "float64"]))
        if array.dtype.kind in "OUT":
            return f"as {wanted}", np.zeros(array.shape, wanted)
        with np.errstate(all="ignore"):
            return f"as {wanted}", np.nan_to_num(array).astype(wanted) if wanted[
                0
            ] in "iub" else array.astype(wanted)
    if way == 3:
        return "as text", array.astype(str).astype(object)
    changed = array.copy()
    count = min(array.size, 2 ** int(rng.integers(0, 6)))
    if not count:
        return "left", changed
    flat = rng.choice(array.size, count, replace=False)
    if array.dtype.kind in "OUT":
        words = ["", "x", "\x1b[31m", "=cmd()", "<script>", "é" * 200, str(array.ravel()[0]), "{", "\n"]
        word = words[rng.integers(len(words))]
        changed = changed.astype(object)
        changed.ravel()[flat] = word
        return f"with {count} cells of {word[:20]!r}", changed
    number = _NUMBERS[rng.integers(len(_NUMBERS))]
    if array.dtype.kind in "iub":
        number = int(np.clip(np.nan_to_num(number), -(2**62), 2**62))
        with np.errstate(all="ignore"):
            changed.ravel()[flat] = np.asarray(number).astype(array.dtype)
    else:
        with np.errstate(all="ignore"):
            changed.ravel()[flat] = np.asarray(number).astype(array.dtype)
    return f"with {count} cells of {number:g}", changed


def written(dataset: xr.Dataset, target: Path) -> dict[str, bytes]:
    """Write a dataset as it is, as HDF5 or Zarr; return the content by name within ``target`` (a file's is "").

    What the format cannot hold, text stands for.
    """
    for name, variable in list(dataset.variables.items()):
        if variable.dtype.kind == "c" and target.suffix == ".zarr":
            dataset = _with(dataset, {str(name): variable.astype(str).astype(object)})
    if target.suffix == ".h5":
        # what NetCDF does not allow is written, too: named so, it is no cause for a warning
        text: dict[Any, Any] = {
            # left alone, xarray guesses that no text is numbers, and says what stands for a number that is not there
            name: {"dtype": str} if variable.dtype.kind == "O" and not variable.size else {"_FillValue": None}
            for name, variable in dataset.variables.items()
        }
        dataset.to_netcdf(target, engine="h5netcdf", invalid_netcdf=True, encoding=text)
        return {"": target.read_bytes()}
    for name, variable in list(dataset.variables.items()):
        if variable.dtype.kind == "O":
            words = xr.Variable(
                variable.dims, variable.values.astype(np.dtypes.StringDType()), variable.attrs
            )
            dataset = _with(dataset, {str(name): words})
    dataset.to_zarr(target, mode="w-", zarr_format=3, consolidated=False)
    return {
        item.relative_to(target).as_posix(): item.read_bytes()
        for item in sorted(target.rglob("*"))
        if item.is_file()
    }
