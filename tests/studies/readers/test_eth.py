import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.studies import FaultyLogError, read_eth, validate_log

from ..logs import study_data


def scene(folder, rows, destinations="0 0\n10 0\n"):
    (folder / "obsmat.txt").write_text("".join(" ".join(map(str, row)) + "\n" for row in rows))
    (folder / "destinations.txt").write_text(destinations)
    return folder


def row(frame, person, x, y):
    return [frame, person, x, 0, y, 99, 99, 99]


def test_a_person_is_a_trial_that_heads_for_the_destination_nearest_to_the_last_position(tmp_path):
    rows = [row(10, 7, 1, 0), row(10, 8, 9, 0), row(20, 7, 6, 1), row(20, 8, 4, 0), row(30, 8, 3, 0)]
    log = read_eth(scene(tmp_path, rows))
    assert log.trial_id.values.tolist() == ["7", "8"]
    assert log.row_size.values.tolist() == [2, 3]
    assert log.true_goal.values.tolist() == ["1", "0"]
    assert log.position.values[:, 0].tolist() == [[1, 0], [6, 1], [9, 0], [4, 0], [3, 0]]
    assert "velocity" not in log
    assert validate_log(log).ok


@pytest.mark.parametrize("step", [6, 10])
def test_time_follows_the_scenes_usual_step_and_keeps_gaps(tmp_path, step):
    rows = [row(100 + step * index, 1, index, 0) for index in (0, 1, 2, 5)]
    log = read_eth(scene(tmp_path, rows) / "obsmat.txt")
    np.testing.assert_allclose(np.diff(log.time.values), [0.4, 0.4, 1.2])


def test_every_wrong_line_is_told_with_its_number(tmp_path):
    folder = scene(
        tmp_path, [row(0, 1, 0, 0), row(6, 1, "x", 0), [1, 2, 3], row(12, 1, 0, "nan")], "0 0\n1\n"
    )
    with pytest.raises(FaultyLogError) as caught:
        read_eth(folder)
    assert [(fault.file, fault.line, fault.column) for fault in caught.value.faults] == [
        ("obsmat.txt", 2, "3"),
        ("obsmat.txt", 3, None),
        ("obsmat.txt", 4, "5"),
        ("destinations.txt", 2, None),
    ]


def test_a_person_twice_in_one_frame_is_told_with_both_lines(tmp_path):
    with pytest.raises(FaultyLogError, match=r"line 3: person 1 is in frame 6 twice \(also line 2\)"):
        read_eth(scene(tmp_path, [row(0, 1, 0, 0), row(6, 1, 1, 0), row(6, 1, 2, 0)]))


@pytest.mark.parametrize("missing", ["obsmat.txt", "destinations.txt"])
def test_a_missing_file_is_named(tmp_path, missing):
    (scene(tmp_path, [row(0, 1, 0, 0)]) / missing).unlink()
    with pytest.raises(LogError, match=missing):
        read_eth(tmp_path)


def test_the_eth_scene_reads_whole():
    log = read_eth(study_data("eth-pedestrians"))
    assert dict(log.sizes) == {
        "agent": 1,
        "space": 2,
        "trial": 360,
        "sample": 8908,
        "segment": 360,
        "goal": 4,
    }
    assert validate_log(log).lines() == []
    assert int((log.row_size >= 10).sum()) == 337
    steps = np.diff(log.time.values)
    np.testing.assert_allclose(steps[steps > 0][:50], 0.4)
