"""The physical world of the arms, and how it agrees with the kinematic model that plans are judged by."""

from __future__ import annotations

import numpy as np
import pytest

from ppinfer.coordination import Selfish
from ppsim.arms.contacts import clearance_between, contact_tables
from ppsim.arms.playing import play
from ppsim.arms.world import ArmsWorld, Touched
from ppsim.errors import SimulationError
from ppsim.protocol import World

from .situations import plans_of, scene_of

#: Within this the shapes of the physical world are where the kinematic model has them, m.
TOLERANCE = 1e-5


def courses(scene, seed, profile, seconds):
    """Return where each arm is to be every 0.1 s."""
    times = np.arange(1, round(seconds / 0.1) + 1) * 0.1
    sets = plans_of(scene, seed)
    return {own.agent: own.positions(times)[number] for own, number in zip(sets, profile, strict=True)}


def arms_of(scene):
    return [scene.arms[agent] for agent in scene.agents]


def test_it_speaks_the_protocol_and_a_seed_draws_its_scene():
    world = ArmsWorld()
    assert isinstance(world, World)
    assert world.agents == ("robot", "human")
    seen = world.reset(3)
    assert seen["human"].position["robot"].tolist() == pytest.approx(world.scene.arms["robot"].home)
    again = ArmsWorld()
    again.reset(3)
    assert np.array_equal(again.scene.tasks["robot"].pick, world.scene.tasks["robot"].pick)
    seen, events = world.step({agent: world.scene.arms[agent].home for agent in world.agents})
    assert seen["robot"].time == pytest.approx(0.1)
    assert events == ()


@pytest.mark.parametrize("seed", range(6))
def test_motors_track_plans_to_a_ten_thousandth_of_a_radian(seed):
    scene = scene_of(seed)
    course = courses(scene, seed, (0, 0), 15.0)
    apart = clearance_between(arms_of(scene), *course.values())
    world = ArmsWorld(scene)
    for step in range(np.flatnonzero(np.append(apart, 0.0) < 0.01)[0]):
        world.step({agent: poses[step] for agent, poses in course.items()})
        for agent, poses in course.items():
            assert np.abs(world.position(agent) - poses[step]).max() < 1e-4
            tip = scene.arms[agent].end_effector(poses[step])
            assert np.abs(world.end_effector(agent) - tip).max() < TOLERANCE
    assert world.contacts == 0


def test_velocities_are_those_of_the_plan_within_an_edge_and_nothing_while_it_holds():
    world = ArmsWorld(scene_of(0))
    rate = np.array([0.2, -0.1])
    home = {agent: world.position(agent) for agent in world.agents}
    for step in range(1, 6):
        world.step({"robot": home["robot"] + rate * step * 0.1, "human": home["human"]})
    assert np.allclose(world.velocity("robot"), rate, atol=1e-6)
    here = world.position("robot")
    world.hold()
    assert np.allclose(world.velocity("robot"), 0.0, atol=1e-9)
    assert np.allclose(world.position("robot"), here, atol=1e-9)
    assert world.time == pytest.approx(0.6)


def test_no_joint_turns_much_faster_than_it_may():
    world = ArmsWorld(scene_of(0))
    home = {agent: world.position(agent) for agent in world.agents}
    for _ in range(4):
        world.step({"robot": home["robot"] + 1.0, "human": home["human"]})
    assert np.abs(world.position("robot") - home["robot"]).max() <= 0.4 * 0.25 * 1.25 + 1e-9


@pytest.mark.parametrize("seed", range(8))
def test_arms_first_touch_in_the_step_that_the_table_says(seed):
    """The kinematic table and the physical world, held together: without a safety stop arms run into each other.

    Shapes and capsules agree within `TOLERANCE`, so the first contact comes in the 0.1 s that end at the table's time.
    Only where arms graze, within a millimetre at one of the instants that the table looks at, may the two differ.
    """
    scene = scene_of(seed)
    sets = plans_of(scene, seed)
    collision, _ = contact_tables(arms_of(scene), sets)
    for profile in ((0, 0), (2, 5), (7, 3)):
        ends = [
            np.inf if own.static == number else own.duration[number]
            for own, number in zip(sets, profile, strict=True)
        ]
        course = courses(scene, seed, profile, min(ends))
        apart = clearance_between(arms_of(scene), *course.values())
        world = ArmsWorld(scene)
        touched = np.inf
        for step in range(len(apart)):
            _, events = world.step({agent: poses[step] for agent, poses in course.items()})
            if events:
                assert isinstance(events[0], Touched)
                touched = events[0].time
                break
            assert abs(world.clearance() - apart[step]) < TOLERANCE
        if not np.isclose(touched, collision[profile]) and touched != collision[profile]:
            near = round(min(touched, collision[profile]) / 0.1) - 1
            assert apart[max(0, near - 1) : near + 2].min() < 1e-3


