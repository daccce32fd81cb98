import csv
import shutil

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.studies import FaultyLogError, read_reaching_study, read_study, validate_log

from ..logs import study_data

GAME = "user7_cbp_1"


def arrays(n=12):
    rng = np.random.default_rng(1)
    xh, xr = rng.normal(size=(2, n, 4))
    xh[:, [1, 3]] = 0
    return {
        "xh": xh,
        "xr": xr,
        "goals": rng.normal(size=(n, 3, 4)),
        "belief_nominal": np.full((n, 3), 1 / 3),
        "belief_robot": np.full((n, 3), 1 / 3),
        "belief_beta": np.full((n, 3, 2), 1 / 6),
        "r_goal_idx": np.zeros(n, int),
        "h_goal_reached": np.full(n, -1),
        "r_goal_reached": np.full(n, -1),
        "is_robot_waiting": np.zeros(n, bool),
        "is_human_waiting": np.zeros(n, bool),
        "collision": np.arange(n) == 3,
        "team_score": np.array(4),
        "n_collisions": np.array(1),
        "r_objective": np.array(["influence", "courtesy"] * (n // 2)),
    }


def study(folder, games, segments="7,cbp,1,0,0,6,5,2\n", trials="7,cbp,1,12\n"):
    (folder / "trials").mkdir()
    for name, content in games.items():
        np.savez(folder / "trials" / f"{name}.npz", **content)
    (folder / "segments.csv").write_text(
        "user_id,robot_type,game_idx,seg,start,end,arrive,h_goal\n" + segments
    )
    (folder / "trials.csv").write_text("user_id,robot_type,game_idx,T\n" + trials)
    return folder


def test_the_reader_tells_how_many_games_are_read(tmp_path):
    told = []
    folder = study(tmp_path, {GAME: arrays(), "user7_cbp_2": arrays()})
    read_study(folder, "reaching-study", progress=lambda done, total: told.append((done, total)))
    assert told == [(1, 2), (2, 2)]


def faults_of(folder):
    with pytest.raises(FaultyLogError) as caught:
        read_reaching_study(folder)
    return caught.value.faults


def test_a_game_is_a_trial_with_both_agents_and_the_studys_own_beliefs(tmp_path):
    game = arrays()
    log = read_reaching_study(study(tmp_path, {GAME: game}))
    assert validate_log(log).ok
    np.testing.assert_array_equal(log.position.sel(agent="robot").values, game["xr"][:, [0, 2]])
    np.testing.assert_array_equal(log.velocity.sel(agent="robot").values, game["xr"][:, [1, 3]])
    np.testing.assert_array_equal(log.goal_position.values, game["goals"][:, :, [0, 2]])
    np.testing.assert_array_equal(log.time.values, np.arange(12) / 10)
    assert log.has_velocity.values.tolist() == [0, 1]
    assert np.isnan(log.velocity.sel(agent="human")).all()
    assert (log.participant.item(), log.condition.item(), log["round"].item()) == ("7", "cbp", 1)
    assert log.logged_belief_rationality.dims == ("sample", "goal", "rationality")
    assert log.robot_objective.attrs["flag_meanings"] == "courtesy influence"
    assert log.robot_objective.values[:2].tolist() == [1, 0]
    assert log.team_score.values.tolist() == [4]
    assert log.collision.values.sum() == 1


def test_a_row_of_segments_is_a_human_segment_and_one_without_approach_is_left_out_and_told(tmp_path):
    log = read_reaching_study(study(tmp_path, {GAME: arrays()}, "7,cbp,1,0,0,6,5,2\n7,cbp,1,1,7,9,7,1\n"))
    assert log.segment_agent.values.tolist() == ["human"]
    assert (log.segment_start.item(), log.segment_stop.item(), log.true_goal.item()) == (0, 5, "2")
    assert "segments.csv: line 3" in log.attrs["notes"]


def test_everything_wrong_with_a_folder_is_told_at_once(tmp_path):
    short = arrays() | {"xr": np.zeros((11, 4)), "goals": np.zeros((12, 3))}
    folder = study(
        tmp_path,
        {GAME: arrays(), "user7_cbp_2": short, "notes": {"x": np.zeros(1)}},
        segments="7,cbp,1,0,0,6,5,9\n7,cbp,1,0,x,6,5,1\n8,cbp,1,0,0,6,5,1\n7,cbp,1,0,0,99,99,1\n",
        trials="7,cbp,1,13\n7,cbp,2,12\n9,cbp,1,12\n",
    )
    found = {(fault.kind, fault.file, fault.line) for fault in faults_of(folder)}
    assert {
        ("wrong-shape", "trials/user7_cbp_2.npz", None),
        ("file-name", "trials/notes.npz", None),
        ("unknown-goal", "segments.csv", 2),
        ("not-a-number", "segments.csv", 3),
        ("missing-file", "segments.csv", 4),
        ("segment-range", "segments.csv", 5),
        ("wrong-length", "trials.csv", 2),
        ("missing-file", "trials.csv", 4),
    } == found


def test_a_pickled_array_is_refused_by_file_and_never_loaded(tmp_path):
    class Trap:
        def __reduce__(self):
            return (pytest.fail, ("it was unpickled",))

    folder = study(tmp_path, {GAME: arrays() | {"xh": np.array([Trap()], dtype=object)}})
    (fault,) = faults_of(folder)
    assert (fault.kind, fault.file, fault.column) == ("pickled", f"trials/{GAME}.npz", "xh")


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 0.999])
def test_a_truncated_game_is_told_by_file(tmp_path, share):
    folder = study(tmp_path, {GAME: arrays()})
    path = folder / "trials" / f"{GAME}.npz"
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    assert [(fault.kind, fault.file) for fault in faults_of(folder)] == [("unreadable", f"trials/{GAME}.npz")]


