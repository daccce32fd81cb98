"""Tables, archives, recordings and settings that were made to do harm: each is refused by name, in one line."""

from __future__ import annotations

import io
import json
import os
import zipfile
import zlib
from contextlib import suppress

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from ppinfer.errors import GameFileError, LogError, ModelError
from ppinfer.games import read_nfg
from ppinfer.goals.configuration import read_model
from ppinfer.guarding import limited, trusting
from ppinfer.studies import (
    RecordingHeader,
    RecordingWriter,
    Trial,
    load_recording,
    read_study,
    recording_lines,
    validate_file,
)
from ppinfer.studies.faults import Faults
from ppinfer.studies.readers.mapping import FileOptions
from ppinfer.studies.readers.npz import read_npz
from ppinfer.studies.readers.tables import read_table
from ppinfer.studies.recording_lines import LINE_PREFIX, header_line, trial_line

COMMA = FileOptions.model_validate({})
HEADER = RecordingHeader(agents=("human",))
TRIAL = Trial("a", "p1", time=np.array([0.0, 0.1]), position=np.zeros((2, 1, 2)))


def npy(array):
    out = io.BytesIO()
    np.lib.format.write_array(out, array, allow_pickle=True)
    return out.getvalue()


def npy_claiming(shape, kind="<f8", content=bytes(16)):
    """Return an array whose header says what it likes."""
    told = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(told).to_bytes(2, "little") + told + content


