from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

from ppinfer.errors import SafetyError
from ppinfer.safety import (
    LinearAgent,
    StaticObstacle,
    candidate_trajectories,
    coverage_factor,
    potential_field_control,
    uncertainty_growth,
)
from ppinfer.safety.candidates import draw_obstacles

from .literal import printed_push, traj_gen
from .worlds import at, double_integrator, heading, oncoming, single_integrator


@pytest.mark.parametrize("growth", ["sqrt", "closed-loop"])
@pytest.mark.parametrize("coverage", ["sigma", "instant", "union"])
@pytest.mark.parametrize("limit", [None, 6.0])
def test_with_the_same_obstacles_candidates_are_those_of_the_literal_algorithm(growth, coverage, limit):
    robot, state, target = double_integrator(limit=limit), at(-2, 0.3), at(5, 0)
    others = [
        heading(double_integrator(0.2), at(4, 0), [at(-5, 0), at(0, 5), at(2, 2)], [0.6, 0.36, 0.04]),
        heading(single_integrator(0.1), [0.0, -6.0], [[0.0, 6.0]], [1.0]),
    ]  # fmt: skip
    made = candidate_trajectories(
        robot, state, target, others, obstacles=20, horizon=12, growth=growth, coverage=coverage,
        rng=np.random.default_rng(1),
    )  # fmt: skip
    obstacles = draw_obstacles(state[[0, 2]], target[[0, 2]], 20, 2.0, 1.0, np.random.default_rng(1))
    kappa = {"sigma": 1.0, "instant": np.sqrt(-2 * np.log(0.05)), "union": np.sqrt(-2 * np.log(0.05 / 12))}

    def radius(agent):
        if growth == "sqrt":
            return kappa[coverage] * 0.1 * np.sqrt(np.arange(13))
        covariance, grown = np.zeros_like(agent.A), [0.0]
        for _ in range(12):
            covariance = agent.closed_loop @ covariance @ agent.closed_loop.T + agent.noise
            index = list(agent.position_index)
            grown.append(np.sqrt(np.linalg.eigvalsh(covariance[np.ix_(index, index)])[-1]))
        return kappa[coverage] * np.array(grown)

    X, U, s, smallest = traj_gen(
        robot, state, target, others, obstacles, 12, 1.0, radius, gamma=10.0, clip=0.5
    )
    assert_allclose(made.states, X, rtol=1e-9, atol=1e-9)
    assert_allclose(made.controls, U, rtol=1e-9, atol=1e-9)
    assert_allclose(made.smallest_distance, smallest, rtol=1e-9)
    assert_array_equal(made.safe, s)
    assert_array_equal(made.positions, made.states[..., [0, 2]])


def test_obstacles_lie_evenly_in_a_disc_and_not_near_the_goal():
    rng = np.random.default_rng(0)
    centre, goal = np.array([1.0, 2.0]), np.array([2.0, 2.0])
    points = draw_obstacles(centre, goal, 20_000, 2.0, 1.0, rng)
    assert len(points) == 20_000
    length = np.linalg.norm(points - centre, axis=1)
    assert length.max() <= 2.0
    assert np.linalg.norm(points - goal, axis=1).min() >= 1.0
    # the half of the disc away from the goal is whole: squared distances there are uniform
    behind = length[points[:, 0] < 1.0]
    assert stats.kstest(behind**2 / 4.0, "uniform").pvalue > 1e-3


def test_where_there_is_no_room_there_are_fewer_candidates():
    robot = double_integrator()
    made = candidate_trajectories(
        robot, at(0, 0), at(0.1, 0), [], goal_clearance=5.0, rng=np.random.default_rng(0)
    )
    assert len(made) == 1
    assert made.safe.all()


def test_without_anything_in_the_way_the_first_candidate_is_the_pursuit():
    robot = double_integrator()
    made = candidate_trajectories(robot, at(-5, 0), at(5, 0), [], rng=np.random.default_rng(0))
    x = at(-5, 0)
    for t in range(20):
        x = at(5, 0) + robot.closed_loop @ (x - at(5, 0))
        assert_allclose(made.states[0, t + 1], x, atol=1e-9)
    assert np.ptp(made.states[:, 5, 2]) > 1.0


def test_the_pursuit_that_nothing_pushes_is_one_more_candidate_if_wanted():
    robot, given = double_integrator(), {"rng": np.random.default_rng(0)}
    human = oncoming(0.1)
    made = candidate_trajectories(robot, at(0, 0), at(5, 0), [human], obstacles=3, pursuit=True, **given)
    alone = candidate_trajectories(robot, at(0, 0), at(5, 0), [], obstacles=0, **given)
    assert len(made) == 5
    assert_allclose(made.states[4], alone.states[0])
    assert np.abs(made.states[0] - alone.states[0]).max() > 0.1


def test_unlikely_modes_are_left_out():
    robot = double_integrator()

    def with_probability(p):
        human = heading(double_integrator(), at(5, 0), [at(-5, 0), at(9, 0)], [p, 1 - p])
        return candidate_trajectories(
            robot, at(-5, 0), at(5, 0), [human], obstacles=0, rng=np.random.default_rng(0)
        )

    assert with_probability(0.05).safe[0]
    assert not with_probability(0.06).safe[0]


def test_where_no_candidate_is_safe_the_one_farthest_from_all_is_taken_and_flagged():
    robot = double_integrator()
    human = heading(double_integrator(), at(1.2, 0), [at(-5, 0)], [1.0])
    made = candidate_trajectories(robot, at(0, 0), at(5, 0), [human], sigma=3.0, rng=np.random.default_rng(0))
    assert not made.safe.any()
    chosen, flagged = made.choose(np.arange(len(made), dtype=float))
    assert flagged
    assert made.smallest_distance[chosen] == made.smallest_distance.max()


