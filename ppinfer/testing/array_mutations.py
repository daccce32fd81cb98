"""Edits of files that hold arrays: NetCDF, Zarr, npz, Parquet and safetensors, with wrong types, shapes and headers."""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ppinfer.testing.dataset_mutations import changed_array, mutated_dataset, written
from ppinfer.testing.mutations import Effect, damaged_bytes
from ppinfer.testing.text_mutations import changed_value, mutated_json

_TYPES = ("<i4", "<f4", ">f8", "<c16", "S8", "?", "<u8", "<f2")


def mutated_netcdf(content: bytes, rng: np.random.Generator) -> tuple[str, Effect, bytes]:
    """Rewrite a NetCDF file with another content, its digest made anew where it has one.

    Examples
    --------
    >>> from ppinfer.studies import write_log
    >>> from ppinfer.testing import example_log
    >>> write_log(example_log(), "log.nc")
    >>> told, effect, changed = mutated_netcdf(Path("log.nc").read_bytes(), np.random.default_rng(0))
    >>> told, effect
    ('time transposed', 'edit')
    """
    import xarray as xr

    with xr.open_dataset(
        io.BytesIO(content), engine="h5netcdf", decode_times=False, decode_timedelta=False
    ) as opened:
        told, effect, dataset = mutated_dataset(opened.load(), rng)
    with tempfile.TemporaryDirectory() as folder:
        return told, effect, written(dataset, Path(folder, "mutated.h5"))[""]


def mutated_store(
    files: Mapping[str, bytes], rng: np.random.Generator
) -> tuple[str, Effect, dict[str, bytes]]:
    """Mutate a Zarr store: rewrite it with another content, or change, lose or damage files of it."""
    import xarray as xr

    chosen = dict(files)
    if rng.random() < 0.4:
        with tempfile.TemporaryDirectory() as folder:
            for name, content in files.items():
                Path(folder, "s.zarr", name).parent.mkdir(parents=True, exist_ok=True)
                Path(folder, "s.zarr", name).write_bytes(content)
            with xr.open_dataset(
                Path(folder, "s.zarr"), engine="zarr", consolidated=False, chunks=None, decode_times=False
            ) as opened:
                told, effect, dataset = mutated_dataset(opened.load(), rng)
            return told, effect, written(dataset, Path(folder, "mutated.zarr"))
    heads = sorted(name for name in files if name.endswith("zarr.json"))
    chunks = sorted(set(files) - set(heads))
    way = rng.integers(4)
    if way <= 1 or not chunks:
        name = heads[rng.integers(len(heads))]
        told, _, chosen[name] = mutated_json(files[name], rng)
        return f"{name}: {told}", "damage", chosen
    name = chunks[rng.integers(len(chunks))]
    if way == 2:
        del chosen[name]
        return f"{name}: lost", "damage", chosen
    other = chunks[rng.integers(len(chunks))]
    chosen[name], chosen[other] = files[other], files[name]
    return f"{name}: swapped with {other}", "damage", chosen


def mutated_hdf5(content: bytes, rng: np.random.Generator) -> tuple[str, Effect, bytes]:
    """Replace a dataset or attribute within an HDF5 file by what HDF5 allows and nobody expects."""
    import h5py

    buffer = io.BytesIO(content)
    with h5py.File(buffer, "r+") as file:
        names = sorted(name for name in file if isinstance(file[name], h5py.Dataset))
        name = names[rng.integers(len(names))]
        attributes = rng.random() < 0.4
        told = _changed_attribute(file, name, rng) if attributes else _changed_member(file, name, rng)
    return told, "damage", buffer.getvalue()