def test_a_flipped_bit_in_a_game_is_told_by_file(tmp_path):
    folder = study(tmp_path, {GAME: arrays()})
    path = folder / "trials" / f"{GAME}.npz"
    content = bytearray(path.read_bytes())
    content[400] ^= 4
    path.write_bytes(content)
    assert faults_of(folder)[0].kind == "unreadable"


def test_a_study_without_tables_is_read_with_notes(tmp_path):
    folder = study(tmp_path, {GAME: arrays()})
    (folder / "segments.csv").unlink()
    (folder / "trials.csv").unlink()
    log = read_reaching_study(folder)
    assert log.sizes["segment"] == 0
    assert "no segments to be scored on" in log.attrs["notes"]


def test_a_folder_of_something_else_is_refused(tmp_path):
    with pytest.raises(LogError, match="has no trials"):
        read_reaching_study(tmp_path)


def test_the_reaching_study_reads_whole():
    folder = study_data("reaching-study")
    log = read_reaching_study(folder)
    assert {name: log.sizes[name] for name in ("trial", "segment", "agent", "goal")} == {
        "trial": 132,
        "segment": 1122,
        "agent": 2,
        "goal": 3,
    }
    assert len(set(log.participant.values)) == 11
    assert set(log.condition.values) == {"baseline", "baseline_belief", "cbp"}
    assert log.has_velocity.values.tolist() == [0, 1]
    notes = log.attrs["notes"].split("\n")
    assert [line.split(":")[1] for line in notes if "left out" in line] == [
        " line 316",
        " line 478",
        " line 593",
    ]
    report = validate_log(log)
    assert report.ok
    (warning,) = report.warnings
    assert warning.message.split("steps of ")[1].startswith("'human'")
    assert 100 < warning.count < 1000
    with (folder / "trials.csv").open() as file:
        lengths = {
            f"user{row['user_id']}_{row['robot_type']}_{row['game_idx']}": row["T"]
            for row in csv.DictReader(file)
        }
    assert [int(lengths[name]) for name in log.trial_id.values] == log.row_size.values.tolist()


def test_goals_are_constant_within_every_real_segment():
    log = read_reaching_study(study_data("reaching-study"))
    begin = np.cumsum(log.row_size.values) - log.row_size.values
    first = begin[log.segment_trial.values] + log.segment_start.values
    last = begin[log.segment_trial.values] + log.segment_stop.values - 1
    moved = np.concatenate(
        [[0], np.cumsum((np.diff(log.goal_position.values, axis=0) != 0).any(axis=(1, 2)))]
    )
    assert (moved[first] == moved[last]).all()


def test_part_of_the_study_reads_when_its_tables_go_with_it(tmp_path):
    source = study_data("reaching-study")
    (tmp_path / "trials").mkdir()
    for path in sorted((source / "trials").glob("user3083_*")):
        shutil.copy(path, tmp_path / "trials")
    for name in ("segments.csv", "trials.csv"):
        lines = (source / name).read_text().splitlines()
        kept = [line for line in lines[1:] if line.startswith("3083,")]
        (tmp_path / name).write_text("\n".join([lines[0], *kept]) + "\n")
    assert read_reaching_study(tmp_path).sizes["trial"] == 12
