import numpy as np
import pytest

from ppinfer import Axis, Distribution
from ppinfer.coordination.plans import PlanSet
from ppinfer.coordination.policy import Decision
from ppinfer.coordination.situation import Situation
from ppinfer.errors import LogError
from ppinfer.studies import (
    RecordingHeader,
    RecordingWriter,
    Replan,
    ReplanTable,
    iter_blocks,
    log_of_trials,
    open_log,
    read_log,
    read_recording,
    validate_log,
    write_log,
)
from ppinfer.studies.recording_lines import header_line
from ppinfer.studies.schema import RAGGED
from ppinfer.testing.example_plays import planned_study

from .logs import plain, small_log

TRIALS, OPTIONS = planned_study(trials=4, replans=3, plans=2)


def moving(agent, plans=2):
    """Return some plans of an agent that end in different places, and one that does not move."""
    row_size = np.array([2] * plans + [1])
    time = np.array([0.0, 1.0] * plans + [0.0])
    position = time[:, None] * np.ones(1)
    return PlanSet(agent, row_size, time, position, static=plans)


def replan_of(*plans, agent="robot", **changed):
    shape = tuple(len(one) for one in plans)
    parts = {
        "time": 0.0,
        "sample": 0,
        "agent": agent,
        "plans": plans,
        "cost": np.arange(float(len(shape) * np.prod(shape))).reshape(len(shape), *shape),
        "contact_time": np.arange(float(np.prod(shape))).reshape(shape),
        "decision": [0] * len(shape),
    }
    return Replan(**(parts | changed))


def test_costs_run_over_the_grid_in_the_order_of_the_logs_agents():
    robot, human = moving("robot", 3), moving("human", 1)
    replan = replan_of(robot, human)
    table = ReplanTable.of([replan], agents=("human", "robot"), space=1, theta=())
    for human_plan in range(2):
        for robot_plan in range(4):
            row = human_plan * 4 + robot_plan
            assert table.cost[row].tolist() == [
                replan.cost[1, robot_plan, human_plan],
                replan.cost[0, robot_plan, human_plan],
            ]
            assert table.contact_time[row] == replan.contact_time[robot_plan, human_plan]
    assert table.plan_row_size.tolist() == [[2, 4]]
    assert table.static_plan.tolist() == [[1, 3]]
    assert table.waypoint_row_size.tolist() == [2, 1, 2, 2, 2, 1]


def test_an_agent_that_has_left_has_no_plans_and_no_costs():
    table = ReplanTable.of([replan_of(moving("robot"))], agents=("human", "robot"), space=1, theta=())
    assert table.plan_row_size.tolist() == [[0, 3]]
    assert table.decision.tolist() == [[-1, 0]]
    assert np.isnan(table.cost[:, 0]).all()
    assert table.cost[:, 1].tolist() == [0.0, 1.0, 2.0]


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"cost": np.zeros((1, 2))}, r"cost has shape \(1, 2\); \(1, 3\) is expected"),
        ({"contact_time": np.zeros(2)}, "contact_time has shape"),
        ({"decision": [0, 0]}, "the decision has 2 plans for 1 agents"),
        ({"plans": [moving("ghost")]}, "agents are"),
        ({"live_log_posterior": np.zeros(3)}, r"shape \(3,\); theta has 2 labels"),
        (
            {"live_log_posterior": np.zeros(1), "theta": ["fair"]},
            r"over theta \['fair'\], the log's theta is \['human', 'robot'\]",
        ),
    ],
)
def test_replans_that_do_not_fit_are_refused_by_name(changed, told):
    replan = replan_of(moving("robot"), **changed)
    with pytest.raises(LogError, match=told):
        ReplanTable.of([replan], agents=("human", "robot"), space=1, theta=("human", "robot"))


def test_a_decision_becomes_a_replan_with_its_belief():
    situation = Situation.from_contacts([moving("robot"), moving("human")], np.full((3, 3), np.inf), time=0.8)
    belief = Distribution.from_probabilities([Axis("theta", ["robot", "human"])], [0.3, 0.7])
    over = Distribution.uniform(*situation.game.plans)
    told = Replan.of(situation, "human", 8, Decision(1, over, (2, 1), belief))
    assert (told.time, told.sample, told.agent, told.decision) == (0.8, 8, "human", (2, 1))
    np.testing.assert_allclose(np.exp(told.live_log_posterior), [0.3, 0.7])
    alone = Replan.of(situation, "human", 8, Decision(1, over))
    assert alone.decision == (-1, 1)
    assert alone.live_log_posterior is None
    with pytest.raises(LogError, match="over theta alone"):
        Replan.of(situation, "human", 8, Decision(1, over, belief=over))


def test_beliefs_are_put_under_the_logs_labels_by_name():
    replan = replan_of(moving("robot"), live_log_posterior=np.log([0.3, 0.7]), theta=["robot", "human"])
    table = ReplanTable.of([replan], agents=("human", "robot"), space=1, theta=("human", "fair", "robot"))
    np.testing.assert_allclose(np.exp(table.live_log_posterior), [[0.7, 0.0, 0.3]])


