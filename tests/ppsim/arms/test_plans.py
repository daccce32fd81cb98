"""Plans of an arm: raw, timed, and a function of their seed."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

from ppsim.arms.geometry import ARMS
from ppsim.arms.planners import PLANNERS
from ppsim.arms.plans import rest_of_plan, sample_plans, straight_plan
from ppsim.arms.world import STEP
from ppsim.errors import SimulationError

from .situations import plans_of, scene_of

ARM = ARMS["robot"]
GOALS = [[0.5, 0.5], [-0.5, 1.0]]


def waypoints(plans, number):
    rows = slice(plans.starts[number], plans.starts[number] + plans.row_size[number])
    return plans.time[rows], plans.position[rows]


def digest(plans):
    return hashlib.sha256(plans.time.tobytes() + plans.position.tobytes()).hexdigest()


@pytest.mark.parametrize("seed", range(5))
def test_every_plan_goes_from_here_over_the_pick_to_the_place_and_the_last_stays(seed):
    scene = scene_of(seed)
    task = scene.tasks["robot"]
    plans = plans_of(scene, seed)[0]
    assert (len(plans), plans.static, plans.committed) == (8, 7, None)
    for number in range(7):
        time, position = waypoints(plans, number)
        assert np.array_equal(position[0], ARM.home)
        assert (np.abs(position[-1] - task.place_joints).max(axis=1) == 0).any()
        passes = (position[:, None] == task.pick_joints).all(axis=-1).any(axis=1)
        assert passes.any()
        # each leg ends on a sample
        for ended in (*time[passes], time[-1]):
            assert abs(ended / STEP - round(ended / STEP)) < 1e-9
    assert waypoints(plans, 7)[1].tolist() == [list(ARM.home)]


def test_plans_of_one_set_take_either_elbow():
    plans = sample_plans(ARM, "robot", ARM.home, scene_of(1).tasks["robot"].goals(), seed=0, count=24)
    ends = {float(np.sign(waypoints(plans, number)[1][-1, 1])) for number in range(24)}
    assert ends == {-1.0, 1.0}


def test_joints_move_in_step_within_their_speed_and_nearly_at_it():
    plans = plans_of(scene_of(2), 2)[0]
    for number in range(7):
        time, position = waypoints(plans, number)
        speed = np.abs(np.diff(position, axis=0)).max(axis=1) / np.diff(time)
        assert (speed <= ARM.joint_speed * (1 + 1e-9)).all()
        # both legs are stretched by less than a sample
        assert np.abs(np.diff(position, axis=0)).max(axis=1).sum() / ARM.joint_speed > time[-1] - 2 * STEP


def test_plans_are_raw_and_differ():
    plans = plans_of(scene_of(2), 2)[0]
    assert len(set(plans.duration.tolist())) > 4
    assert plans.row_size[:7].min() >= 3


@pytest.mark.parametrize("planner", PLANNERS)
def test_the_same_seed_gives_the_same_plans_whatever_was_planned_before(planner):
    def plan(seed):
        return digest(sample_plans(ARM, "robot", ARM.home, GOALS, seed=seed, count=2, planner=planner))

    before = plan(1)
    plan(2)
    assert plan(1) == before
    assert plan(3) != before


def test_the_same_seed_gives_the_same_plans_in_another_process():
    code = (
        "import hashlib; from ppsim.arms.geometry import ARMS; from ppsim.arms.plans import sample_plans\n"
        f"plans = sample_plans(ARMS['robot'], 'robot', ARMS['robot'].home, {GOALS}, seed=11)\n"
        "print(hashlib.sha256(plans.time.tobytes() + plans.position.tobytes()).hexdigest())"
    )
    path = os.pathsep.join(sys.path)
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PYTHONPATH": path},
    )
    assert done.stdout.strip() == digest(sample_plans(ARM, "robot", ARM.home, GOALS, seed=11))


def test_a_larger_set_begins_otherwise_the_same_and_committing_leaves_the_others_alone():
    plans = sample_plans(ARM, "robot", ARM.home, GOALS, seed=5)
    rest = rest_of_plan(plans, 2, 1.0, plans.positions(1.0)[2, 0])
    again = sample_plans(ARM, "robot", ARM.home, GOALS, seed=5, committed=rest)
    assert (len(again), again.committed, again.static) == (8, 0, 7)
    for number in range(1, 7):
        assert np.array_equal(waypoints(plans, number)[1], waypoints(again, number)[1])
    assert np.isclose(again.duration[0], plans.duration[2] - 1.0)


def test_the_rest_of_a_plan_is_where_the_plan_would_be():
    plans = sample_plans(ARM, "robot", ARM.home, GOALS, seed=5)
    rest = rest_of_plan(plans, 3, 2.0, plans.positions(2.0)[3, 0])
    again = sample_plans(ARM, "robot", ARM.home, GOALS, seed=6, committed=rest)
    later = np.arange(0.0, 20.0, 0.1)
    assert np.allclose(again.positions(later)[0], plans.positions(later + 2.0)[3], atol=1e-12)


def test_nothing_is_left_of_a_plan_that_has_ended_or_does_not_move():
    plans = sample_plans(ARM, "robot", ARM.home, GOALS, seed=5)
    assert rest_of_plan(plans, 0, float(plans.duration[0]), GOALS[-1]) is None
    assert rest_of_plan(plans, plans.static, 0.8, ARM.home) is None


def test_a_goal_that_is_here_already_takes_no_time_and_one_nearby_a_sample():
    here = sample_plans(ARM, "robot", ARM.home, [ARM.home], seed=0, count=1)
    assert here.duration.tolist() == [0.0, 0.0]
    near = sample_plans(
        ARM, "robot", ARM.home, [np.add(ARM.home, 1e-6)], seed=0, planner="InformedRRTstar", count=1
    )
    assert np.isclose(near.duration[0], STEP)


def test_a_straight_plan_goes_straight():
    plan = straight_plan(ARM, "robot", [0.0, 0.0], [0.5, -0.25])
    assert plan.duration.tolist() == [2.0]
    assert np.allclose(plan.positions(1.0), [[[0.25, -0.125]]])


@pytest.mark.parametrize(
    ("planner", "says"),
    [
        ("RTT", "there is no planner 'RTT'; take one of RRT"),
        ("PRM", "second thread"),
        ("AORRTC", "do not lead"),
    ],
)
def test_planners_that_are_unknown_or_not_repeatable_are_refused_with_the_reason(planner, says):
    with pytest.raises(SimulationError, match=says):
        sample_plans(ARM, "robot", ARM.home, GOALS, seed=0, planner=planner)


def test_goals_beyond_the_limits_are_refused():
    with pytest.raises(SimulationError, match="within the joints' limits"):
        sample_plans(ARM, "robot", ARM.home, [[0.0, 2.8]], seed=0)
    with pytest.raises(SimulationError, match="at least one goal"):
        sample_plans(ARM, "robot", ARM.home, [], seed=0)
    with pytest.raises(SimulationError, match="at least one plan"):
        sample_plans(ARM, "robot", ARM.home, GOALS, seed=0, count=0)


def test_a_planner_that_finds_nothing_says_how_often_it_tried():
    with pytest.raises(SimulationError, match="20 attempts"):
        sample_plans(ARM, "robot", ARM.home, GOALS, seed=0, count=1, planner_range=1e-4)


def test_the_rest_of_a_plan_takes_no_rounding_error_longer_than_a_plan_that_takes_as_long():
    plans = sample_plans(ARM, "robot", ARM.home, GOALS, seed=3)
    for plan in range(7):
        whole = round(plans.duration[plan] / STEP)
        for steps in range(1, whole):
            rest = rest_of_plan(plans, plan, steps * STEP, plans.positions(steps * STEP)[plan, 0])
            assert rest.time[-1] == (whole - steps) * STEP
