"""Small trials whose metrics can be worked out by hand."""

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.studies import build_log
from ppinfer.studies.metrics import trial_metrics


def steps(*moved):
    """Return positions along x, one unit a step where moved is 1; None is a dropout."""
    return np.cumsum([0.0, *(step or 0.0 for step in moved)])


def pair(human, robot, **more):
    """Return a log of one trial with a sample a second, whose agents move along x."""
    position = np.zeros((len(human), 2, 2))
    position[:, 0, 0], position[:, 1, 0] = human, robot
    position[np.isnan(position[..., 0])] = np.nan
    return build_log(
        agents=["human", "robot"], row_size=[len(human)], time=np.arange(len(human), dtype=float), position=position,
        **more,
    )  # fmt: skip


def value(log, name, **options):
    """Return one metric of the first trial."""
    return trial_metrics(log, names=[name], **({"idle": "motion", "idle_speed": 0.5} | options)).values[0, 0]


def test_idle_and_concurrent_shares_of_a_trial_made_by_hand():
    # ten seconds: the human moves in the first 6, the robot in the last 7; both in 3 of them
    log = pair(steps(*[1] * 6, *[0] * 4), steps(*[0] * 3, *[1] * 7))
    assert value(log, "human_idle_share") == pytest.approx(0.4)
    assert value(log, "robot_idle_share") == pytest.approx(0.3)
    assert value(log, "human_active_share") == pytest.approx(0.6)
    assert value(log, "concurrent_share") == pytest.approx(0.3)


def test_functional_delay_is_the_gap_between_turns_and_minus_the_overlap():
    # human [0, 3), robot [5, 8), human [7, 10): two seconds of gap, one second of overlap
    log = pair(steps(1, 1, 1, 0, 0, 0, 0, 1, 1, 1), steps(0, 0, 0, 0, 0, 1, 1, 1, 0, 0))
    assert value(log, "functional_delay") == pytest.approx((2 - 1) / 10)


def test_functional_delay_of_one_action_inside_another_is_minus_its_length():
    log = pair(steps(*[1] * 10), steps(0, 0, 1, 1, 0, 0, 0, 0, 0, 0))
    assert value(log, "functional_delay") == pytest.approx(-0.2)


def test_functional_delay_is_undefined_where_one_of_them_never_acts():
    log = pair(steps(1, 1, 1), steps(0, 0, 0))
    with pytest.raises(LogError, match="functional_delay: it is undefined in every trial"):
        value(log, "functional_delay")


def test_an_agent_at_the_threshold_is_idle_and_above_it_active():
    log = pair(steps(0.5, 0.5625, 0.25, 0), steps(1, 1, 1, 1))
    assert value(log, "human_idle_share") == pytest.approx(0.75)


def test_dropouts_are_neither_idle_nor_active_and_paths_do_not_bridge_them():
    human = steps(1, 1, 1, 1, 0, 0, 0, 0)
    human[2] = np.nan
    log = pair(human, steps(*[1] * 8))
    assert value(log, "human_unseen_share") == pytest.approx(2 / 8)
    assert value(log, "human_active_share") == pytest.approx(2 / 8)
    assert value(log, "human_idle_share") == pytest.approx(4 / 8)
    assert value(log, "human_path_length") == pytest.approx(2.0)
    assert value(log, "human_mean_speed") == pytest.approx(2.0 / 6)
    assert any("the human is not seen for 25 %" in told for told in trial_metrics(log).warnings)


def test_shares_count_until_the_first_of_both_has_finished():
    log = pair(
        steps(1, 1, 1, 1, 0, 0, 0, 0),
        steps(0, 0, 1, 1, 1, 1, 1, 1),
        variables={"finish_time": (("trial", "agent"), [[4.0, np.nan]])},
    )
    assert value(log, "human_idle_share") == 0.0
    assert value(log, "robot_idle_share") == pytest.approx(0.5)
    assert value(log, "concurrent_share") == pytest.approx(0.5)
    assert value(log, "total_s") == 8.0
    assert value(log, "human_s") == 4.0
    assert value(log, "failures") == 1.0


def flagged(human, robot):
    """Return a log of two who move all the time, with waiting flags."""
    told = {"is_human_waiting": (("sample",), human), "is_robot_waiting": (("sample",), robot)}
    length = len(human) - 1
    return pair(steps(*[1] * length), steps(*[1] * length), variables=told)


def test_flags_count_from_their_sample_to_the_next_where_both_change():
    log = flagged([1, 1, 0, 0, 1], [0, 0, 0, 1, 0])
    found = trial_metrics(log, names=["human_idle_share", "robot_idle_share", "concurrent_share"])
    assert found.provenance["options"]["idle"]["from"] == "flags"
    np.testing.assert_allclose(found.values[0], [0.5, 0.25, 0.25])


def test_a_flag_that_never_changes_is_not_believed_unless_it_is_asked_for():
    log = flagged([1, 1, 0, 0, 1], [0, 0, 0, 0, 0])
    found = trial_metrics(log, names=["robot_idle_share", "human_idle_share"])
    assert found.provenance["options"]["idle"]["from"] == "motion"
    assert found.values[0].tolist() == [0.0, 0.0]
    assert "is_robot_waiting never changes" in found.warnings[0]
    assert value(log, "human_idle_share", idle="flags", idle_speed=None) == pytest.approx(0.5)


def test_flags_that_are_not_there_are_refused():
    with pytest.raises(LogError, match="the log has no is_robot_waiting, no is_human_waiting"):
        value(pair(steps(1, 1), steps(1, 1)), "human_idle_share", idle="flags")


