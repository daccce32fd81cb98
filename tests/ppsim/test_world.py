import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppinfer.goals import Dynamics, NoisilyRational
from ppsim.errors import SimulationError
from ppsim.protocol import Seat, World
from ppsim.reaching import Collided, NearestGoal, NoisilyRationalSeat, ReachingWorld, Rules, Scored
from ppsim.reaching.world import goals_reached

DT = 0.1
DOUBLE = Dynamics.double_integrator(DT)
SINGLE = Dynamics.single_integrator(DT)
STILL = {"human": np.zeros(2), "robot": np.zeros(2)}


def steer(world, seen, targets):
    """Move single integrators onto targets in one step."""
    actions = {agent: (targets[agent] - seen[agent].position[agent]) / DT for agent in world.agents}
    return world.step(actions)


@given(st.integers(0, 2**63 - 1), st.integers(2, 6))
def test_reset_is_a_function_of_the_seed_and_keeps_the_distances_of_the_rules(seed, goals):
    rules = Rules(goals=goals)
    first, again = ReachingWorld(rules, DOUBLE).reset(seed), ReachingWorld(rules, DOUBLE).reset(seed)
    seen = first["human"]
    np.testing.assert_array_equal(seen.goals, again["robot"].goals)
    starts = np.array(list(seen.position.values()))
    places = np.vstack([seen.goals, starts])
    assert (np.abs(places) <= rules.extent).all()
    apart = np.linalg.norm(places[:, None] - places, axis=-1)
    assert (apart[:goals, :goals][np.triu_indices(goals, 1)] >= rules.separation).all()
    assert (apart[:goals, goals:] >= rules.clearance).all()
    assert apart[goals, goals + 1] >= rules.clearance
    assert all((velocity == 0).all() for velocity in seen.velocity.values())


def test_a_step_is_the_linear_recursion_of_the_dynamics():
    world = ReachingWorld(Rules(), DOUBLE)
    seen = world.reset(4)
    start = seen["human"].position["human"]
    push = np.array([2.0, -1.0])
    for _ in range(10):
        seen, _ = world.step(STILL | {"human": push})
    elapsed = 10 * DT
    np.testing.assert_allclose(seen["human"].position["human"], start + 0.5 * push * elapsed**2, rtol=1e-12)
    np.testing.assert_allclose(seen["robot"].velocity["human"], push * elapsed, rtol=1e-12)
    assert seen["robot"].time == pytest.approx(elapsed)


def test_an_almost_noiseless_agent_reaches_its_goal_as_the_closed_loop_says():
    world = ReachingWorld(Rules(), DOUBLE)
    agent = NoisilyRational.lqr(DOUBLE, control_weight=3.0, rationality=1e28)
    seat = NoisilyRationalSeat(agent, NearestGoal(yields=False))
    seat.reset(np.random.default_rng(0))
    seen = world.reset(11)
    start, goals = seen["human"].state, seen["human"].goals
    path = []
    for _ in range(120):
        seen, events = world.step(STILL | {"human": seat.act(seen["human"])})
        assert not any(isinstance(event, Scored) for event in events)
        path.append(seen["human"].state)
    goal = DOUBLE.goal_states(goals[seat.goal])
    power = [np.linalg.matrix_power(agent.closed_loop, step) for step in range(1, 121)]
    np.testing.assert_allclose(path, [goal + F @ (start - goal) for F in power], atol=1e-10)
    assert np.linalg.norm(path[-1] - goal) < 1e-2


def test_the_team_scores_when_both_are_at_distinct_goals_and_the_goals_are_drawn_anew():
    world = ReachingWorld(Rules(), SINGLE)
    seen = world.reset(0)
    goals = seen["human"].goals
    seen, events = steer(world, seen, {"human": goals[2], "robot": goals[0] + [0.0, 0.49]})
    assert [event for event in events if isinstance(event, Scored)] == [
        Scored(DT, {"human": 2, "robot": 0}, 2)
    ]
    after = seen["human"]
    assert (after.score, after.drawn) == (2, 1)
    places = np.array(list(after.position.values()))
    assert (np.linalg.norm(after.goals[:, None] - places, axis=-1) >= 2.0).all()


@pytest.mark.parametrize("offset", [[0.0, 0.51], [0.3, 0.0]])
def test_nobody_scores_alone_or_at_the_same_goal(offset):
    world = ReachingWorld(Rules(), SINGLE)
    seen = world.reset(0)
    goals = seen["human"].goals
    away = goals[0] + offset if offset[1] else goals[2] + offset
    seen, events = steer(world, seen, {"human": goals[2], "robot": away})
    assert not any(isinstance(event, Scored) for event in events)
    assert (seen["human"].score, seen["human"].drawn) == (0, 0)
    np.testing.assert_array_equal(seen["human"].goals, goals)


