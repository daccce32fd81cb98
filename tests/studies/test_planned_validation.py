from dataclasses import replace
from unittest import mock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer.studies import log_of_trials, read_log, select_trials, validate_log, write_log
from ppinfer.studies.faults import FaultyLogError
from ppinfer.studies.schema import REPLAN_VARIABLES, VARIABLES
from ppinfer.testing.example_plays import planned_study

TRIALS, OPTIONS = planned_study(trials=3, replans=2, plans=2)
# a trial has 4 replans of 2 agents, each agent 3 plans (2 of 3 waypoints, 1 of 1), and 9 profiles a replan


def planned_log():
    return log_of_trials(TRIALS, **OPTIONS).copy(deep=True)


def edited(name, index, value):
    log = planned_log()
    log[name].values[index] = value
    return log


def found(log):
    return [
        (fault.kind, fault.trial, fault.sample, fault.replan, fault.column)
        for fault in validate_log(log).faults
    ]


def test_a_sound_planned_log_has_no_faults():
    report = validate_log(planned_log())
    assert not report.lines()
    assert report.sizes["replan"] == 12


# replan 6 is the third of the second trial; it has plans 36 to 41, waypoints 84 to 97, profiles 54 to 62
@pytest.mark.parametrize(
    ("name", "index", "value", "kind", "replan"),
    [
        ("replan_time", 6, np.nan, "not-finite", 2),
        ("replan_time", 6, 0.9, "replan-time", 2),
        ("replan_agent", 6, "ghost", "unknown-agent", 2),
        ("static_plan", (6, 1), 3, "plan-range", 2),
        ("static_plan", (6, 1), -2, "plan-range", 2),
        ("committed_plan", (6, 0), 3, "plan-range", 2),
        ("decision", (6, 0), -1, "plan-range", 2),
        ("decision", (6, 1), 3, "plan-range", 2),
        ("waypoint_time", 84, 0.1, "time-not-increasing", 2),
        ("waypoint_time", 86, 0.0, "time-not-increasing", 2),
        ("waypoint_time", 97, np.inf, "not-finite", 2),
        ("waypoint_position", (90, 1), np.nan, "not-finite", 2),
        ("cost", (54, 0), np.nan, "wrong-value", 2),
        ("cost", (62, 1), -1.0, "wrong-value", 2),
        ("contact_time", 62, np.nan, "wrong-value", 2),
        ("contact_time", 63, -0.5, "wrong-value", 3),
        ("live_log_posterior", (7, 0), 0.1, "not-normalised", 3),
        ("live_log_posterior", (7, 0), np.nan, "not-normalised", 3),
        ("live_log_posterior", 7, np.inf, "not-normalised", 3),
    ],
)
def test_each_fault_says_its_trial_replan_and_column(name, index, value, kind, replan):
    assert (kind, "scene-1", None, replan, name) in found(edited(name, index, value))
    assert len(found(edited(name, index, value))) == 1


def test_replans_out_of_order_or_outside_their_trial_are_told():
    assert ("replan-order", "scene-1", None, 2, "replan_sample") in found(edited("replan_sample", 6, 0))
    assert ("replan-range", "scene-1", None, 2, "replan_sample") in found(edited("replan_sample", 6, 17))
    assert ("replan-range", "scene-1", None, 2, "replan_sample") in found(edited("replan_sample", 6, -1))


@pytest.mark.parametrize(
    ("name", "index", "value", "kind"),
    [
        ("finish_time", (1, 0), -0.1, "wrong-value"),
        ("finish_time", (1, 0), np.inf, "wrong-value"),
        ("stops", 1, -1, "wrong-value"),
        ("stop_episodes", 1, 99, "wrong-value"),
        ("plan_sets", 1, "both", "wrong-value"),
        ("live_model", 1, "personality", "wrong-value"),
        ("live_model", 1, '{"parameters": {}}', "wrong-value"),
    ],
)
def test_what_a_trial_says_of_its_end_is_checked(name, index, value, kind):
    faults = found(edited(name, index, value))
    assert (kind, "scene-1", None, None, name) in faults
    assert {fault[0] for fault in faults} == {kind}


def test_marks_and_hands_of_samples_are_checked():
    assert found(edited("held", 20, 2)) == [("wrong-value", "scene-1", 3, None, "held")]
    assert found(edited("end_effector", (20, 0, 0), np.inf)) == [
        ("not-finite", "scene-1", 3, None, "end_effector")
    ]
    assert validate_log(edited("end_effector", (20, 0), np.nan)).ok


@pytest.mark.parametrize(
    ("name", "index", "value"),
    [
        ("replan_row_size", 0, 5),
        ("replan_row_size", 0, -4),
        ("plan_row_size", (0, 0), 4),
        ("plan_row_size", (0, 0), -3),
        ("plan_row_size", (0, 0), 2**62),
        ("waypoint_row_size", 0, 4),
        ("waypoint_row_size", 0, 0),
    ],
)
def test_row_sizes_that_do_not_add_up_are_told(name, index, value):
    log = edited(name, index, value)
    report = validate_log(log)
    assert set(report.fault_counts) == {"wrong-length"}
    assert name in {fault.column for fault in report.faults}


