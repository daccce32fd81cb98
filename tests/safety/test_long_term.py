from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

from ppinfer.errors import SafetyError
from ppinfer.safety import (
    Body,
    LinearAgent,
    StaticObstacle,
    body_gap,
    draw_rollouts,
    long_term_safe_probability,
    nominal_motion,
    plan_safe_probability,
)
from ppinfer.safety.rollouts import roll_robot

from .literal import long_term_safe_prob
from .worlds import at, double_integrator, heading, oncoming, single_integrator


def literal_count(robot, state, target, others, *, distance, horizon, rollouts, static, seed):
    """Return how many rollouts are safe by the literal algorithm, with the chance that the array program draws."""
    rng = np.random.default_rng(seed)
    robot_noise = None
    if robot.noise is not None:
        _, robot_noise = roll_robot(robot, state, target, horizon, rollouts, rng)
    drawn = draw_rollouts(others, horizon, rollouts, rng)
    d_min = np.broadcast_to(distance, len(others))
    F = long_term_safe_prob(
        robot, state, target, others, d_min, horizon, drawn.mode, drawn.noise, robot_noise, static
    )
    return int(F.sum())


SCENES = {
    "one other": (double_integrator(), [oncoming()], 1.0, ()),
    "two others, each with a distance": (
        double_integrator(),
        [oncoming(), heading(single_integrator(0.2), [0, 4], [[0, -4], [3, 0]], [0.5, 0.5])],
        [1.0, 0.4],
        (),
    ),
    "control limits": (
        double_integrator(limit=3.0),
        [heading(double_integrator(0.5, limit=4.0), at(5, 0), [at(-5, 1), at(0, 5)], [0.7, 0.3])],
        1.0,
        (),
    ),
    "a robot with noise and something that stands still": (
        double_integrator(0.3), [oncoming()], 0.6, (StaticObstacle([1.0, 0.6], 0.5),)
    ),
    "a robot with noise and control limits": (
        double_integrator(0.3, limit=5.0), [oncoming()], 0.6, (StaticObstacle([1.0, 0.6], 0.5),)
    ),
}  # fmt: skip


@pytest.mark.parametrize("scene", SCENES)
def test_with_the_same_chance_the_array_program_counts_what_the_literal_algorithm_counts(scene):
    robot, others, distance, static = SCENES[scene]
    given = {"distance": distance, "horizon": 15, "rollouts": 150, "static": static}
    found = long_term_safe_probability(
        robot, at(-5, 0.5), at(5, 0.5), others, rng=np.random.default_rng(7), **given
    )
    expected = literal_count(robot, at(-5, 0.5), at(5, 0.5), others, seed=7, **given)
    assert found.safe == expected
    assert 0 < expected < 150


@pytest.mark.parametrize("space", [1, 3])
def test_any_dimension_will_do(space):
    robot, walker = single_integrator(space=space), single_integrator(0.2, space=space)
    other = heading(walker, np.full(space, 3.0), [np.full(space, -3.0), np.full(space, 4.0)], [0.3, 0.7])
    given = {"distance": 0.7, "horizon": 12, "rollouts": 150, "static": ()}
    found = long_term_safe_probability(
        robot, np.full(space, -3.0), np.full(space, 1.0), [other], rng=np.random.default_rng(3), **given
    )
    assert found.safe == literal_count(
        robot, np.full(space, -3.0), np.full(space, 1.0), [other], seed=3, **given
    )


def test_a_plan_is_counted_as_the_pursuit_that_it_is():
    robot, others = double_integrator(), [oncoming()]
    plan = robot.position(nominal_motion(robot, at(-5, 0)[None], at(5, 0)[None], 50)[0])
    aside = plan + np.array([0.0, 1.2])
    once = plan_safe_probability(
        np.concatenate([plan, aside, plan, aside, aside]), others, rng=np.random.default_rng(1)
    )
    alone = long_term_safe_probability(robot, at(-5, 0), at(5, 0), others, rng=np.random.default_rng(1))
    assert once[0] == once[2] == alone
    assert once[1] == once[3] == once[4]
    assert once[1].safe > alone.safe


