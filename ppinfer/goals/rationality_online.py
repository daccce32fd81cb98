"""The belief over goal and rationality at control rate."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Axis, Distribution
from ppinfer.distributions.logspace import log_normalise, log_sum_exp
from ppinfer.errors import ImpossibleEvidenceError, LogError
from ppinfer.goals.lqr_online import OnlineLQR
from ppinfer.goals.model import Observation
from ppinfer.goals.priors import log_priors
from ppinfer.goals.switching import goal_transition

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ppinfer.goals.rationality import GoalAndRationality


class OnlineGoalAndRationality:
    """A belief over one agent's goal and rationality, updated as it moves; equal at every step to the offline filter.

    Parameters
    ----------
    model : GoalAndRationality
        The agent, and the rationalities that it may have.
    dt : float
        Nominal seconds between observations.
    labels : sequence of str
        Names of the goals.

    Examples
    --------
    >>> from ppinfer.goals import GoalAndRationality
    >>> belief = OnlineGoalAndRationality(GoalAndRationality(), dt=0.1, labels=["cup", "bowl"])
    >>> _ = belief.restart(np.array([[5.0, 0.0], [0.0, 5.0]]))
    >>> for step in range(9):
    ...     joint = belief.observe(0.1 * step, np.zeros(2), velocity=np.zeros(2), control=np.array([7.5, 0.0]))
    >>> joint.mode()
    {'goal': 'cup', 'rationality': 0.005}
    """

    def __init__(self, model: GoalAndRationality, *, dt: float, labels: Sequence[str]) -> None:
        self._model = model
        self._dt = dt
        self._likelihood = OnlineLQR(model.model, dt)
        self._axes = (Axis("goal", labels), model.axis)
        self._weights = -model.model.tempering * np.asarray(model.rationalities, dtype=np.float64)
        self._log_belief: Float[np.ndarray, "goal rationality"] | None = None
        self._transition: Float[np.ndarray, "goal goal"] | None = None
        self._space = 0
        self._fresh = True
        self._last_time = -math.inf

    def restart(
        self,
        goals: Float[np.ndarray, "goal space"],
        *,
        present: Bool[np.ndarray, " goal"] | None = None,
        prior: Any = None,
        carry_rationality: bool = False,
    ) -> Distribution:
        """Begin a row: new goals, with the rationality's prior or what was learnt of it.

        Parameters
        ----------
        goals : (goal, space) float64
            Positions of the goals, one for each label.
        present : (goal,) bool, optional
            Goals that exist; default all.
        prior : (goal,) array of float, optional
            Probabilities of the goals to start from; default even over the goals present.
        carry_rationality : bool
            Start from the last belief over the rationality, instead of from its prior.

        Raises
        ------
        LogError
            Where the goals do not match the labels or are not finite.
        """
        count = len(self._axes[0])
        goals = np.asarray(goals, dtype=np.float64)
        there = np.ones(count, dtype=bool) if present is None else np.asarray(present, dtype=bool)
        if goals.ndim != 2 or len(goals) != count or there.shape != (count,):
            raise LogError(
                f"goals of shape {goals.shape} do not match the {count} labels {list(self._axes[0].labels)}"
            )
        if not np.isfinite(goals[there]).all() or not there.any():
            raise LogError(
                "at least one goal must be present, and every goal that is must have a finite position"
            )
        rationality = self._model.log_prior
        if carry_rationality and self._log_belief is not None:
            rationality = log_sum_exp(self._log_belief, (0,))
        log_prior = log_priors(there[None], prior, name_row=lambda _: "the new row")[0]
        self._log_belief = log_prior[:, None] + rationality
        stay = self._model.model.stay
        self._transition = None if stay == 1.0 else goal_transition(there, stay)
        self._space = goals.shape[1]
        self._fresh, self._last_time = True, -math.inf
        self._likelihood.restart(goals, there)
        agent = self._model.model.agent_at(self._dt, self._space)
        self._peaks = self._model.model.tempering * self._model.log_peaks(agent)
        return self._belief()

    def observe(
        self,
        time: float,
        position: Float[np.ndarray, " space"] | None,
        *,
        velocity: Float[np.ndarray, " space"] | None = None,
        control: Float[np.ndarray, " control"] | None = None,
        control_order: int | None = 2,
    ) -> Distribution:
        """Return the belief after one more observation; ``position=None`` is a dropout.

        Parameters
        ----------
        time : float
            Seconds, later than the last observation of the row.
        position, velocity, control : (space,) float64, optional
            What was seen; `control_order` is 1 where the control is a velocity, 2 where it is an acceleration.

        Raises
        ------
        LogError
            Where no row was begun, time does not increase, or a value is not finite.
        ImpossibleEvidenceError
            Where everything is ruled out.
        """
        self._check(time, position, velocity, control)
        self._last_time = time
        squares = self._likelihood.squared_residuals(
            Observation(time, position, velocity, control, control_order)
        )
        log_belief = self._log_belief
        assert log_belief is not None
        if self._transition is not None and not self._fresh:
            log_belief = _moved(log_belief, self._transition)
        if squares is not None:
            exponent = squares[:, None] * self._weights
            floor = self._model.model.evidence_floor
            if floor > 0:
                exponent = np.logaddexp(exponent + math.log1p(-floor), math.log(floor))
            log_belief = log_belief + exponent + self._peaks
        self._log_belief, dead = log_normalise(log_belief)
        if dead is not None:
            raise ImpossibleEvidenceError(f"every goal is ruled out at time {time!r}")
        self._fresh = False
        return self._belief()

    def _belief(self) -> Distribution:
        assert self._log_belief is not None
        return Distribution._sound(self._axes, self._log_belief, ("random", "random"))

    def _check(
        self,
        time: float,
        position: Float[np.ndarray, " space"] | None,
        velocity: Float[np.ndarray, " space"] | None,
        control: Float[np.ndarray, " control"] | None,
    ) -> None:
        if self._log_belief is None:
            raise LogError("no goals yet: call restart(goals) before the first observation")
        if not self._last_time < time < math.inf:
            raise LogError(
                f"time must be finite and increase within a row; got {time!r} after {self._last_time!r}"
            )
        if position is not None and np.shape(position) != (self._space,):
            raise LogError(
                f"position at time {time!r} has shape {np.shape(position)}; the goals lie in {self._space} dimensions"
            )
        for name, value in (("position", position), ("velocity", velocity), ("control", control)):
            if value is not None and not all(map(math.isfinite, np.asarray(value).tolist())):
                raise LogError(f"{name} at time {time!r} is not finite; pass position=None for a dropout")


def _moved(
    log_belief: Float[np.ndarray, "goal rationality"], transition: Float[np.ndarray, "goal goal"]
) -> Float[np.ndarray, "goal rationality"]:
    """Return the belief one step later; each rationality by itself, however improbable it is."""
    largest = log_belief.max(axis=0)
    largest[largest == -np.inf] = 0.0
    with np.errstate(divide="ignore"):
        moved: np.ndarray = np.log(transition.T @ np.exp(log_belief - largest)) + largest
    return moved