def _changed_attribute(file: Any, name: str, rng: np.random.Generator) -> str:
    import h5py

    holder, where = (file, "/") if rng.random() < 0.4 else (file[name], name)
    known = [*holder.attrs, "scale_factor", "add_offset", "_FillValue", "units", "_Unsigned", "coordinates"]
    attribute = str(known[rng.integers(len(known))])
    values: list[Any] = [
        None, 2.0, -1, "", "x", b"\xff\xfe", "days since 2000-01-01", [1, 2, 3], np.nan, np.inf, "a" * 60_000,
        h5py.Empty("f8"), np.zeros(2, [("a", "f8"), ("b", "i4")]), file.ref, 2**63, "true", ["a", "b"],
    ]  # fmt: skip
    value = values[rng.integers(len(values))]
    if attribute in holder.attrs:
        del holder.attrs[attribute]
    if value is not None:
        holder.attrs[attribute] = value
    return f"attribute {attribute} of {where} = {str(value)[:30]}"


def _changed_member(file: Any, name: str, rng: np.random.Generator) -> str:
    import h5py

    # held by its number, since links to what is removed would dangle otherwise
    shape, kind, values = file[name].shape, file[name].dtype, file[name][()]
    attrs = {
        key: file[name].attrs[key]
        for key in file[name].attrs
        if key not in ("REFERENCE_LIST", "CLASS", "NAME")
    }
    del file[name]
    way = int(rng.integers(12))
    told = f"{name} is "
    made = None
    if way == 0:
        made, told = file.create_dataset(name, shape=(10**12,), dtype="f8", chunks=(1000,)), told + "huge"
    elif way == 1:
        file[name] = h5py.ExternalLink("/etc/hostname", "/data")
        return told + "a link to another file"
    elif way == 2:
        file[name] = h5py.SoftLink(f"/{name}")
        return told + "a link to itself"
    elif way == 3:
        file.create_group(name).create_group("inside")
        return told + "a group"
    elif way == 4:
        outside = [("/etc/hostname", 0, 8 * max(1, int(np.prod(shape))))]
        made = file.create_dataset(name, shape=shape or (1,), dtype="f8", external=outside)
        told += "stored in another file"
    elif way == 5:
        made, told = file.create_dataset(name, data=h5py.Empty("f8")), told + "empty"
    elif way == 6:
        made = file.create_dataset(name, shape=shape, dtype=h5py.vlen_dtype(np.int32))
        told += "lists of numbers"
    elif way == 7:
        made = file.create_dataset(name, shape=shape, dtype=[("a", "f8"), ("b", "S4")])
        told += "pairs"
    elif way == 8:
        made = file.create_dataset(
            name, shape=shape, dtype=h5py.enum_dtype({"NO": 0, "YES": 1}, basetype="i1")
        )
        told += "an enumeration"
    elif way == 9:
        made, told = file.create_dataset(name, shape=shape, dtype=h5py.ref_dtype), told + "references"
    elif way == 10:
        made = file.create_dataset(
            name, data=values, dtype=kind, maxshape=(None,) * len(shape) if shape else None
        )
        told += "bare of its dimensions"
        attrs = {}
    else:
        wanted = str(rng.choice(_TYPES))
        data = np.zeros(shape, wanted) if kind.kind == "O" else values.astype(wanted)
        made, told = file.create_dataset(name, data=data), told + f"of type {wanted}"
    for key, value in attrs.items():
        made.attrs[key] = value
    return told


def mutated_npz(content: bytes, rng: np.random.Generator) -> tuple[str, Effect, bytes]:
    """Rewrite an npz archive: arrays of other types, shapes and numbers, pickles, false headers, odd members.

    Examples
    --------
    >>> out = io.BytesIO()
    >>> np.savez(out, x=np.zeros(3), y=np.ones(3))
    >>> mutated_npz(out.getvalue(), np.random.default_rng(5))[:2]
    ('y reversed', 'edit')
    """
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = sorted(members)[rng.integers(len(members))]
    way = rng.integers(8)
    if way == 0:
        del members[name]
        return f"{name} lost", "edit", _zipped(members)
    if way == 1:
        members[f"../{name}"] = members.pop(name)
        return f"{name} outside of the archive", "damage", _zipped(members)
    if way == 2:
        claimed = str(rng.choice(["(100000000000,)", "(4, 1000000000)", "(-1,)", "(1.5,)"]))
        header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {claimed}, }}\n".encode()
        members[name] = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header
        return f"{name} claims the shape {claimed}", "damage", _zipped(members)
    if way == 3:
        told, _, members[name] = damaged_bytes(members[name], rng)
        return f"{name}: {told}, zipped again", "edit", _zipped(members)
    held = np.lib.format.read_array(io.BytesIO(members[name]), allow_pickle=False)
    told, array = changed_array(held, rng)
    out = io.BytesIO()
    np.lib.format.write_array(out, array, allow_pickle=True)
    members[name] = out.getvalue()
    return f"{name.removesuffix('.npy')} {told}", "edit", _zipped(members)


