"""The page on the log format says what the code does."""

import os
import re
import tomllib
from pathlib import Path
from typing import get_args

import pytest

from ppinfer.cli import convert
from ppinfer.studies import READERS
from ppinfer.studies.readers.mapping import Mapping, VariableColumn
from ppinfer.studies.readers.variable_names import CellKind, Per
from ppinfer.studies.schema import schema_table
from ppinfer.studies.theta_posterior import theta_table

PAGE = (Path(__file__).parents[2] / "docs" / "log-format.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, flags=re.DOTALL)


def test_the_table_of_variables_is_that_of_the_code():
    assert schema_table() in PAGE
    assert theta_table() in PAGE


def test_every_reader_has_its_section():
    assert re.findall(r"^### (.+)$", PAGE, flags=re.MULTILINE) == list(READERS)


def test_the_example_of_a_mapping_is_one():
    (example,) = blocks("toml")
    mapping = Mapping.model_validate(tomllib.loads(example))
    assert mapping.columns.time == "t_ms"
    shown = convert._EPILOG[convert._EPILOG.index("[columns]") :]
    assert Mapping.model_validate(tomllib.loads(shown)) == mapping


def entries(model):
    return set(model.model_fields)


@pytest.mark.parametrize("table", ["file", "columns", "constants", "units", "goals_file", "segments_file"])
def test_every_entry_of_a_mapping_is_on_the_page(table):
    annotation = Mapping.model_fields[table].annotation
    model = next(
        kind for kind in (*getattr(annotation, "__args__", ()), annotation) if hasattr(kind, "model_fields")
    )
    rows = [line for line in PAGE.splitlines() if line.startswith(f"| `[{table}]`")]
    told = set(re.findall(r"`([a-z_]+)`", " ".join(rows)))
    assert entries(model) <= told


def test_every_entry_of_a_variable_and_what_it_may_be_is_on_the_page():
    rows = " ".join(line for line in PAGE.splitlines() if line.startswith("| `[variables"))
    assert entries(VariableColumn) <= set(re.findall(r"`([a-z]+)`", rows))
    assert {*get_args(Per), *get_args(CellKind)} <= set(re.findall(r"`\"([a-z-]+)\"`", rows))


def test_the_example_of_a_recording_runs_twice(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (example,) = [block for block in blocks("python") if "RecordingWriter" in block]
    for _ in range(2):
        exec(compile(example, "log-format.md", "exec"), {})
    assert os.path.getsize("study.jsonl") > 0
    assert Path("study.jsonl").read_text().count("\n") == 3