def test_every_candidate_is_counted_as_if_it_were_alone():
    rng = np.random.default_rng(0)
    others = [oncoming(), heading(single_integrator(0.2), [0, 4], [[0, -4], [3, 0]], [0.5, 0.5])]
    plans = rng.uniform(-5, 5, (40, 1, 2)) + rng.normal(0, 0.3, (40, 21, 2)).cumsum(axis=1)
    shared = draw_rollouts(others, 20, 300, rng)
    static = [StaticObstacle([3.0, 3.0], 1.0)]
    # where few are looked at none is passed over by its box
    alone = [plan_safe_probability(plan[None], shared, static=static, rng=rng).safe[0] for plan in plans]
    assert_array_equal(plan_safe_probability(plans, shared, static=static, rng=rng).safe, alone)
    distance = np.linalg.norm(plans[:, None, :, :, None] - shared.positions, axis=3)
    clear = (distance >= 1.0).all(axis=(1, 2)) & (np.linalg.norm(plans - [3.0, 3.0], axis=2) >= 1.0).all(
        axis=1
    )[:, None]
    assert_array_equal(alone, clear.sum(axis=1))
    assert len(set(alone)) > 5


def survival(start, target_gap, keep, spread, distance, horizon):
    """Return P(r_t >= distance, t = 0..H) of r' = keep r + (1 - keep) target_gap + N(0, spread^2), r_0 = start.

    The density of r and of having stayed clear, step by step, by Gauss-Legendre quadrature.
    """
    nodes, weights = np.polynomial.legendre.leggauss(400)
    low, high = distance, distance + 12.0
    x = 0.5 * (high - low) * (nodes + 1) + low
    w = 0.5 * (high - low) * weights
    drift = (1 - keep) * target_gap
    density = stats.norm.pdf(x, keep * start + drift, spread)
    kernel = stats.norm.pdf(x[:, None], keep * x + drift, spread)
    for _ in range(horizon - 1):
        density = kernel @ (w * density)
    return float(w @ density)


@pytest.mark.parametrize(
    ("start", "gap", "robot_noise"), [(2.5, 1.2, 0.0), (3.0, 0.9, 0.1), (1.5, 2.0, 0.05)]
)
def test_the_probability_is_that_of_quadrature_where_the_gap_is_a_gaussian_process(start, gap, robot_noise):
    # two agents on a line with one gain: their gap is a linear recursion of its own
    robot = single_integrator(robot_noise, space=1)
    human = heading(single_integrator(0.15, space=1), [start], [[1.0 + gap]], [1.0])
    n, horizon, distance = 200_000, 30, 1.0
    found = long_term_safe_probability(
        robot, np.zeros(1), np.ones(1), [human], distance=distance, horizon=horizon, rollouts=n,
        rng=np.random.default_rng(2),
    )  # fmt: skip
    exact = survival(start, gap, 0.9, np.hypot(0.15, robot_noise), distance, horizon)
    assert 0.02 < exact < 0.98
    # a chance of 6e-5 to be farther off
    assert abs(found.estimate - exact) <= 4 * np.sqrt(exact * (1 - exact) / n)
    assert found.lower() <= exact + 1e-3


def test_a_mixture_of_modes_weighs_the_probability_of_each():
    walker = single_integrator(0.15, space=1)
    human = heading(walker, [3.0], [[0.9], [2.2]], [0.3, 0.7])
    n, still = 200_000, LinearAgent(np.eye(1), np.eye(1), np.eye(1), (0,))
    found = long_term_safe_probability(
        still, np.zeros(1), np.zeros(1), [human], horizon=30, rollouts=n, rng=np.random.default_rng(5)
    )
    exact = 0.3 * survival(3.0, 0.9, 0.9, 0.15, 1.0, 30) + 0.7 * survival(3.0, 2.2, 0.9, 0.15, 1.0, 30)
    assert abs(found.estimate - exact) <= 4 * np.sqrt(exact * (1 - exact) / n)


