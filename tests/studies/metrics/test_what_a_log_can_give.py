"""Which metrics a log can give, and what is said of those that it cannot."""

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.studies import (
    FaultyLogError,
    RecordingHeader,
    RecordingWriter,
    Trial,
    build_log,
    log_of_trials,
    write_log,
)
from ppinfer.studies.metrics import METRICS, trial_metrics
from ppinfer.testing import example_log, example_team_log


def test_a_full_log_gives_all():
    found = trial_metrics(example_team_log())
    assert found.names == tuple(METRICS)
    assert not found.not_available
    assert found.values.shape == (12, len(METRICS))


def test_a_log_of_one_agent_gives_what_one_agent_does():
    found = trial_metrics(example_log(participants=2, trials=2))
    assert {"duration_s", "human_path_length", "human_idle_share"} <= set(found.names)
    assert not any(name.startswith("robot") for name in found.names)
    assert found.not_available["concurrent_share"].startswith("there is no agent 'robot' in the log")


def test_the_only_agent_is_the_human_whatever_its_name():
    log = build_log(agents=["ann"], row_size=[2], time=[0.0, 1.0], position=np.array([[[0.0, 0]], [[3, 4]]]))
    assert trial_metrics(log, names=["human_path_length"]).values.tolist() == [[5.0]]


def test_agents_of_other_names_are_told_who_they_are():
    log = build_log(
        agents=["ann", "bob"], row_size=[2], time=[0.0, 1.0], position=np.array([[[0.0, 0], [0, 0]], [[3, 4], [0, 1]]]),
        variables={"bob_pick": (("sample",), [0, 1])},
    )  # fmt: skip
    assert "human_path_length" not in trial_metrics(log).names
    found = trial_metrics(log, robot="ann", human="bob")
    assert found.values_of("robot_path_length").tolist() == [5.0]
    assert found.values_of("human_picks_per_minute").tolist() == [120.0]


@pytest.mark.parametrize(
    ("who", "told"),
    [
        ({"robot": "cat"}, "there is no agent 'cat' in the log; there are human, robot"),
        ({"human": "robot"}, "'robot' is both the robot and the human"),
    ],
)
def test_roles_that_do_not_fit_are_refused(who, told):
    with pytest.raises(LogError, match=told):
        trial_metrics(example_team_log(), **who)


def test_metrics_asked_for_by_name_are_those_and_what_is_missing_is_named():
    log = example_team_log().drop_vars(["stops", "team_score"])
    assert trial_metrics(log, names=["collisions", "duration_s"]).names == ("collisions", "duration_s")
    with pytest.raises(LogError, match="score: the log has no team_score; stops: the log has no stops"):
        trial_metrics(log, names=["score", "duration_s", "stops"])
    with pytest.raises(LogError, match="there is no metric 'speed'; choose from duration_s, "):
        trial_metrics(log, names=["speed"])
    with pytest.raises(LogError, match="no metric is asked for"):
        trial_metrics(log, names=[])


def test_columns_to_group_by_are_what_a_log_says_of_trials_and_not_what_it_measured():
    log = example_team_log()
    log["lighting"] = ("trial", np.array(["dim", "bright"] * 6, dtype=object))
    log["table_cm"] = ("trial", np.arange(12))
    log["effort"] = ("trial", np.linspace(0, 1, 12))
    log["instruction"] = (("trial", "agent"), np.array([["be selfish", ""]] * 12, dtype=object))
    columns = trial_metrics(log, names=["score"]).columns
    assert {"condition", "round", "lighting", "table_cm", "human_controller", "human_instruction"} <= set(
        columns
    )
    assert not {"effort", "team_score", "stops", "row_size"} & set(columns)
    assert list(columns)[:4] == ["trial_id", "participant", "condition", "round"]


def test_files_give_what_their_log_gives_and_are_named(tmp_path):
    log = example_team_log(participants=2)
    here = trial_metrics(log)
    for name in ("log.nc", "log.zarr"):
        write_log(log, tmp_path / name)
        found = trial_metrics(tmp_path / name)
        np.testing.assert_array_equal(found.values, here.values)
        assert found.provenance["log"] == name
        assert len(found.provenance["input_sha256"]) == 64


def test_a_recording_that_is_being_made_is_measured(tmp_path):
    trials = [
        Trial(f"t{index}", "ann", time=np.arange(3.0), position=np.ones((3, 1, 2)).cumsum(axis=0) * index)
        for index in range(2)
    ]
    with RecordingWriter(tmp_path / "study.jsonl", RecordingHeader(agents=("human",))) as recording:
        for trial in trials:
            recording.append(trial)
    found = trial_metrics(tmp_path / "study.jsonl")
    np.testing.assert_array_equal(found.values, trial_metrics(log_of_trials(trials, agents=["human"])).values)
    assert any("one participant only" in told for told in found.warnings)


def test_an_unsound_log_is_refused_with_its_faults(tmp_path):
    log = example_team_log()
    log["time"].values[:] = 0.0
    write_log(log, tmp_path / "log.nc", validate=False)
    with pytest.raises(FaultyLogError, match="increas"):
        trial_metrics(tmp_path / "log.nc")


def test_simulated_trials_are_said_to_be():
    log = example_team_log()
    assert not trial_metrics(log).warnings or "simulated" not in " ".join(trial_metrics(log).warnings)
    log["seed"] = ("trial", np.arange(12))
    assert "the trials are simulated" in " ".join(trial_metrics(log).warnings)


def test_a_log_of_two_strangers_asks_who_they_are():
    log = build_log(
        agents=["ann", "bob"], row_size=[2], time=[0.0, 1.0], position=np.ones((2, 2, 2)).cumsum(axis=0)
    )
    told = " ".join(trial_metrics(log).warnings)
    assert "nobody is the robot or the human: the agents are ann, bob" in told
    assert "nobody is" not in " ".join(trial_metrics(log, human="ann").warnings)


def test_steps_that_cannot_be_are_told_where_they_count(tmp_path):
    position = np.arange(40.0).reshape(20, 1, 2)
    position[10] += 5000.0
    log = build_log(agents=["human"], row_size=[20], time=np.arange(20.0), position=position)
    write_log(log, tmp_path / "log.nc")
    assert "2 steps of 'human' are faster than" in trial_metrics(tmp_path / "log.nc").warnings[0]
    assert "faster" not in " ".join(trial_metrics(tmp_path / "log.nc", names=["duration_s"]).warnings)


def test_an_agent_without_a_role_is_told_where_a_role_is_free():
    log = example_team_log().assign_coords(agent=np.array(["human", "cobot"], dtype=object))
    assert "nobody is the robot: the log also has cobot; say with --robot" in trial_metrics(log).warnings
    assert not any("nobody" in told for told in trial_metrics(log, robot="cobot").warnings)
    assert not any("nobody" in told for told in trial_metrics(log, names=["duration_s"]).warnings)
