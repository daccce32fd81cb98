import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer.errors import LogError
from ppinfer.studies import (
    FaultyLogError,
    RecordingHeader,
    RecordingWriter,
    Trial,
    load_recording,
    log_of_trials,
    read_recording,
    validate_file,
)
from ppinfer.testing.log_strategies import studies

from .logs import plain

HEADER = RecordingHeader(agents=("human",), configuration={"speed": 1.5, "seeds": [1, 2]})


def trial(name, **changed):
    parts = {"time": np.array([0.0, 0.1]), "position": np.array([[[0.1, 0.2]], [[np.nan, np.nan]]])}
    return Trial(name, "p1", **(parts | changed))


@pytest.fixture
def recorded(tmp_path):
    path = tmp_path / "study.jsonl"
    with RecordingWriter(path, HEADER) as recording:
        for name in "abc":
            recording.append(trial(name))
    return path


@settings(max_examples=40)
@given(study=studies())
def test_a_recorded_study_is_the_study_to_the_last_bit(tmp_path_factory, study):
    trials, options = study
    path = tmp_path_factory.mktemp("recording") / "study.jsonl"
    with RecordingWriter(path, RecordingHeader(**options)) as recording:
        for one in trials:
            recording.append(one)
    assert plain(read_recording(path)).identical(plain(log_of_trials(trials, **options)))


def test_a_crash_at_any_byte_costs_at_most_the_trial_in_hand(recorded, tmp_path):
    content = recorded.read_bytes()
    ends = [index + 1 for index, byte in enumerate(content) if byte == ord("\n")]
    # every byte near a line's end, and some between
    lengths = {end + step for end in [0, *ends] for step in (-1, 0, 1)} | set(range(0, len(content), 43))
    for length in sorted(lengths & set(range(len(content) + 1))):
        path = tmp_path / "cut.jsonl"
        path.write_bytes(content[:length])
        whole = sum(end <= length for end in ends) - 1
        with RecordingWriter(path, HEADER, resume=True) as recording:
            assert recording.completed == ("a", "b", "c")[: max(0, whole)]
            assert bool(recording.dropped) == (length not in (0, *ends))
            for name in "abc"[len(recording.completed) :]:
                recording.append(trial(name))
        assert path.read_bytes() == content


def test_a_torn_last_line_is_dropped_and_told(recorded):
    with recorded.open("ab") as file:
        file.write(b'{"crc32": "00')
    assert load_recording(recorded).dropped == "line 5: torn after 13 bytes: dropped"
    assert read_recording(recorded).attrs["notes"] == "study.jsonl: line 5: torn after 13 bytes: dropped"
    report = validate_file(recorded)
    assert report.ok
    assert report.warning_counts == {"torn-line": 1}


@settings(max_examples=60)
@given(data=st.data())
def test_damage_before_the_last_line_is_told_by_its_line(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("recording") / "study.jsonl"
    with RecordingWriter(path, HEADER) as recording:
        for name in "abc":
            recording.append(trial(name))
    content = bytearray(path.read_bytes())
    position = data.draw(st.integers(0, len(content) - 2))
    if content[position] == ord("\n"):
        return
    content[position] ^= 1 << data.draw(st.integers(0, 6))
    path.write_bytes(content)
    line = content[:position].count(b"\n") + 1
    with pytest.raises(FaultyLogError) as caught:
        load_recording(path)
    assert caught.value.faults[0].line == line
    assert not validate_file(path).ok


def test_all_damaged_lines_are_told_at_once(recorded):
    lines = recorded.read_bytes().split(b"\n")
    lines[1] = lines[1].replace(b"0.1", b"0.7")
    lines[3] = b"not at all"
    recorded.write_bytes(b"\n".join(lines))
    with pytest.raises(FaultyLogError) as caught:
        read_recording(recorded)
    assert [fault.line for fault in caught.value.faults] == [2, 4]


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"time": np.array([0.1, 0.1])}, "0.1 after 0.1"),
        ({"position": np.full((2, 1, 2), np.inf)}, "not finite|inf"),
        ({"position": np.zeros((2, 2, 2))}, "position: expected shape"),
        ({"variables": {"heat": (("sample",), np.zeros(2, complex))}}, "numbers or text"),
    ],
)
def test_an_unsound_trial_is_refused_and_nothing_written(recorded, changed, told):
    before = recorded.read_bytes()
    with RecordingWriter(recorded, HEADER, resume=True) as recording, pytest.raises(LogError, match=told):
        recording.append(trial("d", **changed))
    assert recorded.read_bytes() == before


def test_a_trial_is_recorded_once(recorded):
    with RecordingWriter(recorded, HEADER, resume=True) as recording, pytest.raises(LogError, match="before"):
        recording.append(trial("a"))


def test_a_recording_is_neither_overwritten_nor_mixed_with_another_study(recorded):
    with pytest.raises(LogError, match="exists"):
        RecordingWriter(recorded, HEADER)
    with pytest.raises(LogError, match="another study"):
        RecordingWriter(recorded, RecordingHeader(agents=("robot",)), resume=True)


def test_every_line_is_json_without_nan(recorded):
    for line in recorded.read_text().splitlines():
        told = json.loads(line, parse_constant=lambda text: pytest.fail(text))
        assert "crc32" in told


@pytest.mark.parametrize("content", [b"", b"trial,time\n", b"\x00\xff\n", b'{"crc32": "00000000", }\n'])
def test_another_file_is_no_recording(tmp_path, content):
    (tmp_path / "study.jsonl").write_bytes(content)
    with pytest.raises(LogError):
        read_recording(tmp_path / "study.jsonl")


def test_a_recording_without_a_trial_is_no_log(tmp_path):
    with RecordingWriter(tmp_path / "study.jsonl", HEADER):
        pass
    with pytest.raises(LogError, match="no whole trial"):
        read_recording(tmp_path / "study.jsonl")
    assert not validate_file(tmp_path / "study.jsonl").ok


def test_a_file_of_another_kind_is_called_no_recording(tmp_path):
    (tmp_path / "table.csv").write_text("trial,x,y\n1,2,3\n")
    with pytest.raises(LogError, match=r"table\.csv: is not a recording"):
        read_recording(tmp_path / "table.csv")