def test_a_larger_run_with_another_generator_says_the_same():
    # no recursion is shared: positions are sums of all disturbances so far, drawn by quasi-Monte-Carlo
    human, robot, horizon = oncoming(0.3, (1.0, 0.0)), double_integrator(), 20
    sobol = stats.qmc.Sobol(2 * horizon, rng=np.random.default_rng(4)).random_base2(17)
    drawn = stats.norm.ppf(sobol).reshape(-1, horizon, 2) * 0.3
    powers = [np.linalg.matrix_power(human.agent.closed_loop, k) for k in range(horizon + 1)]
    plan = robot.position(nominal_motion(robot, at(-5, 0.9)[None], at(5, 0.9)[None], horizon)[0])[0]
    clear = np.ones(len(drawn), dtype=bool)
    for t in range(horizon + 1):
        mean = human.targets[0] + powers[t] @ (human.state - human.targets[0])
        where = human.agent.position(mean)[None] + sum(
            drawn[:, s] @ powers[t - 1 - s][np.ix_([0, 2], [1, 3])].T for s in range(t)
        )
        clear &= np.linalg.norm(where - plan[t], axis=1) >= 1.0
    found = long_term_safe_probability(
        robot, at(-5, 0.9), at(5, 0.9), [human], horizon=horizon, rollouts=100_000,
        rng=np.random.default_rng(6),
    )  # fmt: skip
    # the larger run's own error is no more than that of independent draws
    error = np.sqrt(0.25 * (1 / 100_000 + 1 / len(drawn)))
    assert 0.1 < clear.mean() < 0.9
    assert abs(found.estimate - clear.mean()) <= 4 * error


def test_rollouts_have_the_mean_the_covariance_and_the_shares_of_modes_that_the_model_says():
    agent = double_integrator(0.4)
    others = [oncoming(0.4, (0.25, 0.75)), oncoming(0.4, (0.5, 0.5))]
    n = 60_000
    drawn = draw_rollouts(others, 12, n, np.random.default_rng(8))
    assert abs((drawn.mode[0] == 0).mean() - 0.25) < 4 * np.sqrt(0.25 * 0.75 / n)
    # listing rollouts by the first agent's mode says nothing of the second's
    second = [(drawn.mode[1][drawn.mode[0] == mode] == 0).mean() for mode in range(2)]
    assert abs(second[0] - second[1]) < 4 * 0.5 * np.sqrt(1 / (0.25 * n) + 1 / (0.75 * n))
    covariance = np.zeros((4, 4))
    for _ in range(12):
        covariance = agent.closed_loop @ covariance @ agent.closed_loop.T + agent.noise
    mine = drawn.positions[0, -1][:, drawn.mode[0] == 1]
    target = others[0].targets[1]
    mean = target + np.linalg.matrix_power(agent.closed_loop, 12) @ (others[0].state - target)
    spread = np.sqrt(covariance[0, 0])
    assert_allclose(mine.mean(axis=1), mean[[0, 2]], atol=5 * spread / np.sqrt(mine.shape[1]))
    assert_allclose(np.cov(mine), covariance[np.ix_([0, 2], [0, 2])], atol=0.03 * spread**2)
    assert stats.kstest((mine[0] - mean[0]) / spread, "norm").pvalue > 1e-4


def test_a_mode_without_probability_is_never_drawn():
    other = heading(single_integrator(0.1), [0, 0], [[1, 0], [2, 0], [3, 0]], [0.0, 1.0, 0.0])
    assert set(draw_rollouts([other], 2, 5000, np.random.default_rng(0)).mode[0].tolist()) == {1}


def test_the_start_counts_and_so_does_the_end():
    still = single_integrator()
    near, far = (
        heading(still, [0.5, 0.0], [[3.0, 0.0]], [1.0]),
        heading(still, [9.0, 0.0], [[0.0, 0.0]], [1.0]),
    )
    rng = np.random.default_rng(0)
    plan = np.zeros((1, 11, 2))
    assert plan_safe_probability(plan, [near], rng=rng).safe[0] == 0
    # at the eleventh instant the other is 9 * .9 ** 10 = 3.14 m away
    assert plan_safe_probability(plan, [far], distance=3.1, rng=rng).safe[0] == 1000
    assert plan_safe_probability(plan, [far], distance=3.2, rng=rng).safe[0] == 0