def bomb(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xh.npy", npy(np.zeros(3_000_000)))


def twice(path):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("xh.npy", npy(np.zeros(3)))
        archive.writestr("xi.npy", npy(np.ones(3)))
    path.write_bytes(path.read_bytes().replace(b"xi.npy", b"xh.npy"))


def leading_out(path):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("../../xh.npy", npy(np.zeros(3)))


def absolute(path):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("/etc/xh.npy", npy(np.zeros(3)))


def encrypted(path):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("xh.npy", npy(np.zeros(3)))
    content = bytearray(path.read_bytes())
    content[content.index(b"PK\x01\x02") + 8] |= 1
    path.write_bytes(content)


def packed_otherwise(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("xh.npy", npy(np.zeros(3)))


def many(path):
    with zipfile.ZipFile(path, "w") as archive:
        for index in range(1100):
            archive.writestr(f"{index}.npy", b"")


def pickled(path):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("xh.npy", npy(np.array([{"a": 1}], dtype=object)))


def one_array(content):
    def write(path):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("xh.npy", content)

    return write


ARCHIVES = {
    "bomb": (bomb, "unpacks to 22.9 MiB, more than the 16 MiB"),
    "twice": (twice, "column 'xh.npy': is there 2 times"),
    "leading_out": (leading_out, "'../../xh.npy': is a name that leads out of the archive"),
    "absolute": (absolute, "'/etc/xh.npy': is a name that leads out"),
    "encrypted": (encrypted, "'xh.npy': is encrypted"),
    "packed_otherwise": (packed_otherwise, "'xh.npy': is packed in another way than NumPy packs"),
    "many": (many, "holds 1100 arrays, more than the 1024"),
    "pickled": (pickled, "column 'xh': holds pickled Python objects, which are never loaded"),
    "huge_shape": (
        one_array(npy_claiming("(1 << 50,)".replace("1 << 50", str(1 << 50)))),
        "does not fit its",
    ),
    "negative": (one_array(npy_claiming("(-1,)")), "does not fit its"),
    "long_header": (one_array(npy_claiming("(" + "1," * 5000 + ")")), "cannot be read"),
    "code": (one_array(npy_claiming("(__import__('os').getpid(),)")), "cannot be read"),
    "wide": (one_array(npy_claiming("(2,)", kind="<U500000000")), "does not fit its"),
}


@pytest.mark.parametrize("name", ARCHIVES)
def test_an_archive_that_numpy_did_not_write_is_refused_by_name(tmp_path, name):
    write, told = ARCHIVES[name]
    write(tmp_path / "game.npz")
    faults = Faults()
    with limited(memory=1 << 24):
        arrays = read_npz(tmp_path / "game.npz", "trials/game.npz", faults)
    assert not arrays
    (line,) = faults.lines()
    assert told in line
    assert line.startswith("trials/game.npz")


def faults_of_table(path, *columns):
    faults = Faults()
    assert read_table(path, [(column, "") for column in columns], COMMA, faults) is None
    return faults.lines()


TEXTS = {
    "nul": (b"a,b\n1,2\n3,\x00\n", "t.csv: line 3: holds a NUL byte"),
    "endless": (b"a,b\n" + b"1" * 5_000_000, "t.csv: line 2: is longer than 1 MiB"),
    "endless_in_cells": (b"a,b\n1,2\n" + b"1," * 3_000_000 + b"\n", "t.csv: line 3: is longer than 1 MiB"),
    "endless_header": (b"a," * 5_000_000, "t.csv: line 1: is longer than 1 MiB"),
    "many_columns": (b",".join(b"%d" % index for index in range(20_000)), "t.csv: line 1: has 20000 columns"),
    "open_quote": (b'a,b\n"1,2\n' + b"3,4\n" * 600_000, "cannot be read"),
}


@pytest.mark.parametrize("name", TEXTS)
def test_text_that_is_no_table_is_refused_by_name(tmp_path, name):
    content, told = TEXTS[name]
    (tmp_path / "t.csv").write_bytes(content)
    (line,) = faults_of_table(tmp_path / "t.csv", "a")
    assert told in line


@pytest.mark.parametrize("cell", ["9" * 5000, "1e99999", "1" + "0" * 400])
def test_a_number_that_no_computer_has_is_a_fault_of_its_cell(tmp_path, cell):
    (tmp_path / "t.csv").write_text(f"a\n1\n{cell}\n")
    faults = Faults()
    table = read_table(tmp_path / "t.csv", [("a", "")], COMMA, faults)
    table.numbers("a", faults)
    (line,) = faults.lines()
    assert line.startswith("t.csv: line 3: column 'a': expected a finite number")
    assert len(line) < 1000


def test_a_table_of_rows_without_end_in_a_few_bytes_is_refused(tmp_path):
    rows = pa.table({"a": pa.DictionaryArray.from_arrays(pa.array(np.zeros(4_000_000, np.int32)), ["x"])})
    pq.write_table(rows, tmp_path / "t.parquet")
    assert (tmp_path / "t.parquet").stat().st_size < 20_000
    with (
        limited(memory=1 << 24),
        pytest.raises(LogError, match=r"claims 30.5 MiB in 4000000 rows, more than"),
    ):
        faults_of_table(tmp_path / "t.parquet", "a")


def test_a_table_of_one_large_text_in_every_row_is_refused_in_bounded_memory(tmp_path):
    rows = pa.table(
        {"a": pa.DictionaryArray.from_arrays(pa.array(np.zeros(20_000, np.int32)), ["x" * 100_000])}
    )
    pq.write_table(rows, tmp_path / "t.parquet")
    with limited(memory=1 << 27), pytest.raises(LogError, match="takes more than 128 MiB of memory"):
        faults_of_table(tmp_path / "t.parquet", "a")


def test_an_encrypted_table_is_refused(tmp_path):
    (tmp_path / "t.parquet").write_bytes(b"PARE" + bytes(100) + (50).to_bytes(4, "little") + b"PARE")
    (line,) = faults_of_table(tmp_path / "t.parquet", "a")
    assert "cannot be read" in line
    assert "encrypted" in line.lower()


def a_line(body):
    """Return a line of a recording that has the right checksum."""
    return f'{LINE_PREFIX}{zlib.crc32(body.encode()):08x}", {body[1:]}\n'.encode()


def told_with(**changed):
    body = json.loads(b"{" + trial_line(TRIAL, HEADER).partition(b", ")[2])
    return a_line(json.dumps(body | changed))


RECORDINGS = {
    "nested": (a_line('{"a": ' + "[" * 100_000 + "]" * 100_000 + "}"), "line 2: is nested too deeply"),
    "huge_whole_number": (told_with(round=10**400), "line 2: "),
    "digits": (a_line('{"round": ' + "9" * 5000 + "}"), "line 2: Exceeds the limit"),
    "huge_times": (told_with(time=[0, 10**400]), "line 2: "),
    "twice": (a_line('{"trial_id": "a", "trial_id": "b"}'), "line 2: says 'trial_id' twice"),
    "nan": (a_line('{"time": [NaN]}'), "line 2: holds NaN; numbers are finite"),
    "wide_type": (
        told_with(variables={"x": {"dims": [], "type": "U999999999", "values": "", "attrs": {}}}),
        "line 2: variable 'x' is of type 'U999999999'",
    ),
    "object_type": (
        told_with(variables={"x": {"dims": [], "type": "object", "values": "", "attrs": {}}}),
        "line 2: variable 'x' is of type 'object'",
    ),
    "no_object": (a_line("{}").replace(b"{}", b"[]"), "line 2: "),
}


@pytest.mark.parametrize("name", RECORDINGS)
def test_a_line_that_no_recorder_writes_is_refused_by_name(tmp_path, name):
    line, told = RECORDINGS[name]
    path = tmp_path / "study.jsonl"
    path.write_bytes(header_line(HEADER) + line)
    with pytest.raises(LogError, match=told):
        load_recording(path)
    assert not validate_file(path).ok
    with suppress(LogError):
        RecordingWriter(path, HEADER, resume=True).close()


def test_a_line_without_an_end_is_refused_before_all_of_it_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr(recording_lines, "MOST_LINE", 1 << 12)
    path = tmp_path / "study.jsonl"
    path.write_bytes(header_line(HEADER) + b"1" * 5000)
    for read in (load_recording, lambda path: RecordingWriter(path, HEADER, resume=True)):
        with trusting(), pytest.raises(LogError, match=r"line 2: is longer than 4 KiB"):
            read(path)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"a = " + b"[" * 100_000, "nested too deeply"),
        (b"a = 1\n" * 300_000, "larger than 1 MiB"),
        (b"a = " + b"9" * 5000, "cannot be read: Exceeds the limit"),
    ],
)
def test_settings_that_are_no_settings_are_refused(tmp_path, content, told):
    (tmp_path / "m.toml").write_bytes(content)
    (tmp_path / "t.csv").write_text("a\n1\n")
    with pytest.raises(LogError, match=told):
        read_study(tmp_path / "t.csv", "tidy", mapping=tmp_path / "m.toml")
    with pytest.raises(ModelError, match=told):
        read_model(tmp_path / "m.toml")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_pipes_are_never_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for read in (load_recording, lambda path: RecordingWriter(path, HEADER, resume=True)):
        with pytest.raises(LogError, match="pipe: is a pipe; give a file"):
            read(tmp_path / "pipe")
    assert "is a pipe; give a file" in str(validate_file(tmp_path / "pipe").faults[0])
    with pytest.raises(ModelError, match="is a pipe"):
        read_model(tmp_path / "pipe")
    with pytest.raises(GameFileError, match="is a pipe"):
        read_nfg(tmp_path / "pipe")
    with pytest.raises(LogError, match="is a pipe"):
        faults_of_table(tmp_path / "pipe", "a")