def test_safety_stops_keep_arms_from_touching():
    played = [
        play(scene_of(seed), {"robot": Selfish(), "human": Selfish()}, seed=seed, plan_sets="independent")
        for seed in range(20)
    ]
    assert sum(one.stops for one in played) > 20
    assert [one.contacts for one in played] == [0] * 20


def test_would_collide_is_where_the_capsules_overlap():
    scene = scene_of(0)
    world = ArmsWorld(scene)
    rng = np.random.default_rng(0)
    poses = rng.uniform([-1.2, -2.5], [1.2, 2.5], (2, 400, 2))
    apart = clearance_between(arms_of(scene), *poses)
    found = [world.would_collide(dict(zip(scene.agents, pair, strict=True))) for pair in poses.swapaxes(0, 1)]
    clear = np.abs(apart) > 1e-4
    assert np.array_equal(np.array(found)[clear], apart[clear] <= 0.0)
    assert 50 < sum(found) < 350
    # trying poses moves nothing
    assert np.allclose(world.position("robot"), scene.arms["robot"].home)


def test_clearance_is_negative_where_arms_cross():
    world = ArmsWorld(scene_of(0))
    apart = world.clearance()
    assert apart == pytest.approx(
        float(clearance_between(arms_of(world.scene), *[world.position(a) for a in world.agents])), abs=1e-6
    )


def reach(world, agent, goal):
    """Move an arm straight to a configuration while the others stay."""
    here = {other: world.position(other) for other in world.active}
    start = here[agent]
    steps = int(np.ceil(np.abs(goal - start).max() / 0.025))
    for step in range(1, steps + 1):
        world.step(here | {agent: start + (goal - start) * step / steps})


def test_an_object_is_carried_from_pick_to_place_and_stays_when_the_arm_has_gone():
    scene = scene_of(1)
    world = ArmsWorld(scene)
    task = scene.tasks["robot"]
    world.remove("human")
    assert world.active == ("robot",)
    assert world.clearance() == np.inf
    with pytest.raises(SimulationError, match=r"cannot grasp: its object is .* m away"):
        world.grasp("robot")
    reach(world, "robot", task.pick_joints[0])
    world.grasp("robot")
    assert world.holding == {"robot"}
    with pytest.raises(SimulationError, match="held already"):
        world.grasp("robot")
    reach(world, "robot", task.place_joints[1])
    world.hold()
    assert np.abs(world.object_position("robot") - task.place).max() < 1e-3
    world.remove("robot")
    assert world.active == ()
    assert not world.would_collide({})
    assert np.abs(world.object_position("robot") - task.place).max() < 1e-3


def test_two_worlds_told_the_same_do_the_same():
    scene = scene_of(4)
    course = courses(scene, 4, (1, 1), 3.0)
    states = []
    for _ in range(2):
        world = ArmsWorld(scene)
        for step in range(30):
            world.step({agent: poses[step] for agent, poses in course.items()})
        states.append(np.concatenate([world.position(agent) for agent in world.agents]))
    assert np.array_equal(*states)


def test_what_nobody_understands_is_refused():
    world = ArmsWorld()
    with pytest.raises(SimulationError, match="reset the world"):
        world.step({})
    world.reset(0)
    with pytest.raises(SimulationError, match="expected joint angles for robot, human; got them for robot"):
        world.step({"robot": [0.0, 0.0]})
    with pytest.raises(SimulationError, match="2 finite numbers"):
        world.step({"robot": [0.0, np.nan], "human": [0.0, 0.0]})
    world.remove("human")
    with pytest.raises(SimulationError, match="'human' has left the table"):
        world.position("human")
    with pytest.raises(SimulationError, match="no agent 'cat'"):
        world.object_position("cat")