def test_nobody_and_nothing_in_the_way_is_safe():
    robot, rng = double_integrator(), np.random.default_rng(0)
    assert long_term_safe_probability(robot, at(0, 0), at(1, 0), [], rng=rng).safe == 1000
    static = [StaticObstacle([0.5, 0.0], 0.2)]
    assert long_term_safe_probability(robot, at(0, 0), at(1, 0), [], static=static, rng=rng).safe == 0


def test_bodies_are_as_far_apart_as_their_surfaces():
    rng = np.random.default_rng(9)
    others = [oncoming(0.3), heading(single_integrator(0.2), [0, 2], [[0, -4]], [1.0])]
    shared = draw_rollouts(others, 10, 60, rng)
    plans = rng.uniform(-2, 4, (6, 1, 2)) + 0.1 * rng.normal(size=(6, 11, 2)).cumsum(axis=1)
    own = Body([[0.0, -0.4], [0.0, 0.0]], [[0.0, 0.4], [0.7, 0.0]], [0.1, 0.05])
    its = Body([[-0.3, 0.0]], [[0.3, 0.2]], [0.2])
    static = [StaticObstacle([2.0, 2.0], 0.3)]
    found = plan_safe_probability(
        plans, shared, distance=[0.2, 0.5], static=static, body=own, bodies=[its, None], rng=rng
    )
    clear = np.ones((6, 60), dtype=bool)
    for other, body, least in ((0, its, 0.2), (1, Body.point(2), 0.5)):
        where = np.moveaxis(shared.positions[other], 1, 2)
        clear &= (body_gap(own, plans[:, :, None], body, where) >= least).all(axis=1)
    gap = body_gap(own, plans, Body.point(2), np.array([2.0, 2.0]))
    clear &= (gap >= 0.3).all(axis=1)[:, None]
    assert_array_equal(found.safe, clear.sum(axis=1))
    assert 0 < found.safe.sum() < clear.size


def test_bodies_that_are_points_change_nothing():
    rng = np.random.default_rng(9)
    shared = draw_rollouts([oncoming()], 20, 300, rng)
    plans = rng.uniform(-4, 4, (8, 1, 2)) + 0.2 * rng.normal(size=(8, 21, 2)).cumsum(axis=1)
    points = plan_safe_probability(plans, shared, rng=rng)
    discs = plan_safe_probability(
        plans, shared, distance=0.3, body=Body([[0.0, 0.0]], [[0.0, 0.0]], [0.7]), rng=rng
    )
    assert_array_equal(discs.safe, points.safe)


def test_what_does_not_fit_is_refused():
    rng, robot = np.random.default_rng(0), double_integrator()
    with pytest.raises(SafetyError, match="state must be 4 finite numbers"):
        long_term_safe_probability(robot, np.zeros(2), np.zeros(2), [oncoming()], rng=rng)
    with pytest.raises(SafetyError, match="one for each of 1 others"):
        long_term_safe_probability(robot, at(0, 0), at(1, 0), [oncoming()], distance=[1.0, 2.0], rng=rng)
    with pytest.raises(SafetyError, match="same space"):
        draw_rollouts([oncoming(), heading(single_integrator(space=3), [0] * 3, [[1] * 3], [1.0])], 5, 5, rng)
    with pytest.raises(SafetyError, match="horizon and rollouts must be at least 1"):
        long_term_safe_probability(robot, at(0, 0), at(1, 0), [oncoming()], rollouts=0, rng=rng)
    with pytest.raises(SafetyError, match="draw them over the same horizon"):
        plan_safe_probability(np.zeros((1, 5, 2)), draw_rollouts([oncoming()], 20, 10, rng), rng=rng)
    with pytest.raises(SafetyError, match="depends on the plan"):
        plan_safe_probability(
            np.zeros((1, 5, 2)), [oncoming()], robot=double_integrator(0.1, limit=1.0), rng=rng
        )
    with pytest.raises(SafetyError, match="one body"):
        plan_safe_probability(np.zeros((1, 5, 2)), [oncoming()], bodies=[None, None], rng=rng)
    with pytest.raises(SafetyError, match="static obstacle 0"):
        plan_safe_probability(np.zeros((1, 5, 2)), [oncoming()], static=[StaticObstacle([0.0], 1.0)], rng=rng)