def test_grids_that_are_not_the_profiles_are_told():
    log = planned_log()
    # as many plans as before, but other grids
    log.plan_row_size.values[0] = [2, 4]
    assert ("wrong-length", None, None, None, "cost") in found(log)


def test_trials_without_any_replan_are_sound():
    log = select_trials(log_of_trials([TRIALS[0], replace(TRIALS[1], replans=())], **OPTIONS), [1])
    assert log.sizes["replan"] == 0
    assert validate_log(log).ok


def test_an_agent_without_plans_costs_nothing_and_decides_nothing():
    trial = TRIALS[0]
    first, second, *rest = trial.replans
    alone = replace(
        second, plans=second.plans[1:], cost=second.cost[1:, 0], contact_time=np.full(3, np.inf), decision=[0]
    )
    log = log_of_trials([replace(trial, replans=[first, alone, *rest])], **OPTIONS)
    assert validate_log(log).ok
    wrong = log.copy(deep=True)
    wrong.cost.values[9, 0] = 1.0
    assert found(wrong) == [("wrong-value", "scene-0", None, 1, "cost")]
    wrong = log.copy(deep=True)
    wrong.replan_agent.values[1] = "human"
    assert ("wrong-length", "scene-0", None, 1, "plan_row_size") in found(wrong)


@pytest.mark.parametrize("name", REPLAN_VARIABLES)
def test_a_variable_of_replans_that_is_missing_is_told(name):
    log = planned_log().drop_vars(name)
    assert ("missing-variable", name) in [(fault.kind, fault.column) for fault in validate_log(log).faults]


def test_a_belief_and_its_labels_come_together():
    faults = validate_log(planned_log().drop_vars("theta")).faults
    assert [(fault.kind, fault.column) for fault in faults] == [("missing-variable", "theta")]


@settings(max_examples=10)
@given(block=st.integers(9, 60), row=st.integers(0, 107), name=st.sampled_from(["cost", "contact_time"]))
def test_faults_are_placed_right_however_the_log_is_read(block, row, name):
    log = planned_log()
    log[name].values[row] = -1.0
    with (
        mock.patch("ppinfer.studies.validation._BLOCK_DEEP", block),
        mock.patch("ppinfer.studies.validation._BLOCK_SAMPLES", block),
    ):
        (fault,) = validate_log(log).faults
    assert (fault.trial, fault.replan) == (f"scene-{row // 36}", row % 36 // 9)


def test_faults_of_a_file_are_those_of_the_log(tmp_path):
    log = edited("cost", (62, 1), -1.0)
    for name in ("log.nc", "log.zarr"):
        write_log(log, tmp_path / name, validate=False)
        assert found(tmp_path / name) == found(log)
        with pytest.raises(FaultyLogError, match="replan 2: column 'cost'"):
            read_log(tmp_path / name)


EXTREMES = {
    "f": [np.nan, np.inf, -np.inf, -1e308, 1e308, 0.0],
    "i": [-(2**62), -1, 0, 1, 2, 4, 2**62],
    "O": ["", "a", None, 3, b"x", "human", "{}"],
}
PLANNED = sorted(
    name
    for name, spec in VARIABLES.items()
    if name in REPLAN_VARIABLES
    or spec.as_variable
    or name in ("live_log_posterior", "row_size", "time", "agent")
)


@settings(max_examples=60)
@given(data=st.data())
def test_validation_answers_whatever_a_planned_log_holds(data):
    log = planned_log()
    for name in data.draw(st.lists(st.sampled_from(PLANNED), min_size=1, max_size=3, unique=True)):
        change = data.draw(st.sampled_from(["value", "value", "drop", "type", "rename"]))
        if name in log.coords:
            continue
        if change == "drop":
            log = log.drop_vars(name)
        elif change == "rename":
            log = log.rename_vars({name: f"{name} "})
        elif change == "type":
            kinds_of = ["U5", "S5"] if log[name].dtype == object else ["f4", "i2", "O", "U5"]
            with np.errstate(invalid="ignore", over="ignore"):
                log[name] = log[name].astype(data.draw(st.sampled_from(kinds_of)))
        elif log[name].dtype != np.int8:
            values = log[name].values
            values.flat[data.draw(st.integers(0, values.size - 1))] = data.draw(
                st.sampled_from(EXTREMES[values.dtype.kind])
            )
    report = validate_log(log)
    assert report.ok == (not report.fault_counts)
    report.to_json()


@pytest.mark.parametrize(
    "dimension",
    ["trial", "sample", "agent", "space", "replan", "plan", "waypoint", "profile", "theta", "table"],
)
def test_validation_answers_when_a_dimension_of_planned_worlds_is_empty(dimension, tmp_path):
    log = planned_log().isel({dimension: slice(0)})
    report = validate_log(log)
    assert report.ok == (dimension == "table")
    write_log(log, tmp_path / "log.zarr", validate=False)
    assert validate_log(tmp_path / "log.zarr").fault_counts == report.fault_counts
