"""What is drawn for the arms to do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ppsim.arms.contacts import clearance_between
from ppsim.arms.geometry import ARMS, Arm
from ppsim.arms.scene import Scene
from ppsim.errors import SimulationError

from .situations import scene_of


@pytest.mark.parametrize("seed", range(40))
def test_picks_and_places_are_where_the_study_wants_them(seed):
    scene = scene_of(seed)
    for agent, ahead in (("robot", 1.0), ("human", -1.0)):
        task, arm = scene.tasks[agent], scene.arms[agent]
        assert abs(task.pick[0]) <= 0.3
        assert 0.1 <= ahead * task.place[0] <= 0.4
        for point, ways in ((task.pick, task.pick_joints), (task.place, task.place_joints)):
            assert abs(point[1]) <= 0.5
            assert 0.3 <= np.linalg.norm(point - arm.base) <= 0.95
            assert len(ways) == 2
            assert arm.within_limits(ways).all()
            assert np.allclose(arm.end_effector(ways), point, atol=1e-9)
        assert np.linalg.norm(task.pick - task.place) > 0.3


def test_a_scene_is_its_seed():
    assert np.array_equal(scene_of(3).tasks["human"].place, scene_of(3).tasks["human"].place)
    assert not np.array_equal(scene_of(3).tasks["human"].place, scene_of(4).tasks["human"].place)


def test_arms_at_home_are_well_apart():
    robot, human = ARMS["robot"], ARMS["human"]
    assert clearance_between([robot, human], robot.home, human.home) > 0.5


def test_a_task_without_its_pick_has_one_goal_left():
    task = scene_of(0).tasks["robot"]
    assert [len(task.goals()), len(task.goals(holding=True))] == [2, 1]
    assert task.goals(holding=True)[0] is task.place_joints


def test_joint_angles_that_lead_elsewhere_are_refused():
    scene = scene_of(0)
    task = scene.tasks["robot"]
    wrong = replace(task, pick_joints=task.pick_joints + 0.1)
    with pytest.raises(SimulationError, match="robot's pick"):
        Scene(dict(scene.tasks) | {"robot": wrong}, scene.arms)


def test_agents_of_tasks_and_arms_must_be_the_same():
    scene = scene_of(0)
    with pytest.raises(SimulationError, match="tasks for robot, human and arms for robot"):
        Scene(scene.tasks, {"robot": scene.arms["robot"]})


def test_an_arm_that_reaches_nothing_is_refused_after_some_draws():
    with pytest.raises(SimulationError, match="no pick and place within reach of 'far'"):
        Scene.random(np.random.default_rng(0), {"far": Arm(base=(5.0, 0.0))})
