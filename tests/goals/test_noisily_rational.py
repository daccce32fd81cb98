"""The density of a noisily rational agent against quadrature and against the printed equations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad

from ppinfer.errors import ModelError
from ppinfer.goals import Dynamics, NoisilyRational

from .literal import literal_log_density, literal_log_normaliser, literal_q

coordinates = st.floats(-10, 10, allow_nan=False)
vectors4 = st.lists(coordinates, min_size=4, max_size=4).map(np.array)
vectors2 = st.lists(coordinates, min_size=2, max_size=2).map(np.array)
positive = st.floats(0.01, 100)


def agent_of(name, dt, q, r, beta):
    return NoisilyRational.lqr(Dynamics.named(name, dt), state_weight=q, control_weight=r, rationality=beta)


@given(
    vectors4, vectors2, vectors2, positive, positive, st.floats(1e-4, 2.0), st.sampled_from([0.05, 0.1, 0.4])
)
def test_the_density_equals_the_printed_equations(x, u, goal, q, r, beta, dt):
    agent = agent_of("double-integrator", dt, q, r, beta)
    theta = agent.dynamics.goal_states(goal)
    A, B = agent.dynamics.A, agent.dynamics.B
    printed = literal_log_density(x, u, theta, A, B, agent.Q, agent.R, beta)
    # the printed form subtracts two numbers of this size
    size = beta * abs((x - theta) @ agent.P @ (x - theta))
    assert_allclose(agent.log_density(u, x, theta), printed, rtol=1e-10, atol=1e-12 * (1 + size) * 100)


@given(vectors4, vectors2, vectors2, positive, st.floats(1e-3, 1.0))
def test_q_and_normaliser_equal_the_printed_ones_and_their_difference_is_the_density(x, u, goal, r, beta):
    agent = agent_of("double-integrator", 0.1, 10.0, r, beta)
    theta = agent.dynamics.goal_states(goal)
    A, B = agent.dynamics.A, agent.dynamics.B
    size = 1 + beta * abs((x - theta) @ agent.P @ (x - theta))
    assert_allclose(
        agent.q_value(u, x, theta), literal_q(x, u, theta, A, B, agent.Q, agent.R, agent.P), rtol=1e-10
    )
    assert_allclose(
        agent.log_normaliser(x, theta),
        literal_log_normaliser(x, theta, A, B, agent.Q, agent.R, agent.P, beta),
        atol=1e-10 * size,
    )
    assert_allclose(
        beta * agent.q_value(u, x, theta) - agent.log_normaliser(x, theta),
        agent.log_density(u, x, theta),
        atol=1e-10 * size,
    )


@pytest.mark.parametrize("name", ["single-integrator", "double-integrator"])
@pytest.mark.parametrize("beta", [0.02, 0.7])
def test_the_normaliser_is_the_integral_over_controls(name, beta):
    agent = agent_of(name, 0.1, 2.0, 1.5, beta)
    states = agent.dynamics.states
    x, theta = np.linspace(-0.4, 0.5, states), agent.dynamics.goal_states(np.array([0.6, -0.3]))
    # Gauss-Legendre over +- 12 standard deviations: exact to rounding for a Gaussian
    nodes, weights = np.polynomial.legendre.leggauss(80)
    reach = 12 * np.sqrt(np.diag(agent.control_covariance))
    u, v = np.meshgrid(*(agent.mean_control(x, theta)[:, None] + reach[:, None] * nodes), indexing="ij")
    grid = np.stack([u.ravel(), v.ravel()], axis=1)
    values = np.exp(beta * agent.q_value(grid, x, theta) - agent.log_normaliser(x, theta))
    integral = np.outer(weights, weights).ravel() @ values * reach.prod()
    assert abs(np.log(integral)) < 1e-10


def test_a_goal_that_moves_by_itself_is_normalised_too():
    # one dimension, and a goal state with a velocity of its own: A theta is not theta
    dynamics = Dynamics(np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([[0.005], [0.1]]), (0,), (1,))
    agent = NoisilyRational(dynamics, np.eye(2), np.eye(1), 0.3)
    x, theta = np.array([0.2, -0.1]), np.array([1.0, 0.7])
    best = agent.mean_control(x, theta)
    integral, _ = quad(
        lambda u: np.exp(0.3 * agent.q_value(np.array([u]), x, theta)),
        best[0] - 60,
        best[0] + 60,
        points=[best[0]],
    )
    assert_allclose(np.log(integral), agent.log_normaliser(x, theta), atol=1e-9)
    assert_allclose(
        0.3 * agent.q_value(np.array([0.4]), x, theta) - np.log(integral),
        agent.log_density(np.array([0.4]), x, theta),
        atol=1e-9,
    )


def test_the_riccati_solution_satisfies_its_equation():
    agent = agent_of("double-integrator", 0.1, 10.0, 1.0, 1.0)
    A, B, P = agent.dynamics.A, agent.dynamics.B, agent.P
    right = A.T @ P @ A - A.T @ P @ B @ np.linalg.solve(agent.R + B.T @ P @ B, B.T @ P @ A) + agent.Q
    assert_allclose(P, right, atol=1e-10)
    assert np.abs(np.linalg.eigvals(agent.closed_loop)).max() < 1


def test_density_survives_where_the_literal_exponentials_underflow():
    agent = agent_of("double-integrator", 0.1, 10.0, 1.0, 5.0)
    x, goals = (
        np.array([10.0, 0.0, 10.0, 0.0]),
        agent.dynamics.goal_states(np.array([[-10.0, -10.0], [10.0, 10.0]])),
    )
    with np.errstate(under="ignore"):
        assert np.exp(agent.rationality * agent.q_value(np.zeros(2), x, goals[0])) == 0.0
    assert np.isfinite(agent.log_density(np.zeros(2), x, goals)).all()


def test_sampled_controls_have_the_mean_and_covariance_of_the_density():
    agent = agent_of("single-integrator", 0.1, 1.0, 2.0, 0.4)
    x, goal = np.zeros((200_000, 2)), np.array([3.0, -1.0])
    controls = agent.sample_control(x, goal, np.random.default_rng(0))
    standard_error = np.sqrt(np.diag(agent.control_covariance) / len(x))
    assert (np.abs(controls.mean(axis=0) - agent.mean_control(x[0], goal)) < 5 * standard_error).all()
    assert_allclose(np.cov(controls.T), agent.control_covariance, atol=0.01 * agent.control_covariance.max())


def test_bad_matrices_are_refused_by_name():
    dynamics = Dynamics.double_integrator(0.1)
    with pytest.raises(ModelError, match=r"Q must have shape \(4, 4\)"):
        NoisilyRational(dynamics, np.eye(2), np.eye(2), 1.0)
    with pytest.raises(ModelError, match="R must be positive definite"):
        NoisilyRational(dynamics, np.eye(4), np.zeros((2, 2)), 1.0)
    with pytest.raises(ModelError, match="finite and symmetric"):
        NoisilyRational(dynamics, np.triu(np.ones((4, 4))), np.eye(2), 1.0)
    with pytest.raises(ModelError, match="rationality"):
        NoisilyRational(dynamics, np.eye(4), np.eye(2), 0.0)
    uncontrolled = Dynamics(np.eye(2), np.zeros((2, 1)), (0, 1))
    with pytest.raises(ModelError, match="no stabilising solution"):
        _ = NoisilyRational(uncontrolled, np.eye(2), np.eye(1), 1.0).P


def test_dynamics_name_what_is_wrong():
    with pytest.raises(ModelError, match="time step"):
        Dynamics.single_integrator(0.0)
    with pytest.raises(ModelError, match="unknown dynamics 'triple'"):
        Dynamics.named("triple", 0.1)
    with pytest.raises(ModelError, match="distinct"):
        Dynamics(np.eye(2), np.eye(2), (0, 0))
    with pytest.raises(ModelError, match=r"\(n, n\)"):
        Dynamics(np.eye(2), np.ones((3, 1)), (0,))


def test_three_dimensions_work_as_two_do():
    agent = NoisilyRational.lqr(Dynamics.double_integrator(0.1, dimensions=3))
    assert agent.K.shape == (3, 6)
    assert np.isfinite(agent.log_density(np.zeros(3), np.zeros(6), np.ones(6)))
