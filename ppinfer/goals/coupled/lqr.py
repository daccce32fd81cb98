"""The motion expert of the paper: a noisily rational LQR agent, in place of `Motion`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Factor
from ppinfer.goals.coupled.expert import Expert, OnlineExpert
from ppinfer.goals.coupled.geometry import Geometry
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.lqr import GoalLQR
from ppinfer.goals.model import Observation, OnlineLikelihood


@dataclass(frozen=True)
class LqrMotion(Expert):
    """The tempered likelihood of each control under a single-integrator `GoalLQR`.

    Rationality and tempering multiply each other in a posterior, so there is one number for both.

    Parameters
    ----------
    control_weight : float
        R = control_weight I against Q = I: how briskly a goal is approached.
    rationality : float
        Inverse temperature, in 1/cost, tempering included.
    evidence_floor : float
        Share of the evidence of a sample that tells nothing, in [0, 1).

    Raises
    ------
    ModelError
        Where a parameter is out of its range.

    Examples
    --------
    >>> LqrMotion(control_weight=5.0).likelihood.control_weight
    5.0
    """

    name: ClassVar[str] = "lqr"
    gathers: ClassVar[bool] = True
    fitted: ClassVar[dict[str, str]] = {
        "control_weight": "log",
        "rationality": "log",
        "evidence_floor": "logit",
    }

    control_weight: float = 1500.0
    rationality: float = 0.00016
    evidence_floor: float = 0.0001

    def __post_init__(self) -> None:
        _ = self.likelihood

    @cached_property
    def likelihood(self) -> GoalLQR:
        """The model whose likelihood this is."""
        return GoalLQR(
            control_weight=self.control_weight,
            rationality=self.rationality,
            evidence_floor=self.evidence_floor,
        )

    def log_factor(self, evidence: GoalEvidence) -> Factor:
        """Return the log likelihood of every sample."""
        return self.likelihood.log_likelihood(evidence)

    def online(self, dt: float) -> OnlineExpert:
        """Return the likelihood of one observation at a time."""
        return _OnlineLqr(self.likelihood.online(dt))


class _OnlineLqr:
    def __init__(self, likelihood: OnlineLikelihood) -> None:
        self._likelihood = likelihood

    def restart(self, goals: Float[np.ndarray, "goal space"], present: Bool[np.ndarray, " goal"]) -> None:
        """Begin a row with these goals."""
        self._likelihood.restart(goals, present)

    def step(self, observation: Observation, geometry: Geometry) -> Float[np.ndarray, " goal"]:
        """Return the log likelihood of this observation."""
        return self._likelihood.step(observation)