def _zipped(members: Mapping[str, bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return out.getvalue()


def mutated_parquet(content: bytes, rng: np.random.Generator) -> tuple[str, Effect, bytes]:
    """Rewrite a Parquet table: columns of other types, lost, doubled or in another order, rows likewise."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pq.read_table(io.BytesIO(content))
    column = int(rng.integers(table.num_columns))
    name, values = table.column_names[column], table.column(column)
    effect: Effect = "edit"
    way = rng.integers(7)
    if way == 0:
        told, effect = "columns in another order", "same"
        table = table.select([table.column_names[index] for index in rng.permutation(table.num_columns)])
    elif way == 1:
        told, table = f"{name} lost", table.drop_columns([name])
    elif way == 2:
        told, table = f"{name} doubled", table.append_column(name, values)
    elif way == 3:
        rows = rng.integers(0, table.num_rows, int(rng.integers(0, table.num_rows + 1)))
        told, table = "rows drawn anew", table.take(pa.array(rows, pa.int64()))
    elif way == 4:
        told = f"{name} without values"
        table = table.set_column(column, name, pa.nulls(table.num_rows, values.type))
    else:
        lists = pa.array([[1]] * table.num_rows)
        made: list[tuple[str, Any]] = [
            ("lists", lists),
            ("structs", pa.array([{"a": 1}] * table.num_rows)),
            ("bytes", pa.array([b"\xff"] * table.num_rows)),
            ("times", pa.array([0] * table.num_rows, pa.timestamp("ns"))),
            ("labels", pa.array(["x"] * table.num_rows).dictionary_encode()),
            ("truths", pa.array([True] * table.num_rows)),
            ("infinities", pa.array([np.inf] * table.num_rows)),
            ("whole numbers", pa.array([2**62] * table.num_rows)),
            ("text", values.cast(pa.string())),
            ("nulls", pa.nulls(table.num_rows)),
        ]
        kind, array = made[rng.integers(len(made))]
        told, table = f"{name} holds {kind}", table.set_column(column, name, array)
    out = io.BytesIO()
    pq.write_table(table, out)
    return told, effect, out.getvalue()


def mutated_safetensors(content: bytes, rng: np.random.Generator) -> tuple[str, Effect, bytes]:
    """Change the header of a safetensors file: a value of it, or what it claims for its length."""
    length = int.from_bytes(content[:8], "little")
    header, data = json.loads(content[8 : 8 + length]), content[8 + length :]
    if rng.random() < 0.3:
        claimed = int(rng.choice([0, 1, length - 1, length + 1, 10**6, 2**40, 2**63 - 1]))
        return f"the header claims {claimed} bytes", "damage", claimed.to_bytes(8, "little") + content[8:]
    if rng.random() < 0.5 and isinstance(inside := header.get("__metadata__"), dict) and inside:
        entry = sorted(inside)[rng.integers(len(inside))]
        told, value = changed_value(json.loads(inside[entry]), rng)
        inside[entry], told = json.dumps(value), f"metadata {told}"
    else:
        told, header = changed_value(header, rng)
    text = json.dumps(header).encode()
    return told, "damage", len(text).to_bytes(8, "little") + text + data