def test_a_collision_is_told_once_per_approach():
    world = ReachingWorld(Rules(), SINGLE)
    seen = world.reset(3)
    told = []
    far, near = np.array([0.0, 5.0]), np.array([0.0, 0.9])
    for place in (far, near, near, far, near):
        seen, events = steer(world, seen, {"human": np.zeros(2), "robot": place})
        told.append(sum(isinstance(event, Collided) for event in events))
    assert told == [0, 1, 0, 0, 1]


def test_agents_see_one_another_but_cannot_change_what_is_there():
    seen = ReachingWorld(Rules(), DOUBLE).reset(1)
    assert set(seen) == set(seen["human"].position) == {"human", "robot"}
    with pytest.raises(ValueError, match="read-only"):
        seen["human"].goals[0] = 0.0


@pytest.mark.parametrize(
    ("actions", "told"),
    [
        ({"human": np.zeros(2)}, "expected an action for each of human, robot; got human"),
        (STILL | {"cat": np.zeros(2)}, "got human, robot, cat"),
        (STILL | {"robot": np.zeros(3)}, "the action of 'robot' must be 2 finite numbers"),
        (STILL | {"robot": np.array([np.nan, 0.0])}, "the action of 'robot' must be 2 finite numbers"),
    ],
)
def test_actions_that_do_not_fit_are_refused(actions, told):
    world = ReachingWorld(Rules(), DOUBLE)
    world.reset(0)
    with pytest.raises(SimulationError, match=told):
        world.step(actions)


def test_a_world_that_was_not_reset_says_so():
    with pytest.raises(SimulationError, match="reset the world"):
        ReachingWorld(Rules(), DOUBLE).step(STILL)


@pytest.mark.parametrize(
    ("rules", "told"),
    [
        ({"goals": 0}, "goals must be at least 1"),
        ({"goals": 60}, "60 goals 3 m apart do not fit"),
        ({"separation": 1.0}, "must exceed twice the pick radius"),
        ({"clearance": 0.5}, "must exceed the pick radius"),
        ({"extent": np.inf}, "extent must be positive and finite"),
    ],
)
def test_rules_that_cannot_be_played_are_refused(rules, told):
    with pytest.raises(SimulationError, match=told):
        Rules(**rules)


def test_a_world_needs_a_goal_for_every_agent():
    with pytest.raises(SimulationError, match="1 goals are too few for 2 agents"):
        ReachingWorld(Rules(goals=1), DOUBLE)


def test_the_goal_reached_is_the_one_within_the_radius():
    goals = np.array([[0.0, 0.0], [4.0, 0.0]])
    np.testing.assert_array_equal(goals_reached(np.array([[0.5, 0.0], [3.4, 0.0]]), goals, 0.5), [0, -1])


def test_the_world_and_its_seats_speak_the_protocol():
    assert isinstance(ReachingWorld(Rules(), DOUBLE), World)
    assert isinstance(NoisilyRationalSeat(NoisilyRational.lqr(DOUBLE), NearestGoal()), Seat)


def test_with_redraw_picked_only_the_picked_goals_are_drawn_anew_apart_from_those_that_stay():
    rules = Rules(goals=4)
    world = ReachingWorld(rules, SINGLE, redraw="picked")
    seen = world.reset(0)
    before = seen["human"].goals
    seen, events = steer(world, seen, {"human": before[2], "robot": before[0]})
    assert any(isinstance(event, Scored) for event in events)
    after = seen["human"]
    np.testing.assert_array_equal(after.goals[[1, 3]], before[[1, 3]])
    assert (after.goals[[0, 2]] != before[[0, 2]]).any(axis=1).all()
    apart = np.linalg.norm(after.goals[:, None] - after.goals, axis=-1)[np.triu_indices(4, 1)]
    assert (apart >= rules.separation).all()
    assert (np.linalg.norm(after.goals[[0, 2], None] - before[[2, 0]], axis=-1) >= rules.clearance).all()


def test_the_kth_draw_of_picked_goals_is_the_same_whenever_it_comes():
    draws = []
    for wait in (0, 7):
        world = ReachingWorld(Rules(goals=3, clearance=0.6), SINGLE, redraw="picked")
        seen = world.reset(6)
        for _ in range(wait):
            seen, _ = world.step(STILL)
        for _ in range(3):
            goals = seen["human"].goals
            seen, _ = steer(world, seen, {"human": goals[2], "robot": goals[0]})
        draws.append(seen["human"].goals)
    np.testing.assert_array_equal(*draws)


def test_another_way_of_drawing_anew_is_refused():
    with pytest.raises(SimulationError, match="redraw must be one of all, picked; got 'none'"):
        ReachingWorld(Rules(), SINGLE, redraw="none")
