"""Zarr stores that were made to do harm: each is refused by name, and nothing outside of it is ever read."""

from __future__ import annotations

import json
import os
import shutil

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.studies import open_log, validate_file, write_log
from ppinfer.studies.prediction_examples import ExampleStore, ExampleWriter, StoredExamples
from ppinfer.testing import example_log
from ppinfer.testing.prediction_examples import example_header, example_predictions


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    path = tmp_path_factory.mktemp("logs") / "log.zarr"
    write_log(example_log(participants=1, trials=1), path)
    return path


@pytest.fixture
def copied(written, tmp_path):
    return shutil.copytree(written, tmp_path / "log.zarr")


def edited(inside, change):
    """Return what changes the metadata of an array."""

    def edit(store):
        place = store / inside / "zarr.json"
        told = json.loads(place.read_text())
        change(told)
        place.write_text(json.dumps(told))

    return edit


def entry(*names, to):
    def change(told):
        for name in names[:-1]:
            told = told[name]
        told[names[-1]] = to

    return change


def link_to_file(store):
    chunk = next(
        place for place in (store / "time").rglob("*") if place.is_file() and place.name != "zarr.json"
    )
    chunk.unlink()
    chunk.symlink_to("/etc/passwd")


def link_to_folder(store):
    shutil.rmtree(store / "time")
    (store / "time").symlink_to("/etc", target_is_directory=True)


def pipe(store):
    os.mkfifo(store / "time" / "c" / "7")


def pipe_for_metadata(store):
    (store / "time" / "zarr.json").unlink()
    os.mkfifo(store / "time" / "zarr.json")


def deep(store):
    place = store
    for _ in range(20):
        place = place / "more"
    place.mkdir(parents=True)


def nested_json(store):
    (store / "time" / "zarr.json").write_text("[" * 100_000)


def twice(store):
    place = store / "time" / "zarr.json"
    place.write_text('{"shape": [1], ' + place.read_text().lstrip()[1:])


def blob(store):
    edited("", entry("attributes", "note", to="x" * (1 << 24)))(store)


HOSTILE = {
    "link_to_file": (link_to_file, "is a link; a store holds all of its content itself"),
    "link_to_folder": (link_to_folder, "'time' is a link"),
    "backslashes": (lambda store: (store / "..\\x").write_text(""), "is a name that leads out of the store"),
    "pipe": (pipe, "'time/c/7' is a pipe, a socket or a device"),
    "pipe_for_metadata": (pipe_for_metadata, "'time/zarr.json' is a pipe"),
    "deep": (deep, "folders lie more than 16 deep"),
    "nested_json": (nested_json, "'time/zarr.json' is nested too deeply"),
    "twice": (twice, "'time/zarr.json' is damaged: 'shape' is there twice"),
    "blob": (blob, "'zarr.json' is 16 MiB large"),
    "pickle": (edited("time", entry("codecs", to=[{"name": "pickle"}])), "packed with the codec 'pickle'"),
    "numcodecs": (
        edited("time", lambda told: told["codecs"].append({"name": "numcodecs.pickle"})),
        "packed with the codec 'numcodecs.pickle'",
    ),
    "inner_codec": (
        edited(
            "time",
            entry(
                "codecs",
                to=[
                    {
                        "name": "sharding_indexed",
                        "configuration": {"codecs": ["msgpack2"], "index_codecs": []},
                    }
                ],
            ),
        ),
        "packed with the codec 'msgpack2'",
    ),
    "no_codecs": (edited("time", entry("codecs", to=7)), "has no list of codecs"),
    "huge_shape": (edited("time", entry("shape", to=[1 << 50])), "claims 8 PiB"),
    "huge_chunk": (
        edited("time", entry("chunk_grid", "configuration", "chunk_shape", to=[1 << 50])),
        "claims 8 PiB",
    ),
    "many_chunks": (
        edited("time", lambda told: (told.update(shape=[100_000_000]), one_by_one(told))),
        "is cut into 100000[0-9]+ chunks",
    ),
    "negative_shape": (edited("time", entry("shape", to=[-1])), r"has shape \[-1\]; whole numbers"),
    "shape_of_texts": (edited("time", entry("shape", to=["1"])), r"has shape \['1'\]"),
    "true_shape": (edited("time", entry("shape", to=[True])), r"has shape \[True\]"),
    "zero_chunk": (
        edited("time", entry("chunk_grid", "configuration", "chunk_shape", to=[0])),
        r"chunk_shape \[0\]",
    ),
    "other_grid": (edited("time", entry("chunk_grid", to={"name": "odd"})), "chunk grid that is not read"),
    "other_keys": (
        edited("time", entry("chunk_key_encoding", to={"name": "../../etc"})),
        "chunk key encoding that is not read",
    ),
    "separator": (
        edited(
            "time",
            entry("chunk_key_encoding", to={"name": "default", "configuration": {"separator": "/../"}}),
        ),
        "separates chunk keys by '/../'",
    ),
    "objects": (
        edited("time", entry("data_type", to="object")),
        "is of type 'object'; a store holds numbers",
    ),
    "raw_bits": (edited("time", entry("data_type", to="r800000000")), "is of type 'r800000000'"),
    "long_text": (
        edited(
            "time",
            entry("data_type", to={"name": "fixed_length_utf32", "configuration": {"length_bytes": 1 << 40}}),
        ),
        "is of type 'fixed_length_utf32'",
    ),
    "group": (edited("time", entry("node_type", to="group")), "'time' is a group within the group"),
    "array": (edited("", entry("node_type", to="array")), "is no Zarr group"),
    "consolidated": (
        edited("", entry("consolidated_metadata", to={"kind": "inline", "metadata": {"../../x": {}}})),
        "describes its arrays twice",
    ),
    "transformer": (
        edited("time", entry("storage_transformers", to=[{"name": "x"}])),
        "has storage transformers",
    ),
}


def one_by_one(told):
    told["chunk_grid"]["configuration"]["chunk_shape"] = [1]


@pytest.mark.parametrize("name", HOSTILE)
def test_what_no_store_holds_is_refused_by_name(copied, name):
    change, told = HOSTILE[name]
    change(copied)
    with pytest.raises(LogError, match=told) as raised:
        open_log(copied)
    assert str(raised.value).count(str(copied)) == 1
    assert validate_file(copied).fault_counts == {"unreadable": 1}


def test_a_store_that_came_from_elsewhere_is_read_as_it_is(copied, written):
    with open_log(copied, load=True, verify=True) as log:
        assert log.identical(open_log(written, load=True))
    assert validate_file(copied).ok


@pytest.mark.parametrize("name", ["link_to_file", "pickle", "consolidated", "huge_shape"])
def test_stores_of_examples_are_held_to_the_same(tmp_path, name):
    examples = example_predictions(5)
    writer = ExampleWriter(tmp_path / "one.zarr", example_header(examples))
    writer.append(StoredExamples(examples, np.zeros(5, int), np.ones(5, np.float32)))
    assert len(ExampleStore(tmp_path / "one.zarr")) == 5
    store = shutil.copytree(tmp_path / "one.zarr", tmp_path / "other.zarr")
    os.rename(store / "interaction", store / "time")
    change, told = HOSTILE[name]
    change(store)
    with pytest.raises(LogError, match=told.replace("8 PiB", "4 PiB")):
        ExampleStore(store)
