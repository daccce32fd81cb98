from unittest import mock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppinfer.errors import LogError
from ppinfer.studies import (
    Fault,
    Faults,
    FaultyLogError,
    Report,
    build_log,
    read_log,
    validate_log,
    write_log,
)
from ppinfer.studies.schema import VARIABLES

from .logs import small_log


def kinds(log):
    return sorted(validate_log(log).fault_counts)


def only_fault(log):
    report = validate_log(log)
    assert len(report.faults) == 1, report.lines()
    return report.faults[0]


def edited(name, index, value):
    log = small_log().copy(deep=True)
    log[name].values[index] = value
    return log


def test_a_sound_log_has_no_faults_and_no_warnings():
    report = validate_log(small_log())
    assert report.ok
    assert not report.lines()
    assert report.sizes["sample"] == 7


@pytest.mark.parametrize(
    ("log", "kind", "trial", "sample", "column"),
    [
        (edited("time", 2, 0.1), "time-not-increasing", "a", 2, "time"),
        (edited("time", 5, np.nan), "not-finite", "b", 1, "time"),
        (edited("position", (3, 1, 0), np.nan), "not-finite", "a", 3, "position"),
        (edited("position", (3, 1, 0), np.inf), "not-finite", "a", 3, "position"),
        (edited("observed", (4, 0), 0), "dropout-with-position", "b", 0, "position"),
        (edited("observed", (4, 0), 7), "wrong-value", "b", 0, "observed"),
        (edited("segment_agent", 0, "ghost"), "unknown-agent", "a", 1, "segment_agent"),
        (edited("true_goal", 0, "spoon"), "unknown-goal", "a", 1, "true_goal"),
        (edited("segment_trial", 1, 9), "segment-trial", None, None, "segment_trial"),
        (edited("segment_stop", 1, 4), "segment-range", "b", 0, "segment_start"),
        (edited("segment_start", 1, 3), "segment-range", "b", 3, "segment_start"),
        (edited("goal_position", (1, 0, 0), np.nan), "not-finite", "b", None, "goal_position"),
        (edited("goal_present", (1, 0), 3), "wrong-value", "b", None, "goal_present"),
    ],
)
def test_each_fault_says_its_trial_sample_and_column(log, kind, trial, sample, column):
    found = [fault for fault in validate_log(log).faults if fault.kind == kind]
    assert [(fault.trial, fault.sample, fault.column) for fault in found] == [(trial, sample, column)]


def test_trials_of_one_name_are_told():
    fault = only_fault(edited("trial_id", 1, "a"))
    assert (fault.kind, fault.trial) == ("duplicate-trial", "a")


def test_lengths_that_do_not_add_up_are_told_without_hiding_other_faults():
    log = edited("row_size", 1, 2)
    log.position.values[0, 0] = np.inf
    found = validate_log(log).fault_counts
    assert found["wrong-length"] == 1
    assert found["not-finite"] == 1
    assert kinds(edited("row_size", 1, -3)) == ["segment-range", "wrong-length"]


def test_goals_that_are_missing_are_told():
    log = small_log().copy(deep=True)
    log.goal_present.values[0] = 0
    log.goal_position.values[0] = np.nan
    found = validate_log(log)
    assert found.fault_counts == {"goals-missing": 2}
    assert {fault.column for fault in found.faults} == {"goal_present", "true_goal"}


def test_a_true_goal_that_vanishes_within_its_segment_is_told():
    placed = np.zeros((7, 2, 2))
    placed[3, 0] = np.nan
    fault = only_fault(small_log(goal_position=placed))
    assert (fault.kind, fault.trial, fault.column) == ("goals-missing", "a", "true_goal")


