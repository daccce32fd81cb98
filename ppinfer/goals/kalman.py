"""goal-kalman: goals from noisy positions alone, by a bank of Kalman filters, one a goal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Factor
from ppinfer.errors import ModelError
from ppinfer.goals.dynamics import Dynamics
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.lqr import GoalLQR
from ppinfer.goals.model import (
    LARGEST,
    Assessment,
    GoalDesign,
    GoalModel,
    Observation,
    OnlineLikelihood,
    require_range,
)
from ppinfer.goals.noisily_rational import NoisilyRational
from ppinfer.goals.rollout import roll_out

# however slow the agent, a gap in the log is bridged in at most so many steps
MOST_STEPS = 100_000
SOURCE = "hidden: Kalman-filtered from noisy positions, one filter a goal"


@dataclass(frozen=True)
class GoalKalman(GoalModel):
    """A noisily rational LQR agent of which only noisy positions are seen.

    Under each goal the closed loop F = A - BK with process noise Q = B (2 beta S)^-1 B' is a linear-Gaussian system;
    the evidence of a position is the density of its innovation. A sample whose innovation lies beyond `gate` standard
    deviations under every goal is an outlier: it is counted, updates no filter and says nothing of the goals. After
    `reacquire_after` outliers in a row the filters start anew at the last of them. Dropouts predict without updating;
    times are taken in whole steps of the nominal dt, at least one between samples.

    Parameters
    ----------
    dynamics, control_weight, state_weight, rationality
        The agent, as in `GoalLQR`.
    measurement_noise : float
        Standard deviation of a position about the true one (m, or the log's unit), per dimension; positive.
    initial_speed : float
        Standard deviation of the velocity at the start of a row (per dimension), for dynamics that have one.
    gate : float
        Mahalanobis distance beyond which a sample is an outlier.
    reacquire_after : int
        Outliers in a row after which the agent is taken to be where they are.
    tempering : float
        Exponent on the likelihood.
    stay : float
        Probability per sample that the goal stays what it is.

    Raises
    ------
    ModelError
        Where a parameter is out of its range.

    Examples
    --------
    >>> from ppinfer.goals import GoalDesign, infer_goals
    >>> model = GoalKalman(rationality=1.0, measurement_noise=0.02)
    >>> rng = np.random.default_rng(0)
    >>> evidence = model.simulate(GoalDesign.random(rng, rows=3, samples=25), rng)
    >>> belief = infer_goals(model, evidence)
    >>> int(belief.outliers.sum())
    0
    """

    name: ClassVar[str] = "goal-kalman"
    fitted: ClassVar[dict[str, str]] = {
        "control_weight": "log",
        "rationality": "log",
        "measurement_noise": "log",
        "stay": "logit",
    }
    gates_outliers: ClassVar[bool] = True

    dynamics: str = "double-integrator"
    control_weight: float = 10.0
    state_weight: float = 1.0
    rationality: float = 0.002
    measurement_noise: float = 0.05
    initial_speed: float = 1.0
    gate: float = 5.0
    reacquire_after: int = 5
    tempering: float = 1.0
    stay: float = 1.0

    def __post_init__(self) -> None:
        self._lqr()
        for name in ("measurement_noise", "initial_speed", "gate"):
            require_range(name, getattr(self, name), 0.0, LARGEST, open_low=True)
        if self.reacquire_after < 1:
            raise ModelError(f"reacquire_after must be at least 1; got {self.reacquire_after}")

    def _lqr(self) -> GoalLQR:
        return GoalLQR(
            dynamics=self.dynamics,
            control_weight=self.control_weight,
            state_weight=self.state_weight,
            rationality=self.rationality,
            tempering=self.tempering,
            stay=self.stay,
        )

    def agent_at(self, dt: float, dimensions: int = 2) -> NoisilyRational:
        """Return the agent for samples `dt` seconds apart."""
        return self._lqr().agent_at(dt, dimensions)

    def log_likelihood(self, evidence: GoalEvidence) -> Factor:
        """Return the tempered log density of every innovation under every goal."""
        return self.assess(evidence).log_likelihood

    def assess(self, evidence: GoalEvidence) -> Assessment:
        """Return the likelihood together with the samples gated as outliers."""
        from ppinfer.goals.scans import kalman_bank

        dt = evidence.dt
        if math.isnan(dt):
            raise ModelError(
                "no row holds two samples, so the time step is unknown; give the evidence its time_step"
            )
        agent = self.agent_at(dt, evidence.position.shape[1])
        system = _System.of(agent, self.measurement_noise, self.initial_speed)
        goals = np.where(evidence.goal_present[..., None], evidence.goals, 0.0)
        log_likelihood = np.empty((evidence.samples, len(evidence.goal_labels)))
        outliers = np.empty(evidence.samples, dtype=bool)
        kalman_bank(
            evidence.time,
            evidence.position,
            evidence.seen,
            evidence.row_size,
            system.drive(agent, goals),
            evidence.goal_present,
            system.F,
            system.Q,
            system.H,
            system.R,
            system.start_covariance,
            dt,
            system.most_steps,
            self.gate**2,
            self.reacquire_after,
            log_likelihood,
            outliers,
        )
        return Assessment(evidence.likelihood_factor(self.tempering * log_likelihood), SOURCE, outliers)

    def online(self, dt: float) -> OnlineLikelihood:
        """Return a bank of filterpy's Kalman filters, one a goal."""
        return _FilterBank(self, dt)

    def simulate(self, design: GoalDesign, rng: np.random.Generator) -> GoalEvidence:
        """Return noisy positions of the agent, its velocity at the start drawn with `initial_speed`."""
        agent = self.agent_at(design.dt, design.start.shape[1])
        dynamics = agent.dynamics
        start = dynamics.goal_states(design.start)
        moving = list(dynamics.velocity_index)
        start[:, moving] = self.initial_speed * rng.standard_normal((len(start), len(moving)))
        state, _ = roll_out(agent, start, design, rng)
        position = state[:, list(dynamics.position_index)]
        return GoalEvidence(
            time=design.time,
            position=position + self.measurement_noise * rng.standard_normal(position.shape),
            goals=design.goals,
            row_size=design.row_size,
            goal_labels=design.labels,
            time_step=design.dt,
        )


@dataclass(frozen=True, eq=False)
class _System:
    """The linear-Gaussian system of an agent that pursues a goal: x' = F x + drive + N(0, Q), z = H x + N(0, R)."""

    F: Float[np.ndarray, "n n"]
    Q: Float[np.ndarray, "n n"]
    H: Float[np.ndarray, "space n"]
    R: Float[np.ndarray, "space space"]
    start_covariance: Float[np.ndarray, "n n"]

    @classmethod
    def of(cls, agent: NoisilyRational, measurement_noise: float, initial_speed: float) -> _System:
        dynamics: Dynamics = agent.dynamics
        space = len(dynamics.position_index)
        H = np.zeros((space, dynamics.states))
        H[np.arange(space), list(dynamics.position_index)] = 1.0
        variance = np.zeros(dynamics.states)
        variance[list(dynamics.position_index)] = measurement_noise**2
        variance[list(dynamics.velocity_index)] = initial_speed**2
        return cls(
            F=np.ascontiguousarray(agent.closed_loop),
            Q=np.ascontiguousarray(dynamics.B @ agent.control_covariance @ dynamics.B.T),
            H=H,
            R=measurement_noise**2 * np.eye(space),
            start_covariance=np.diag(variance),
        )

    @cached_property
    def most_steps(self) -> int:
        """Steps after which an unseen agent rests at its goal, to the last digit: further ones change nothing."""
        slowest = float(np.abs(np.linalg.eigvals(self.F)).max())
        settled = math.ceil(2 * math.log(1e-16) / math.log(slowest)) if 0 < slowest < 1 else MOST_STEPS
        return min(MOST_STEPS, 2 + settled)

    def drive(
        self, agent: NoisilyRational, goals: Float[np.ndarray, "*batch space"]
    ) -> Float[np.ndarray, "*batch n"]:
        """Return B goal_gain theta for goals at rest."""
        dynamics = agent.dynamics
        drive: np.ndarray = dynamics.goal_states(goals) @ agent.goal_gain.T @ dynamics.B.T
        return np.ascontiguousarray(drive)


class _FilterBank:
    """The likelihood of `GoalKalman`, one observation at a time, by one filterpy filter a goal."""

    def __init__(self, model: GoalKalman, dt: float) -> None:
        self._model = model
        self._dt = dt

    def restart(self, goals: Float[np.ndarray, "goal space"], present: Bool[np.ndarray, " goal"]) -> None:
        """Begin a row with these goals; the filters start at the first position seen."""
        from filterpy.kalman import KalmanFilter

        space = goals.shape[1]
        agent = self._model.agent_at(self._dt, space)
        self._system = _System.of(agent, self._model.measurement_noise, self._model.initial_speed)
        self._drive = self._system.drive(agent, np.where(present[:, None], goals, 0.0))
        self._present = present
        self._filters = []
        for drive in self._drive:
            kalman = KalmanFilter(dim_x=agent.dynamics.states, dim_z=space)
            kalman.F, kalman.Q, kalman.H, kalman.R = (
                self._system.F, self._system.Q, self._system.H, self._system.R
            )  # fmt: skip
            # the pull of the goal enters as the control B u with B = I
            kalman.B = np.eye(len(drive))
            self._filters.append(kalman)
        self._silent = np.where(present, 0.0, -np.inf)
        self._started, self._rejected, self._last_time = False, 0, math.nan

    def step(self, observation: Observation) -> Float[np.ndarray, " goal"]:
        """Return the tempered log density of this position's innovation under every goal."""
        elapsed, self._last_time = observation.time - self._last_time, observation.time
        if self._started:
            for _ in range(min(self._system.most_steps, max(1, round(elapsed / self._dt)))):
                for kalman, drive in zip(self._filters, self._drive, strict=True):
                    kalman.predict(u=drive[:, None])
        if observation.position is None:
            return self._silent
        if not self._started:
            self._start_at(observation.position)
            return self._silent
        z = observation.position[:, None]
        if self._is_outlier(z):
            self._rejected += 1
            if self._rejected >= self._model.reacquire_after:
                self._start_at(observation.position)
            return self._silent
        self._rejected = 0
        likelihood = np.full(len(self._filters), -np.inf)
        for goal, kalman in enumerate(self._filters):
            kalman.update(z)
            if self._present[goal]:
                likelihood[goal] = self._model.tempering * kalman.log_likelihood
        return likelihood

    def _start_at(self, position: Float[np.ndarray, " space"]) -> None:
        for kalman in self._filters:
            kalman.x = self._system.H.T @ position[:, None]
            kalman.P = self._system.start_covariance.copy()
        self._started, self._rejected = True, 0

    def _is_outlier(self, z: Float[np.ndarray, "space 1"]) -> bool:
        nearest = math.inf
        for goal, kalman in enumerate(self._filters):
            if self._present[goal]:
                residual = z - kalman.H @ kalman.x
                innovation = kalman.H @ kalman.P @ kalman.H.T + kalman.R
                nearest = min(nearest, (residual.T @ np.linalg.solve(innovation, residual)).item())
        return nearest > self._model.gate**2