def test_a_planned_study_is_recorded_to_the_last_bit_infinities_included(tmp_path):
    log = log_of_trials(TRIALS, **OPTIONS)
    assert np.isinf(log.cost).any()
    assert np.isinf(log.contact_time).any()
    with RecordingWriter(tmp_path / "study.jsonl", RecordingHeader(**OPTIONS)) as recording:
        for trial in TRIALS:
            recording.append(trial)
    assert plain(read_recording(tmp_path / "study.jsonl")).identical(plain(log))


def test_a_resumed_planned_study_equals_an_uninterrupted_one_byte_for_byte(tmp_path):
    header = RecordingHeader(**OPTIONS)
    whole, resumed = tmp_path / "whole.jsonl", tmp_path / "resumed.jsonl"
    with RecordingWriter(whole, header) as recording:
        for trial in TRIALS:
            recording.append(trial)
    content = whole.read_bytes()
    for length in np.linspace(0, len(content), 12).astype(int):
        resumed.write_bytes(content[:length])
        with RecordingWriter(resumed, header, resume=True) as recording:
            for trial in TRIALS:
                if trial.trial_id not in recording.completed:
                    recording.append(trial)
        assert resumed.read_bytes() == content


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_a_planned_log_comes_back_from_disk_as_it_was(tmp_path, suffix):
    log = log_of_trials(TRIALS, **OPTIONS)
    path = tmp_path / f"log{suffix}"
    write_log(log, path)
    assert plain(read_log(path)).identical(plain(log))
    write_log(log, tmp_path / "other.nc")
    with open_log(path) as one, open_log(tmp_path / "other.nc") as other:
        assert one.attrs["content_sha256"] == other.attrs["content_sha256"]


@pytest.mark.parametrize("suffix", [".nc", ".zarr", None])
@pytest.mark.parametrize("max_samples", [1, 300, 10**6])
def test_blocks_hold_the_replans_of_their_trials(tmp_path, suffix, max_samples):
    log = source = log_of_trials(TRIALS, **OPTIONS)
    if suffix:
        source = tmp_path / f"log{suffix}"
        write_log(log, source)
    blocks = list(iter_blocks(source, max_samples=max_samples))
    assert len(blocks) > 1 or max_samples > 300
    for name in [name for name in log.data_vars if log[name].dims[0] in ("trial", *RAGGED)]:
        joined = np.concatenate([block[name].values for block in blocks])
        np.testing.assert_array_equal(joined, log[name].values)
    for block in blocks:
        assert validate_log(block).ok
        assert block.attrs["first_replan"] == 6 * block.attrs["first_trial"]
        work = max(block.sizes["sample"], block.sizes["waypoint"] + block.sizes["profile"])
        assert work <= max_samples or block.sizes["trial"] == 1


def test_blocks_leave_replans_out_where_only_samples_are_asked_for():
    block = next(iter_blocks(log_of_trials(TRIALS, **OPTIONS), variables=["time", "position"]))
    assert "replan" not in block.dims
    assert "replan_row_size" not in block
    assert "finish_time" in block


def test_blocks_of_replans_that_do_not_add_up_are_refused():
    log = log_of_trials(TRIALS, **OPTIONS)
    wrong = log.assign(waypoint_row_size=log.waypoint_row_size + 1)
    with pytest.raises(LogError, match="add up to"):
        next(iter_blocks(wrong))
    with pytest.raises(LogError, match="no cost"):
        next(iter_blocks(log.drop_vars("cost")))


def test_a_trial_without_replans_may_stand_among_others():
    bare = TRIALS[0].__class__("bare", "p", time=TRIALS[0].time, position=TRIALS[0].position,
                               velocity=TRIALS[0].velocity, variables=TRIALS[0].variables)  # fmt: skip
    log = log_of_trials([bare, TRIALS[1]], **OPTIONS)
    assert log.replan_row_size.values.tolist() == [0, 6]
    assert validate_log(log).ok
    assert "replan_row_size" not in log_of_trials([bare], **OPTIONS)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"held": (("trial",), [0, 1])}, "'held' is on"),
        ({"held": (("sample",), np.full(7, 2))}, "held: expected 0 or 1"),
        ({"stops": (("trial",), [0.5, 1.0])}, "stops: expected whole numbers"),
        ({"scene": (("trial",), [0])}, r"scene: expected shape \(2,\)"),
        ({"replan_time": (("replan",), [0.0])}, "the log's own"),
    ],
)
def test_known_variables_of_planned_worlds_keep_their_dimensions_and_types(changed, told):
    with pytest.raises(LogError, match=told):
        small_log(variables=changed)


def test_headers_without_theta_are_those_of_older_recordings():
    assert b"theta" not in header_line(RecordingHeader(agents=("human",)))
