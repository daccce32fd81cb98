"""Robots of the reaching game carry out what their choosers decide, and those that keep clear do."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppinfer.goals.choice import ExpectedCost, GoalChooser, GoalDecision, NearestGoal, Switching
from ppinfer.goals.conditional import unmoved_post
from ppsim.errors import SimulationError
from ppsim.reaching import KeepClear, Movement, ReachingWorld, Rules, make_human, make_robot, play
from ppsim.reaching.robots import GOAL_ROBOTS, RobotSeat


def game(robot, human="stubborn", *, seed=0, samples=40, goals=3):
    """Play a robot with a human."""
    world = ReachingWorld(Rules(goals=goals), Movement().dynamics, redraw="picked")
    return play(world, {"human": make_human(human), "robot": robot}, seed=seed, samples=samples)


@dataclass(frozen=True)
class Does(GoalChooser):
    """Decides what it is told to."""

    goal: int | None = 0
    what: str = "decide"

    def choose(self, situation):
        if self.what == "raise":
            raise KeyError("lost")
        if self.what == "other":
            return 3
        score = np.full(len(situation.goals), np.nan if self.what == "nothing" else 0.0)
        decision = GoalDecision(self.goal, score, unmoved_post(situation.belief))
        return decision


@pytest.mark.parametrize("name", GOAL_ROBOTS)
def test_every_robot_plays_the_same_game_again(name):
    first, again = (game(make_robot(name), human="moving", seed=3) for _ in range(2))
    np.testing.assert_array_equal(first.position, again.position)
    assert (first.pursued[:, 1] >= 0).any()


def test_the_joint_robot_takes_its_chance_from_the_game():
    runs = [game(make_robot("joint"), seed=3, samples=4) for _ in range(2)]
    np.testing.assert_array_equal(runs[0].control, runs[1].control)


def test_a_robot_moves_by_lqr_towards_the_goal_and_brakes_where_it_waits():
    movement = Movement()
    for goal in (1, None):
        played = game(RobotSeat(Does(goal)), samples=10)
        target = None if goal is None else played.goals[0, goal]
        state = np.stack([played.position[:, 1], played.velocity[:, 1]], axis=2).reshape(10, 4)
        expected = [movement.control(each, target) for each in state]
        np.testing.assert_allclose(played.control[:, 1], expected, atol=1e-12)
        assert (played.pursued[:, 1] == (-1 if goal is None else goal)).all()


def test_the_first_control_of_a_trajectory_is_carried_out_as_it_is():
    seat = make_robot("joint")
    seat.reset(np.random.default_rng(0))
    world = ReachingWorld(Rules(goals=3), Movement().dynamics)
    action = seat.act(world.reset(2)["robot"])
    np.testing.assert_array_equal(action, seat.decision.candidates.controls[seat.decision.chosen, 0])


def test_what_the_robot_thought_is_kept_for_every_sample_and_the_switching_one_knows_the_rationality():
    seat = make_robot("switching")
    game(seat, human="waiting", samples=20)
    assert isinstance(seat.chooser, Switching)
    assert len(seat.thoughts) == 20
    for thought in seat.thoughts:
        for log_values in (thought.belief, thought.mental_model, thought.post):
            assert np.exp(log_values).sum() == pytest.approx(1.0)


def test_the_post_goals_of_a_robot_that_waits_are_averaged_over_what_the_human_may_take_it_for():
    seat = RobotSeat(Does(None))
    game(seat, samples=12)
    last = seat.thoughts[-1]
    # it expects no reaction, so that the average is its belief
    np.testing.assert_allclose(last.post, last.belief, atol=1e-12)


def test_the_last_goal_is_remembered_until_goals_are_new():
    seen = []

    class Remembers(NearestGoal):
        def choose(self, situation):
            seen.append(situation.previous)
            return super().choose(situation)

    played = game(RobotSeat(Remembers()), human="moving", samples=80)
    first = np.flatnonzero(np.diff(played.drawn, prepend=-1) != 0)
    assert len(first) > 1
    for sample, previous in enumerate(seen):
        assert previous == (None if sample in first else played.pursued[sample - 1, 1])


def test_choosers_of_ones_own_are_shown_the_past():
    seen = []

    class Looks(NearestGoal):
        def choose(self, situation):
            seen.append(situation.robot_history)
            return super().choose(situation)

    played = game(RobotSeat(Looks(), name="tests:Looks"), samples=30)
    np.testing.assert_array_equal(seen[-1][:, [0, 2]], played.position[-20:, 1])


@pytest.mark.parametrize(
    ("chooser", "told"),
    [
        (Does(7), "decided on goal 7; there are 3"),
        (Does(0, "raise"), "raised KeyError: 'lost'"),
        (Does(0, "other"), "returned a int; expected a GoalDecision"),
        (Does(0, "nothing"), "its score of goal 0 is no number"),
    ],
)
def test_a_chooser_that_fails_is_named(chooser, told):
    with pytest.raises(SimulationError, match=f"robot 'mine': {told}"):
        game(RobotSeat(chooser, name="mine"))


def test_who_keeps_clear_is_asked_for_by_name():
    clear = {
        who: [name for name in GOAL_ROBOTS if make_robot(name, keep_clear=who).keep_clear is not None]
        for who in ("proactive", "all", "none")
    }
    assert clear["none"] == []
    assert clear["all"] == list(GOAL_ROBOTS)
    assert clear["proactive"] == [name for name in GOAL_ROBOTS if name not in ("naive", "reactive")]
    with pytest.raises(SimulationError, match="keep_clear must be one of proactive, all, none; got 'some'"):
        make_robot("naive", keep_clear="some")
    with pytest.raises(
        SimulationError, match=r"there are no robots 'wise'; there are naive, .* joint, or module"
    ):
        make_robot("wise")


POINTS = st.tuples(st.floats(-8, 8), st.floats(-8, 8)).map(np.array)


@given(POINTS, POINTS, POINTS, POINTS, POINTS)
def test_the_way_taken_is_clear_of_all_that_the_human_may_do_or_none_looked_at_is(
    robot, human, goal, human_goal, velocity
):
    keep = KeepClear(Movement())
    goals = np.stack([goal, human_goal])
    rest = np.zeros(2)
    target = keep.target(robot, velocity, goal, human, rest, goals, np.array([0.0, 1.0]))
    modes = keep.ways(human, rest, np.stack([human_goal, human]))

    def nearest(targets):
        ways = keep.ways(robot, velocity, targets)
        return np.linalg.norm(ways[:, None] - modes, axis=-1).min(axis=(1, 2))

    straight, taken = nearest(goal[None])[0], nearest(target[None])[0]
    if straight >= keep.distance:
        np.testing.assert_array_equal(target, goal)
    else:
        around = np.concatenate([robot[None], robot + keep._around])
        assert taken >= min(keep.distance, nearest(around).max()) - 1e-9


def test_ways_are_those_of_the_closed_loop():
    movement, keep = Movement(), KeepClear(Movement())
    world_state, target = np.array([1.0, -2.0, 3.0, 0.5]), np.array([4.0, -1.0])
    way = keep.ways(world_state[[0, 2]], world_state[[1, 3]], target[None])[0]
    for at in way:
        world_state = movement.dynamics.step(world_state, movement.control(world_state, target))
        np.testing.assert_allclose(at, world_state[[0, 2]], atol=1e-10)


def test_keeping_clear_prevents_collisions_that_happen_without():
    def collisions(keep):
        seats = [(seed, RobotSeat(ExpectedCost(), keep_clear=keep)) for seed in (1, 6, 11)]
        return sum(int(game(seat, seed=seed, samples=60).collided.sum()) for seed, seat in seats)

    assert collisions(None) == 3
    assert collisions(KeepClear(Movement())) == 0


def test_keeping_clear_out_of_range_is_refused():
    for bad in ({"distance": 0.0}, {"radii": ()}, {"horizon": -1}, {"directions": 0}):
        with pytest.raises(SimulationError, match="of keeping clear must be positive and finite"):
            KeepClear(Movement(), **bad)
