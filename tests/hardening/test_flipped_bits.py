"""Bits that flip on a disk are noticed wherever a file is read: nothing is ever computed from what nobody wrote."""

from __future__ import annotations

import io
import json
import os
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from tempfile import TemporaryDirectory

import pytest

from ppinfer.errors import LogError
from ppinfer.testing import Mutation, check_reader

from .valid_files import case

WANTED = int(os.environ.get("PPINFER_FUZZ", "0"))
SEED = int(os.environ.get("PPINFER_FUZZ_SEED", "0"))
# what stands for a file's own name and bytes, which differ, and for when it was
_OWN = ("source", "output", "log", "input", "path", "sha256", "report", "posterior", "page")


def flipped(files, rng):
    """Flip a few bits anywhere in the files, each as likely as its size."""
    names = sorted(files)
    sizes = [len(files[name]) for name in names]
    changed = {name: bytearray(content) for name, content in files.items()}
    told = []
    for _ in range(int(rng.integers(1, 5))):
        name = names[rng.choice(len(names), p=[size / sum(sizes) for size in sizes])]
        bit = int(rng.integers(8 * len(files[name])))
        changed[name][bit // 8] ^= 1 << bit % 8
        told.append(f"{name}: bit {bit}")
    return Mutation(
        f"flipped {', '.join(told)}", "damage", {name: bytes(content) for name, content in changed.items()}
    )


def without_own(value):
    """Leave out of a command's JSON what names the file itself."""
    if isinstance(value, dict):
        return {key: without_own(item) for key, item in value.items() if not any(own in key for own in _OWN)}
    return [without_own(item) for item in value] if isinstance(value, list) else value


def commanded(name, *more):
    """Return what reads a file by way of a command: its JSON, and what it wrote."""

    def read(path):
        from ppinfer.cli import main
        from ppinfer.studies.posterior import open_posterior

        out, err = io.StringIO(), io.StringIO()
        with TemporaryDirectory() as folder, redirect_stdout(out), redirect_stderr(err):
            written = f"{folder}/made"
            argv = [part.replace("{out}", written) for part in more]
            status = main([name, str(path), *argv, "--json"])
            if status:
                raise LogError(
                    err.getvalue().strip() or f"{path}: {json.loads(out.getvalue())['fault_counts']}"
                )
            told = without_own(json.loads(out.getvalue()))
            if name == "infer":
                with open_posterior(f"{written}.nc", load=True) as posterior:
                    told["posterior"] = {
                        key: str(posterior[key].values.tolist()) for key in posterior.variables
                    }
        return told

    return read


ENTRIES = {
    # the case whose files are damaged, and what reads them
    "read_log": ("read_log log.nc", None),
    "read_log of zarr": ("read_log log.zarr", None),
    "read_log of plays": ("read_log plays.nc", None),
    "open_log": ("open_log", None),
    "validate": ("read_log log.nc", commanded("validate")),
    "validate zarr": ("read_log log.zarr", commanded("validate")),
    "validate a posterior": ("open_posterior", commanded("validate")),
    "infer": ("read_log log.nc", commanded("infer", "-o", "{out}.nc", "--model", "nearest")),
    "infer from zarr": ("read_log log.zarr", commanded("infer", "-o", "{out}.nc", "--model", "nearest")),
    "metrics": ("read_log game.nc", commanded("metrics")),
    "open_posterior": ("open_posterior", None),
    "score": ("open_posterior", commanded("score", "--by-participant")),
    "read_theta_posterior": ("read_theta_posterior", None),
    "load_recording": ("load_recording", None),
    "ExampleStore": ("ExampleStore", None),
}


@cache
def inputs(entry):
    return 8 if not WANTED else -(-WANTED // (4 * len(ENTRIES)))


@pytest.mark.parametrize("entry", ENTRIES)
def test_flipped_bits_are_refused_or_change_nothing(entry):
    name, read = ENTRIES[entry]
    given = case(name)
    options = {**given.options, "signed": True}
    tally = check_reader(
        read or given.read,
        given.files,
        target=given.target,
        inputs=inputs(entry),
        seed=SEED,
        mutations=flipped,
        **options,
    )
    print(f"{entry}: {tally}")  # shown by pytest -rP
    assert tally.inputs == inputs(entry)