@given(data=st.data())
def test_absent_true_goals_are_those_that_looking_at_every_sample_finds(data):
    sizes = data.draw(st.lists(st.integers(2, 6), min_size=1, max_size=5))
    total, n_trials = sum(sizes), len(sizes)
    present = data.draw(hnp.arrays(bool, (total, 2), elements=st.booleans()))
    present[:, 1] |= ~present.any(axis=1)
    stop = np.array([data.draw(st.integers(1, size)) for size in sizes])
    start = np.array([data.draw(st.integers(0, int(end) - 1)) for end in stop])
    goal = data.draw(hnp.arrays(np.int64, n_trials, elements=st.integers(0, 1)))
    log = build_log(
        agents=["human"],
        goals=["cup", "pan"],
        row_size=sizes,
        time=np.concatenate([np.arange(size) / 10 for size in sizes]),
        position=np.zeros((total, 1, 2)),
        goal_position=np.where(present[..., None], 0.0, np.nan) * np.ones(2),
        segment_trial=np.arange(n_trials),
        segment_agent=["human"] * n_trials,
        segment_start=start,
        segment_stop=stop,
        true_goal=np.array(["cup", "pan"])[goal].tolist(),
    )
    begin = np.cumsum(sizes) - sizes
    missing = [not present[begin[i] + start[i] : begin[i] + stop[i], goal[i]].all() for i in range(n_trials)]
    with mock.patch("ppinfer.studies.validation._BLOCK_SAMPLES", data.draw(st.integers(1, 8))):
        assert sum(validate_log(log).fault_counts.values()) == sum(missing)


def test_validation_tells_how_far_it_is(monkeypatch):
    monkeypatch.setattr("ppinfer.studies.validation._BLOCK_SAMPLES", 4)
    told = []
    validate_log(small_log(), progress=lambda done, total: told.append((done, total)))
    assert told == [(4, 7), (7, 7)]


def test_segments_of_one_agent_that_overlap_are_told():
    log = small_log(segment_trial=[0, 0], segment_agent=["human", "human"], true_goal=["cup", "pan"])
    assert only_fault(log.assign(segment_start=("segment", [1, 0]))).kind == "segment-overlap"
    two_agents = small_log(segment_trial=[0, 0], segment_start=[1, 0], segment_stop=[4, 3])
    assert validate_log(two_agents).ok


@pytest.mark.parametrize("name", [name for name, spec in VARIABLES.items() if spec.required])
def test_a_required_variable_that_is_missing_is_told(name):
    log = small_log().drop_vars(name)
    assert ("missing-variable", name) in [(fault.kind, fault.column) for fault in validate_log(log).faults]


def test_wrong_types_and_dimensions_are_told_together():
    log = small_log()
    log = log.assign(
        time=("sample", np.arange(7)),
        observed=("trial", np.zeros(2, np.int8)),
        participant=("trial", np.array([1, 2], dtype=object)),
    )
    found = {(fault.kind, fault.column) for fault in validate_log(log).faults}
    assert {
        ("wrong-type", "time"),
        ("wrong-dimensions", "observed"),
        ("wrong-type", "participant"),
    } <= found


def test_a_log_of_another_version_is_told():
    assert only_fault(small_log().assign_attrs(ppinfer_format_version=2)).kind == "format"


def test_velocity_must_be_there_where_it_is_said_to_be():
    velocity = np.zeros((7, 2, 2))
    velocity[:, 1] = np.nan
    assert validate_log(small_log(velocity=velocity)).ok
    assert set(validate_log(small_log(velocity=velocity, has_velocity=[True, True])).fault_counts) == {
        "not-finite"
    }
    assert set(validate_log(small_log(velocity=velocity, has_velocity=[False, False])).fault_counts) == {
        "not-logged"
    }


def test_repeated_faults_are_counted_exactly_and_listed_briefly():
    log = build_log(agents=["human"], row_size=[1000], time=np.zeros(1000), position=np.zeros((1000, 1, 2)))
    report = validate_log(log)
    assert report.fault_counts == {"time-not-increasing": 999}
    assert len(report.faults) == 20
    assert report.lines()[-1].endswith("and 979 more of kind time-not-increasing")
    with pytest.raises(FaultyLogError) as caught:
        report.raise_if_faulty()
    assert caught.value.counts == {"time-not-increasing": 999}


