import io
from contextlib import redirect_stderr, redirect_stdout

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer.cli.convert import READER_NAMES
from ppinfer.studies import READERS, RecordingHeader, RecordingWriter, Trial, read_log

from ..studies.logs import study_data
from .commands import checked_json, run_one

MAPPING = """
[columns]
trial = "game"
time = "t_ms"
x = "px"
y = "py"
true_goal = "heads_for"

[constants]
agent = "human"
participant = "p1"

[units]
time = "ms"
position = "cm"

[goals]
cup = [10.0, 42.5]
pan = [-12.0, 40.0]
"""


@pytest.fixture
def table(tmp_path):
    (tmp_path / "reaches.csv").write_text("game,t_ms,px,py,heads_for\n1,0,0,0,cup\n1,100,2,8,cup\n")
    (tmp_path / "reaches.toml").write_text(MAPPING)
    return tmp_path


def convert(folder, *more, output="log.nc"):
    return run_one(
        "convert",
        folder / "reaches.csv",
        "-o",
        folder / output,
        "--from",
        "tidy",
        "--mapping",
        folder / "reaches.toml",
        *more,
    )


def test_the_command_offers_every_reader():
    assert tuple(READERS) == READER_NAMES


@pytest.mark.parametrize("output", ["log.nc", "log.zarr"])
def test_a_table_becomes_a_log_with_a_short_summary(table, capsys, output):
    assert convert(table, output=output) == 0
    said = capsys.readouterr()
    assert "1 trial, 2 samples, 1 participant, 1 segment\n" in said.out
    assert said.err == ""
    assert read_log(table / output).true_goal.values.tolist() == ["cup"]


def test_json_is_as_its_schema_says(table, capsys):
    assert convert(table, "--json") == 0
    told = checked_json("convert", capsys.readouterr().out)
    assert (told["trials"], told["samples"], told["goals"]) == (1, 2, ["cup", "pan"])


def test_a_broken_table_is_one_line_a_fault_and_nothing_is_written(table, capsys):
    (table / "reaches.csv").write_text("game,t_ms,px,py,heads_for\n1,0,x,0,cup\n1,0,2,8,spoon\n")
    before = sorted(table.iterdir())
    assert convert(table) == 1
    said = capsys.readouterr()
    assert said.out == ""
    lines = said.err.splitlines()
    assert lines[0].endswith("reaches.csv: 2 faults; nothing was written")
    assert len(lines) == 3
    assert "line 2: column 'px'" in said.err
    assert sorted(table.iterdir()) == before


def test_a_failed_conversion_leaves_an_earlier_log_alone(table, capsys):
    assert convert(table) == 0
    before = (table / "log.nc").read_bytes()
    (table / "reaches.csv").write_text("game\n1\n")
    assert convert(table) == 1
    assert (table / "log.nc").read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["reaches.csv", "-o", "log.nc", "--from", "tidy"], "needs a mapping"),
        (["reaches.csv", "-o", "log.nc", "--from", "eth", "--mapping", "reaches.toml"], "takes no --mapping"),
        (["nothing", "-o", "log.nc", "--from", "eth"], "nothing: there is no such file or folder"),
        (["reaches.csv", "-o", "log.txt", "--from", "eth"], "written as .nc"),
        (["reaches.csv", "-o", "log.nc", "--from", "reaching-study"], "has no trials"),
        (["reaches.csv", "-o", "log.nc", "--from", "recording"], "reaches.csv: is not a recording"),
    ],
)
def test_what_cannot_be_converted_is_said_in_a_line(table, capsys, monkeypatch, arguments, told):
    monkeypatch.chdir(table)
    assert run_one("convert", *arguments) == 1
    said = capsys.readouterr().err
    assert told in said
    assert "Traceback" not in said
    assert not (table / "log.nc").exists()


def test_a_recording_that_was_cut_off_is_compacted_with_a_note(tmp_path, capsys):
    path = tmp_path / "study.jsonl"
    with RecordingWriter(path, RecordingHeader(agents=("human",))) as recording:
        recording.append(Trial("a", "p", time=np.arange(3) / 10, position=np.zeros((3, 1, 2))))
    with path.open("ab") as file:
        file.write(b'{"crc')
    assert run_one("convert", path, "-o", tmp_path / "log.nc", "--from", "recording", "--json") == 0
    told = checked_json("convert", capsys.readouterr().out)
    assert told["notes"] == ["study.jsonl: line 3: torn after 5 bytes: dropped"]
    assert told["trials"] == 1


@pytest.mark.parametrize(
    ("folder", "reader", "trials", "segments", "notes"),
    [("eth-pedestrians", "eth", 360, 360, 0), ("reaching-study", "reaching-study", 132, 1122, 4)],
)
def test_real_studies_convert(tmp_path, capsys, folder, reader, trials, segments, notes):
    source = study_data(folder)
    assert run_one("convert", source, "-o", tmp_path / "log.nc", "--from", reader, "--json") == 0
    told = checked_json("convert", capsys.readouterr().out)
    assert (told["trials"], told["segments"], len(told["notes"])) == (trials, segments, notes)
    assert run_one("validate", tmp_path / "log.nc") == 0


@settings(max_examples=80)
@given(data=st.data())
def test_whatever_is_damaged_in_a_table_is_told_and_nothing_half_written(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("damaged")
    (folder / "reaches.toml").write_text(MAPPING)
    content = bytearray(b"game,t_ms,px,py,heads_for\n1,0,0,0,cup\n1,100,2,8,cup\n2,0,1,1,pan\n")
    if data.draw(st.booleans()):
        del content[data.draw(st.integers(0, len(content) - 1)) :]
    else:
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    (folder / "reaches.csv").write_bytes(content)
    with redirect_stderr(io.StringIO()) as said, redirect_stdout(io.StringIO()):
        status = convert(folder)
    left = {item.name for item in folder.iterdir()} - {"reaches.csv", "reaches.toml"}
    if status:
        assert left == set()
        assert said.getvalue().startswith("ppinfer convert: ")
        assert "unexpected" not in said.getvalue()
    else:
        assert left == {"log.nc"}
        read_log(folder / "log.nc")


@settings(max_examples=60)
@given(data=st.data())
def test_whatever_is_damaged_in_a_parquet_table_is_told(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("damaged")
    columns = {
        "game": ["1", "1"],
        "t_ms": [0, 100],
        "px": [0.0, 2.0],
        "py": [0.0, 8.0],
        "heads_for": ["cup", "cup"],
    }
    pd.DataFrame(columns).to_parquet(folder / "whole.parquet")
    content = bytearray((folder / "whole.parquet").read_bytes())
    (folder / "whole.parquet").unlink()
    if data.draw(st.booleans()):
        del content[data.draw(st.integers(0, len(content) - 1)) :]
    else:
        content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    (folder / "reaches.parquet").write_bytes(content)
    (folder / "m.toml").write_text(MAPPING)
    arguments = ["-o", folder / "log.nc", "--from", "tidy", "--mapping", folder / "m.toml"]
    with redirect_stderr(io.StringIO()) as said, redirect_stdout(io.StringIO()):
        status = run_one("convert", folder / "reaches.parquet", *arguments)
    assert (folder / "log.nc").exists() == (status == 0)
    assert "unexpected" not in said.getvalue()
