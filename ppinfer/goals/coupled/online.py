"""goal-coupled at control rate: every expert's word on one observation after another."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.goals.coupled.expert import Expert
from ppinfer.goals.coupled.online_geometry import OnlineGeometry
from ppinfer.goals.model import Observation


class OnlineCoupled:
    """The product of experts for one observation after another, within one row.

    Parameters
    ----------
    experts : sequence of Expert
        The factors.
    dt : float
        Nominal time step in s.

    Examples
    --------
    >>> from ppinfer.goals.coupled import Distance
    >>> online = OnlineCoupled([Distance(weight=1.0)], 0.1)
    >>> online.restart(np.array([[3.0, 4.0]]), np.array([True]))
    >>> online.step(Observation(0.0, np.zeros(2))), online.instant()
    (array([0.]), array([-5.]))
    """

    def __init__(self, experts: Sequence[Expert], dt: float) -> None:
        self._geometry = OnlineGeometry()
        self._gathering = [expert.online(dt) for expert in experts if expert.gathers]
        self._judging = [expert.online(dt) for expert in experts if not expert.gathers]

    def restart(self, goals: Float[np.ndarray, "goal space"], present: Bool[np.ndarray, " goal"]) -> None:
        """Begin a row with these goals."""
        self._geometry.restart(goals, present)
        for expert in (*self._gathering, *self._judging):
            expert.restart(goals, present)
        self._present = None if present.all() else present
        self._instant = self._told(np.zeros(len(goals)))

    def step(self, observation: Observation) -> Float[np.ndarray, " goal"]:
        """Return the log likelihood of this observation under every goal."""
        geometry = self._geometry.step(observation)
        count = len(self._instant)
        self._instant = self._told(
            sum((expert.step(observation, geometry) for expert in self._judging), np.zeros(count))
        )
        return self._told(
            sum((expert.step(observation, geometry) for expert in self._gathering), np.zeros(count))
        )

    def instant(self) -> Float[np.ndarray, " goal"]:
        """Return the log weights of the goals as things are since the last step."""
        return self._instant

    def _told(self, log_weights: Float[np.ndarray, " goal"]) -> Float[np.ndarray, " goal"]:
        return log_weights if self._present is None else np.where(self._present, log_weights, -np.inf)