def test_all_faults_are_told_at_once():
    log = small_log().copy(deep=True)
    log.time.values[1] = 0.0
    log.position.values[2, 0] = np.nan
    log.trial_id.values[1] = "a"
    log.segment_agent.values[0] = "ghost"
    assert kinds(log) == ["duplicate-trial", "not-finite", "time-not-increasing", "unknown-agent"]


def test_implausible_jumps_are_warnings_with_a_count_per_agent():
    position = np.zeros((200, 2, 2))
    position[:, :, 0] = np.arange(200)[:, None] * 0.1
    position[50, 0] += 30.0
    log = build_log(agents=["human", "robot"], row_size=[200], time=np.arange(200) / 10, position=position)
    report = validate_log(log)
    assert report.ok
    assert report.warning_counts == {"implausible-jump": 2}
    assert [(warning.sample, warning.count) for warning in report.warnings] == [(50, 2)]
    assert "'human'" in report.warnings[0].message


@pytest.mark.parametrize("share", [0.005, 0.03, 0.1, 0.2])
def test_every_step_to_and_from_a_displaced_sample_is_counted_however_many_there_are(share):
    rng = np.random.default_rng(3)
    displaced = rng.random(2000) < share
    position = np.cumsum(rng.normal(0.1, 0.05, (2000, 1, 2)), axis=0)
    position[displaced, 0] += rng.uniform(30.0, 60.0, (displaced.sum(), 2)) * (-1) ** np.arange(
        displaced.sum()
    ).reshape(-1, 1)
    log = build_log(agents=["human"], row_size=[2000], time=np.arange(2000) / 10, position=position)
    assert validate_log(log).warning_counts == {"implausible-jump": (displaced[1:] | displaced[:-1]).sum()}


def test_the_step_between_two_trials_is_no_jump():
    position = np.concatenate([np.zeros((50, 1, 2)), np.full((50, 1, 2), 1e6)])
    position += np.tile(np.arange(50) * 0.1, 2)[:, None, None]
    log = build_log(
        agents=["human"], row_size=[50, 50], time=np.tile(np.arange(50) / 10, 2), position=position
    )
    assert not validate_log(log).warnings


def test_faults_of_a_file_are_those_of_the_log(tmp_path):
    log = edited("time", 2, 0.1)
    write_log(log, tmp_path / "log.nc", validate=False)
    report = validate_log(tmp_path / "log.nc")
    assert [str(fault) for fault in report.faults] == [str(fault) for fault in validate_log(log).faults]
    with pytest.raises(FaultyLogError, match="time"):
        read_log(tmp_path / "log.nc")


def test_a_fault_far_into_a_long_log_is_placed_right(monkeypatch):
    monkeypatch.setattr("ppinfer.studies.validation._BLOCK_SAMPLES", 8)
    sizes = np.arange(1, 12)
    time = np.concatenate([np.arange(size) / 10 for size in sizes])
    log = build_log(agents=["human"], row_size=sizes, time=time, position=np.ones((time.size, 1, 2)))
    log.position.values[sizes[:9].sum() + 4] = np.inf
    fault = only_fault(log)
    assert (fault.trial, fault.sample) == ("9", 4)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"time": [0.0]}, r"time: expected shape \(7,\), got \(1,\)"),
        ({"position": np.zeros((7, 2))}, "position: expected shape"),
        ({"position": np.zeros((7, 3, 2))}, "position: expected shape"),
        ({"velocity": np.zeros((6, 2, 2))}, "velocity: expected shape"),
        ({"participant": [1, 2]}, "participant: expected text"),
        ({"row_size": ["4", "3"]}, "row_size: expected int64"),
        ({"round": [0.5, 1.0]}, "round: expected whole numbers"),
        ({"observed": np.full((7, 2), 2)}, "observed: expected 0 or 1"),
        ({"goal_position": None}, "goal_position is not given"),
        ({"goal_position": np.zeros(3)}, "goal_position: expected shape"),
        ({"controller": {"ghost": "x"}}, "unknown agents"),
        ({"variables": {"time": (("sample",), np.zeros(7))}}, "the log's own"),
        ({"variables": {"heat": (("sample",), np.zeros(6))}}, "'heat' on"),
        ({"variables": {"heat": (("sample",), np.zeros(7, complex))}}, "numbers or text"),
    ],
)
def test_arrays_that_do_not_fit_are_refused_by_name(changed, told):
    with pytest.raises(LogError, match=told):
        small_log(**changed)