def test_without_a_threshold_it_is_a_tenth_of_the_agents_usual_top_speed():
    log = pair(steps(*[2] * 40), steps(*[4] * 40))
    rule = trial_metrics(log).provenance["options"]["idle"]
    assert rule["units"] == "m/s"
    assert rule["speed"] == {"robot": pytest.approx(0.4), "human": pytest.approx(0.2)}


@pytest.mark.parametrize("speed", [-1.0, np.nan, np.inf])
def test_a_threshold_that_is_no_speed_is_refused(speed):
    with pytest.raises(LogError, match="expected a number, 0 or more"):
        trial_metrics(pair(steps(1), steps(1)), idle_speed=speed)


def test_collisions_are_episodes_and_not_samples():
    collision = [1, 1, 0, 1, 0, 0, 1, 1, 1]
    log = pair(steps(*[1] * 8), steps(*[1] * 8), variables={"collision": (("sample",), collision)})
    assert value(log, "collisions") == 3


def test_a_collision_at_the_end_of_a_trial_does_not_go_on_in_the_next():
    log = build_log(
        agents=["human"], row_size=[2, 2], time=[0.0, 1.0, 0.0, 1.0], position=np.zeros((4, 1, 2)),
        variables={"collision": (("sample",), [0, 1, 1, 0])},
    )  # fmt: skip
    assert trial_metrics(log, names=["collisions"]).values[:, 0].tolist() == [1.0, 1.0]


@pytest.mark.parametrize(
    ("variables", "expected"),
    [
        ({"collisions": (("trial",), [4])}, 4.0),
        ({"n_collisions": (("trial",), [5])}, 5.0),
        ({"n_collisions": (("trial",), [5]), "collision": (("sample",), [0, 1, 1])}, 1.0),
    ],
)
def test_collisions_are_counted_by_sample_where_they_can_be_and_else_as_logged(variables, expected):
    assert value(pair(steps(1, 1), steps(1, 1), variables=variables), "collisions") == expected


@pytest.mark.parametrize(
    ("variables", "expected"),
    [
        ({"scored": (("sample",), [0, 0, 1, 1])}, (2.0, 0.0)),
        ({"scored": (("sample",), [0, 0, 0, 0])}, (3.0, 1.0)),
        ({"human_pick": (("sample",), [-1, 0, -1, 2])}, (1.0, 0.0)),
        ({"first_score_s": (("trial",), [np.nan]), "scored": (("sample",), [0, 1, 0, 0])}, (3.0, 1.0)),
    ],
)
def test_the_first_score_is_as_logged_or_the_first_sample_marked(variables, expected):
    log = pair(steps(1, 1, 1), steps(1, 1, 1), variables=variables)
    assert (value(log, "first_score_s"), value(log, "scoreless")) == expected


def with_goals(pursued, moved=(), **more):
    """Return a log of a human that goes for these goals, which are drawn anew at some samples."""
    draws = np.zeros(len(pursued))
    draws[list(moved)] = 1.0
    where = np.arange(3.0)[None, :, None] + np.cumsum(draws)[:, None, None] + np.zeros((len(pursued), 3, 2))
    both = np.column_stack([pursued, np.zeros(len(pursued))]).astype(np.int8)
    length = len(pursued) - 1
    return pair(
        steps(*[1] * length), steps(*[1] * length), goals=list("abc"), goal_position=where,
        variables={"pursued": (("sample", "agent"), both)}, **more,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("pursued", "moved", "expected"),
    [
        ([0, 0, 1, 1, 0], (), 2),
        ([0, -1, -1, 0, 0], (), 0),
        ([0, -1, 1, -1, -1], (), 1),
        ([0, 0, 1, 1, 1], (2,), 0),
        ([0, 0, -1, 1, 1], (2,), 0),
        ([0, 0, 1, 2, 2], (2,), 1),
        ([-1, -1, -1, -1, 2], (), 0),
    ],
)
def test_a_change_of_goal_counts_while_the_goals_stay(pursued, moved, expected):
    log = with_goals(pursued, moved)
    assert value(log, "human_goal_changes") == expected
    assert value(log, "robot_goal_changes") == 0


def test_changes_of_goal_that_were_logged_are_taken_as_they_are():
    log = with_goals([0, 1, 2])
    log["human_goal_changes"] = ("trial", [7])
    assert value(log, "human_goal_changes") == 7


def test_picks_and_segments_are_counted_in_a_minute():
    log = pair(
        steps(*[1] * 30), steps(*[1] * 30),
        segment_trial=[0, 0, 0], segment_agent=["human", "human", "robot"], segment_start=[0, 9, 0],
        segment_stop=[5, 20, 5], true_goal=["", "", ""],
        variables={"human_pick": (("sample",), [-1] * 30 + [2])},
    )  # fmt: skip
    assert value(log, "human_segments_per_minute") == pytest.approx(4.0)
    assert value(log, "robot_segments_per_minute") == pytest.approx(2.0)
    assert value(log, "human_picks_per_minute") == pytest.approx(2.0)


def test_a_trial_of_one_sample_has_no_rates_and_the_others_have_theirs():
    log = build_log(
        agents=["human"], row_size=[1, 3], time=[5.0, 0.0, 1.0, 2.0], position=np.zeros((4, 1, 2)),
        variables={"human_pick": (("sample",), [0, 0, -1, 0])},
    )  # fmt: skip
    found = trial_metrics(log)
    assert found.values_of("duration_s").tolist() == [0.0, 2.0]
    for name in ("human_picks_per_minute", "human_mean_speed", "human_idle_share", "human_path_length"):
        assert np.isnan(found.values_of(name)).tolist() == [True, False], name
