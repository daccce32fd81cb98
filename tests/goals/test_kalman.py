"""The bank of Kalman filters: exact where noise vanishes, silent at dropouts, deaf to outliers."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import multivariate_normal

from ppinfer.errors import ModelError
from ppinfer.goals import GoalDesign, GoalKalman, GoalLQR, infer_goals


def simulated(model, *, rows=30, samples=25, seed=0):
    rng = np.random.default_rng(seed)
    design = GoalDesign.random(rng, rows=rows, samples=samples)
    return design, model.simulate(design, rng)


def test_the_likelihood_of_a_row_is_that_of_one_big_gaussian():
    # all positions of a row are jointly Gaussian given the goal: unroll the system and evaluate the density at once
    model = GoalKalman(control_weight=2.0, rationality=0.5, measurement_noise=0.1, initial_speed=0.7)
    _, evidence = simulated(model, rows=1, samples=7)
    agent = model.agent_at(0.1)
    A, B, K = agent.dynamics.A, agent.dynamics.B, agent.K
    F, W = A - B @ K, B @ agent.control_covariance @ B.T
    H = np.zeros((2, 4))
    H[[0, 1], [0, 2]] = 1.0
    ours = model.log_likelihood(evidence).log_values
    for goal in range(3):
        theta = agent.dynamics.goal_states(evidence.goals[0, goal])
        mean, cov = H.T @ evidence.position[0], np.diag([0.01, 0.49, 0.01, 0.49])
        means, covariances = [], {}
        cross = cov.copy()
        state_cov = [cov]
        for _ in range(6):
            mean = F @ mean + B @ agent.goal_gain @ theta
            means.append(H @ mean)
            state_cov.append(F @ state_cov[-1] @ F.T + W)
        size = 6
        joint = np.zeros((2 * size, 2 * size))
        for i in range(size):
            cross = state_cov[i + 1]
            for j in range(i, size):
                block = H @ cross @ H.T + (0.01 * np.eye(2) if i == j else 0)
                joint[2 * i : 2 * i + 2, 2 * j : 2 * j + 2] = block
                joint[2 * j : 2 * j + 2, 2 * i : 2 * i + 2] = block.T
                cross = cross @ F.T
        covariances[goal] = joint
        expected = multivariate_normal(np.concatenate(means), joint).logpdf(evidence.position[1:].ravel())
        assert_allclose(ours[:, goal].sum(), expected, rtol=1e-9)


@pytest.mark.parametrize(("noise", "most"), [(1e-4, 0.01), (1e-2, 0.05)])
def test_as_noise_vanishes_the_belief_becomes_that_of_the_exact_states(noise, most):
    exact = GoalLQR(dynamics="double-integrator", control_weight=1.0, state_weight=10.0, rationality=0.01)
    rng = np.random.default_rng(1)
    evidence = exact.simulate(GoalDesign.random(rng, rows=40, samples=30), rng)
    seen = replace(
        evidence,
        position=evidence.position + noise * rng.standard_normal(evidence.position.shape),
        velocity=None,
        control=None,
    )
    model = GoalKalman(
        control_weight=1.0,
        state_weight=10.0,
        rationality=0.01,
        measurement_noise=noise,
        initial_speed=1e-3,
        gate=20.0,
    )
    ours = np.exp(infer_goals(model, seen).log_posterior)
    theirs = np.exp(infer_goals(exact, evidence).log_posterior)
    # a position tells of the control before it: compare with the exact belief one sample earlier
    late, early = np.delete(np.arange(evidence.samples), evidence.row_start), None
    early = late - 1
    total_variation = 0.5 * np.abs(ours[late] - theirs[early]).sum(axis=1)
    assert total_variation.mean() < most


def test_dropouts_predict_without_updating():
    model = GoalKalman(rationality=0.5, measurement_noise=0.05)
    _, evidence = simulated(model, rows=1, samples=10)
    holed = replace(
        evidence,
        position=np.where((np.arange(10) == 4)[:, None], np.nan, evidence.position),
        observed=np.arange(10) != 4,
    )
    apart = replace(
        evidence,
        time=np.delete(evidence.time, 4),
        position=np.delete(evidence.position, 4, axis=0),
        row_size=np.array([9]),
    )
    ours, theirs = infer_goals(model, holed).log_posterior, infer_goals(model, apart).log_posterior
    assert_allclose(ours[4], ours[3], atol=1e-12)
    assert_allclose(np.delete(ours, 4, axis=0), theirs, atol=1e-9)


def test_outliers_are_counted_and_change_nothing():
    model = GoalKalman(rationality=0.5, measurement_noise=0.05)
    _, evidence = simulated(model, rows=1, samples=12)
    jumped = evidence.position.copy()
    jumped[6] += [40.0, -30.0]
    belief = infer_goals(model, replace(evidence, position=jumped))
    assert np.flatnonzero(belief.outliers).tolist() == [6]
    dropped = replace(
        evidence,
        position=np.where((np.arange(12) == 6)[:, None], np.nan, evidence.position),
        observed=np.arange(12) != 6,
    )
    assert_allclose(belief.log_posterior, infer_goals(model, dropped).log_posterior, atol=1e-12)
    assert not infer_goals(model, evidence).outliers.any()


def test_after_enough_outliers_the_agent_is_where_they_are():
    model = GoalKalman(rationality=0.5, measurement_noise=0.05, reacquire_after=3)
    _, evidence = simulated(model, rows=1, samples=16)
    moved = evidence.position.copy()
    moved[6:] += [2.0, 0.0]
    belief = infer_goals(model, replace(evidence, position=moved))
    assert np.flatnonzero(belief.outliers).tolist() == [6, 7, 8]


def test_only_absent_goals_explaining_a_sample_do_not_save_it_from_the_gate():
    model = GoalKalman(rationality=50.0, measurement_noise=0.01)
    rng = np.random.default_rng(3)
    goals = np.array([[[10.0, 0.0], [-10.0, 0.0]]])
    design = GoalDesign(np.zeros((1, 2)), goals, np.array([0]), np.array([20]), 0.1)
    evidence = model.simulate(design, rng)
    absent = replace(evidence, present=np.array([[False, True]]))
    assert infer_goals(model, absent).outliers.sum() > 0
    assert infer_goals(model, evidence).outliers.sum() == 0


def test_the_goal_is_found_from_noisy_positions_alone():
    model = GoalKalman(control_weight=5.0, rationality=0.2, measurement_noise=0.1)
    design, evidence = simulated(model, rows=100, samples=40)
    last = infer_goals(model, evidence).log_posterior[evidence.row_start + 39]
    assert (last.argmax(axis=1) == design.true_goal).mean() > 0.9


def test_parameters_out_of_range_are_refused():
    with pytest.raises(ModelError, match="measurement_noise"):
        GoalKalman(measurement_noise=0.0)
    with pytest.raises(ModelError, match="reacquire_after"):
        GoalKalman(reacquire_after=0)