def test_the_message_of_many_faults_names_the_first():
    faults = Faults([Fault("a", "one", file="x.csv"), Fault("b", "two")])
    assert str(FaultyLogError("x.csv", faults)) == "x.csv: 2 faults; the first: one"


EXTREMES = {
    "f": [np.nan, np.inf, -1e308, 1e308, 0.0],
    "i": [-(2**62), -1, 0, 2**62],
    "O": ["", "a", None, 3, b"x"],
}


@settings(max_examples=150)
@given(data=st.data())
def test_validation_answers_whatever_a_log_holds(data):
    velocity = np.zeros((7, 2, 2))
    log = small_log(velocity=velocity, goal_position=np.zeros((7, 2, 2))).copy(deep=True)
    names = st.sampled_from(sorted(log.data_vars))
    for name in data.draw(st.lists(names, min_size=1, max_size=3, unique=True)):
        change = data.draw(st.sampled_from(["value", "drop", "type", "rename"]))
        if change == "drop":
            log = log.drop_vars(name)
        elif change == "rename":
            log = log.rename_vars({name: f"{name} "})
        elif change == "type":
            kinds_of = ["U5", "S5"] if log[name].dtype == object else ["f4", "i2", "O", "U5"]
            with np.errstate(invalid="ignore"):
                log[name] = log[name].astype(data.draw(st.sampled_from(kinds_of)))
        else:
            values = log[name].values
            kind = "i" if values.dtype.kind == "i" and values.dtype.itemsize == 8 else values.dtype.kind
            if kind in EXTREMES and not (kind == "i" and values.dtype.itemsize == 1):
                values.flat[data.draw(st.integers(0, values.size - 1))] = data.draw(
                    st.sampled_from(EXTREMES[kind])
                )
    report = validate_log(log)
    assert report.ok == (not report.fault_counts)
    report.to_json()


@pytest.mark.parametrize("dimension", ["trial", "sample", "agent", "space", "goal", "segment"])
@pytest.mark.parametrize("moving", [False, True])
def test_validation_answers_when_a_dimension_is_empty(dimension, moving, tmp_path):
    placed = np.zeros((7, 2, 2)) if moving else np.zeros((2, 2))
    log = small_log(velocity=np.zeros((7, 2, 2)), goal_position=placed).isel({dimension: slice(0)})
    report = validate_log(log)
    assert report.ok == (dimension == "segment")
    write_log(log, tmp_path / "log.zarr", validate=False)
    assert validate_log(tmp_path / "log.zarr").fault_counts == report.fault_counts


def test_faults_of_a_parquet_table_are_counted_by_row():
    assert str(Fault("not-finite", "x is inf", file="a.parquet", line=3)).startswith("a.parquet: row 3: ")
    assert str(Fault("not-finite", "x is inf", file="a.csv", line=3)).startswith("a.csv: line 3: ")


def test_damage_is_told_before_what_may_follow_from_it():
    faults = Faults([Fault("not-finite", "x is nan"), Fault("checksum", "does not match")])
    assert [fault.kind for fault in Report.of("log.nc", faults, Faults()).faults] == [
        "checksum",
        "not-finite",
    ]
