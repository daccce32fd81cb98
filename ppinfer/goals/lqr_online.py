"""goal-lqr at control rate: the likelihood of one observation after another."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.goals.lqr import GoalLQR, log_peak
from ppinfer.goals.model import Observation


class OnlineLQR:
    """The likelihood of `GoalLQR`, one observation at a time."""

    def __init__(self, model: GoalLQR, dt: float) -> None:
        self._model = model
        self._dt = dt

    def restart(self, goals: Float[np.ndarray, "goal space"], present: Bool[np.ndarray, " goal"]) -> None:
        """Begin a row with these goals."""
        model = self._model
        agent = model.agent_at(self._dt, goals.shape[1])
        dynamics = agent.dynamics
        self._agent = agent
        self._best = dynamics.goal_states(np.where(present[:, None], goals, 0.0)) @ agent.goal_gain.T
        # e' S e = |L' e|^2 with S = L L': one product and one sum per step
        self._root = np.linalg.cholesky(agent.S)
        self._absent = None if present.all() else ~present
        self._position, self._velocity = list(dynamics.position_index), list(dynamics.velocity_index)
        self._silent = np.zeros(len(goals))
        if self._absent is not None:
            self._silent[self._absent] = -np.inf
        self._peak = model.tempering * log_peak(agent)
        self._weight = -model.tempering * agent.rationality
        self._last_time = math.nan
        self._last_position: Float[np.ndarray, " space"] | None = None
        self._last_state: Float[np.ndarray, " n"] | None = None

    def step(self, observation: Observation) -> Float[np.ndarray, " goal"]:
        """Return the log likelihood of this observation under every goal."""
        squares = self.squared_residuals(observation)
        if squares is None:
            return self._silent
        exponent = self._weight * squares
        floor = self._model.evidence_floor
        if floor > 0:
            exponent = np.logaddexp(exponent + math.log1p(-floor), math.log(floor))
        exponent += self._peak
        if self._absent is not None:
            exponent[self._absent] = -np.inf
        likelihood: np.ndarray = exponent
        return likelihood

    def squared_residuals(self, observation: Observation) -> Float[np.ndarray, " goal"] | None:
        """Return e' S e, e being the control less the best one, for every goal; None where nothing is told."""
        if observation.position is None:
            return None
        dynamics = self._agent.dynamics
        elapsed = observation.time - self._last_time
        state = self._state(observation, elapsed)
        if observation.control is not None and observation.control_order == dynamics.order:
            acted_from, control = state, observation.control
        else:
            acted_from, control = self._last_state, None
            if acted_from is not None and state is not None and dynamics.usable_step(np.asarray(elapsed)):
                control = dynamics.control_between(acted_from, state, np.asarray(elapsed))
        self._last_time, self._last_position, self._last_state = observation.time, observation.position, state
        if acted_from is None or control is None:
            return None
        residual = (control + self._agent.K @ acted_from - self._best) @ self._root
        squares: np.ndarray = (residual * residual).sum(axis=1)
        return squares

    def _state(self, observation: Observation, elapsed: float) -> Float[np.ndarray, " n"] | None:
        assert observation.position is not None
        if not self._velocity:
            return observation.position
        velocity = observation.velocity
        if velocity is None:
            if self._last_position is None:
                return None
            velocity = (observation.position - self._last_position) / elapsed
        state = np.empty(self._agent.dynamics.states)
        state[self._position] = observation.position
        state[self._velocity] = velocity
        return state