def test_the_cheapest_safe_candidate_is_taken():
    made = candidate_trajectories(
        double_integrator(),
        at(-5, -1.5),
        at(5, -1.5),
        [oncoming(0.1, (1.0, 0.0))],
        rng=np.random.default_rng(0),
    )
    assert made.safe.any()
    assert not made.safe.all()
    costs = np.arange(len(made), dtype=float)
    assert made.choose(costs) == (int(np.flatnonzero(made.safe)[0]), False)


def test_what_stands_still_pushes_and_must_be_kept_clear_of():
    robot, rng = double_integrator(), np.random.default_rng(0)
    static = [StaticObstacle([0.0, 0.1], 0.8)]
    made = candidate_trajectories(robot, at(-5, 0), at(5, 0), [], static=static, rng=rng)
    apart = np.linalg.norm(made.positions - [0.0, 0.1], axis=2)
    assert_array_equal(made.safe, (apart > 0.8).all(axis=1))
    assert made.states[0, :, 2].min() < -0.05


def test_a_push_repels_where_the_printed_one_attracts():
    here, there = np.array([1.0, 0.0]), np.array([3.0, 0.0])
    ours, printed = potential_field_control(here, there), printed_push(here, there, 10.0)
    assert_allclose(ours, [-5.0, 0.0])
    assert_allclose(printed, -ours)
    # nearer than the clip it falls to nothing, and stays finite
    assert_allclose(potential_field_control(here, here), 0.0)
    assert_allclose(np.linalg.norm(potential_field_control(here, np.array([1.1, 0.0]))), 10.0 / 0.25 * 0.1)


def test_kappa_covers_what_it_says():
    assert_allclose(coverage_factor("instant", eps=0.05, horizon=20), np.sqrt(-2 * np.log(0.05)))
    assert_allclose(coverage_factor("union", eps=0.05, horizon=20), np.sqrt(-2 * np.log(0.05 / 20)))
    assert_allclose(stats.chi2.cdf(coverage_factor("sigma", eps=0.05, horizon=20) ** 2, 2), 0.39, atol=0.005)
    assert_allclose(coverage_factor("instant", eps=0.05, horizon=9, space=1), stats.norm.ppf(0.975))
    for space in (1, 2, 3):
        kappa = coverage_factor("instant", eps=0.1, horizon=5, space=space)
        assert_allclose(stats.chi2.cdf(kappa**2, space), 0.9)


def test_the_union_over_the_horizon_covers_whole_futures():
    from ppinfer.safety import draw_rollouts, nominal_motion

    human = heading(double_integrator(0.3), at(5, 0), [at(-5, 0)], [1.0])
    drawn = draw_rollouts([human], 20, 20_000, np.random.default_rng(0)).positions[0]
    nominal = nominal_motion(human.agent, human.state[None], human.targets, 20)[0][0][:, [0, 2]]
    apart = np.linalg.norm(drawn - nominal[..., None], axis=1)
    spread = uncertainty_growth(human.agent, 20, growth="closed-loop")
    share = {
        coverage: (apart <= coverage_factor(coverage, eps=0.05, horizon=20) * spread[:, None] + 1e-12)
        for coverage in ("instant", "union")
    }
    # a disturbance of the velocity moves the position one step later
    assert_allclose(share["instant"][2:].mean(axis=1), 0.95, atol=0.01)
    assert share["instant"].all(axis=0).mean() < 0.9
    assert share["union"].all(axis=0).mean() >= 0.95


def test_the_printed_growth_has_no_bound_and_that_of_the_closed_loop_has_one():
    agent = double_integrator(0.1)
    printed = uncertainty_growth(agent, 400)
    assert_allclose(printed, 0.1 * np.sqrt(np.arange(401)))
    grown = uncertainty_growth(agent, 400, growth="closed-loop")
    assert (np.diff(grown) >= -1e-12).all()
    assert grown[400] - grown[200] < 1e-6
    assert_allclose(uncertainty_growth(double_integrator(), 5, growth="closed-loop"), 0.0)


def test_what_does_not_fit_is_refused():
    rng, robot = np.random.default_rng(0), double_integrator()
    wide = LinearAgent(np.eye(4), np.ones((4, 3)), np.ones((3, 4)), (0, 2))
    with pytest.raises(SafetyError, match="one control for each dimension"):
        candidate_trajectories(wide, at(0, 0), at(1, 0), [], rng=rng)
    with pytest.raises(SafetyError, match="must have 4 entries"):
        candidate_trajectories(robot, np.zeros(2), np.zeros(2), [], rng=rng)
    with pytest.raises(SafetyError, match="clip and radius positive"):
        candidate_trajectories(robot, at(0, 0), at(1, 0), [], clip=0.0, rng=rng)
    with pytest.raises(SafetyError, match="clip must be positive"):
        potential_field_control(np.zeros(2), np.ones(2), clip=0.0)
    with pytest.raises(SafetyError, match="horizon must be at least 1"):
        uncertainty_growth(robot, 0)
    with pytest.raises(SafetyError, match=r"eps must lie in \(0, 1\)"):
        coverage_factor("union", eps=1.0, horizon=3)
    line = heading(single_integrator(space=3), [0, 0, 0], [[1, 0, 0]], [1.0])
    with pytest.raises(SafetyError, match="the robot moves in 2 dimensions"):
        candidate_trajectories(robot, at(0, 0), at(1, 0), [line], rng=rng)
