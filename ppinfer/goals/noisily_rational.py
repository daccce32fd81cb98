"""The noisily rational agent: an LQR controller whose actions are a Gaussian about the best one (22)-(26)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from ppinfer.errors import ModelError
from ppinfer.goals.dynamics import Dynamics
from ppinfer.goals.quadratic import quadratic_form


@dataclass(frozen=True, eq=False)
class NoisilyRational:
    """An agent exponentially more likely to take an action the higher its Q-value towards its goal.

    With P the solution of the discrete algebraic Riccati equation (25), S = R + B'PB and K = S^-1 B'PA, completing
    the square in (22)-(24) gives

        u | x, theta ~ N(-K (x - theta) - S^-1 B'P c, (2 beta S)^-1),   c = (A - I) theta,

    where c is zero for a goal that stays where it is (A theta = theta).

    Parameters
    ----------
    dynamics : Dynamics
        A, B and the meaning of the state's entries.
    Q : (n, n) float64
        Weight of the state's distance from the goal; symmetric, positive semi-definite.
    R : (m, m) float64
        Weight of the control; symmetric, positive definite.
    rationality : float
        Inverse temperature beta > 0, in units of 1/cost.

    Raises
    ------
    ModelError
        Where a matrix has the wrong shape, is not symmetric or not definite, where beta is not positive and finite,
        or where the Riccati equation has no stabilising solution.

    Examples
    --------
    >>> agent = NoisilyRational.lqr(Dynamics.single_integrator(0.1), control_weight=1.0, rationality=2.0)
    >>> agent.mean_control(np.array([0.0, 0.0]), np.array([1.0, 0.0])).round(3)
    array([0.951, 0.   ])
    """

    dynamics: Dynamics
    Q: Float[np.ndarray, "_ _"]
    R: Float[np.ndarray, "_ _"]
    rationality: float

    def __post_init__(self) -> None:
        for name, size, strict in (("Q", self.dynamics.states, False), ("R", self.dynamics.controls, True)):
            matrix = np.array(getattr(self, name), dtype=np.float64)
            if matrix.shape != (size, size):
                raise ModelError(
                    f"{name} must have shape {(size, size)} for these dynamics; got {matrix.shape}"
                )
            if not np.isfinite(matrix).all() or not np.allclose(matrix, matrix.T, rtol=1e-12, atol=0):
                raise ModelError(f"{name} must be finite and symmetric")
            smallest = float(np.linalg.eigvalsh(matrix)[0])
            if smallest < -1e-12 * max(1.0, float(np.abs(matrix).max())) or (strict and smallest <= 0):
                kind = "positive definite" if strict else "positive semi-definite"
                raise ModelError(f"{name} must be {kind}; its smallest eigenvalue is {smallest:.3g}")
            matrix.setflags(write=False)
            object.__setattr__(self, name, matrix)
        if not (math.isfinite(self.rationality) and self.rationality > 0):
            raise ModelError(f"rationality must be positive and finite (1/cost); got {self.rationality!r}")

    @classmethod
    def lqr(
        cls,
        dynamics: Dynamics,
        *,
        state_weight: float = 1.0,
        control_weight: float = 1.0,
        rationality: float = 1.0,
    ) -> NoisilyRational:
        """Return the agent with Q = state_weight I and R = control_weight I."""
        return cls(
            dynamics,
            state_weight * np.eye(dynamics.states),
            control_weight * np.eye(dynamics.controls),
            rationality,
        )

    @cached_property
    def P(self) -> Float[np.ndarray, "n n"]:
        """The stabilising solution of the Riccati equation (25)."""
        from scipy.linalg import solve_discrete_are

        try:
            solution: np.ndarray = solve_discrete_are(self.dynamics.A, self.dynamics.B, self.Q, self.R)
        except (np.linalg.LinAlgError, ValueError) as error:
            raise ModelError(
                f"the Riccati equation (25) has no stabilising solution for these A, B, Q, R: {error}; is the goal "
                "reachable, and does Q weigh the position?"
            ) from error
        return solution

    @cached_property
    def S(self) -> Float[np.ndarray, "m m"]:
        """R + B'PB: half the curvature of -Q(x, u) in u."""
        B = self.dynamics.B
        S: np.ndarray = self.R + B.T @ self.P @ B
        symmetric: np.ndarray = 0.5 * (S + S.T)
        return symmetric

    @cached_property
    def K(self) -> Float[np.ndarray, "m n"]:
        """The feedback gain S^-1 B'PA; the best control towards a goal at rest is -K (x - theta)."""
        gain: np.ndarray = np.linalg.solve(self.S, self.dynamics.B.T @ self.P @ self.dynamics.A)
        return gain

    @cached_property
    def goal_gain(self) -> Float[np.ndarray, "m n"]:
        """K - S^-1 B'P (A - I): the best control is goal_gain theta - K x, for goals that move by themselves too."""
        A, B = self.dynamics.A, self.dynamics.B
        drift: np.ndarray = np.linalg.solve(self.S, B.T @ self.P @ (A - np.eye(len(A))))
        gain: np.ndarray = self.K - drift
        return gain

    @property
    def control_covariance(self) -> Float[np.ndarray, "m m"]:
        """(2 beta S)^-1, the covariance of the control about the best one."""
        covariance: np.ndarray = np.linalg.inv(2 * self.rationality * self.S)
        return covariance

    @property
    def closed_loop(self) -> Float[np.ndarray, "n n"]:
        """F = A - BK: how the distance from the goal evolves under the best control."""
        loop: np.ndarray = self.dynamics.A - self.dynamics.B @ self.K
        return loop

    def mean_control(
        self, state: Float[np.ndarray, "*#batch n"], goal: Float[np.ndarray, "*#batch n"]
    ) -> Float[np.ndarray, "*batch m"]:
        """Return the best control at `state` towards `goal` (both states); leading axes broadcast."""
        control: np.ndarray = goal @ self.goal_gain.T - state @ self.K.T
        return control

    def log_density(
        self,
        control: Float[np.ndarray, "*#batch m"],
        state: Float[np.ndarray, "*#batch n"],
        goal: Float[np.ndarray, "*#batch n"],
    ) -> Float[np.ndarray, "*batch"]:
        """Return log p(u | x, theta), eq. (22) with its exact normaliser (26); leading axes broadcast.

        Computed as a Gaussian in u, so nothing underflows where the literal exponentials do.
        """
        residual = control - self.mean_control(state, goal)
        _, log_determinant = np.linalg.slogdet(2 * self.rationality * self.S)
        constant = 0.5 * log_determinant - 0.5 * self.dynamics.controls * math.log(2 * math.pi)
        density = constant - self.rationality * quadratic_form(residual, self.S)
        return np.asarray(density)

    def q_value(
        self,
        control: Float[np.ndarray, "*#batch m"],
        state: Float[np.ndarray, "*#batch n"],
        goal: Float[np.ndarray, "*#batch n"],
    ) -> Float[np.ndarray, "*batch"]:
        """Return Q(x, u; theta) of (23)-(24): instantaneous reward minus the cost to go after one step."""
        following = self.dynamics.step(state, control)
        value = -(
            quadratic_form(state - goal, self.Q)
            + quadratic_form(control, self.R)
            + quadratic_form(following - goal, self.P)
        )
        return np.asarray(value)

    def log_normaliser(
        self, state: Float[np.ndarray, "*#batch n"], goal: Float[np.ndarray, "*#batch n"]
    ) -> Float[np.ndarray, "*batch"]:
        """Return the log of (26), the integral of exp(beta Q(x, u; theta)) over u, drifting goals included."""
        best = self.mean_control(state, goal)
        _, log_determinant = np.linalg.slogdet(2 * self.rationality * self.S)
        m = self.dynamics.controls
        value = self.rationality * self.q_value(best, state, goal) + 0.5 * (
            m * math.log(2 * math.pi) - log_determinant
        )
        return np.asarray(value)

    def sample_control(
        self,
        state: Float[np.ndarray, "*#batch n"],
        goal: Float[np.ndarray, "*#batch n"],
        rng: np.random.Generator,
    ) -> Float[np.ndarray, "*batch m"]:
        """Draw a control from (22) at each state."""
        mean = self.mean_control(state, goal)
        scale = np.linalg.cholesky(self.control_covariance)
        control: np.ndarray = mean + rng.standard_normal(mean.shape) @ scale.T
        return control
