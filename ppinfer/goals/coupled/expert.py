"""What an expert is: a small model of one thing that tells of a person's goal."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from typing import Any, ClassVar, Protocol, cast, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Factor
from ppinfer.goals.coupled.geometry import Geometry
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.model import Observation


@runtime_checkable
class OnlineExpert(Protocol):
    """An expert's log weights for one observation after another, within one row."""

    def restart(self, goals: Float[np.ndarray, "goal space"], present: Bool[np.ndarray, " goal"]) -> None:
        """Begin a row with these goals."""

    def step(self, observation: Observation, geometry: Geometry) -> Float[np.ndarray, " goal"]:
        """Return the log weights now; anything where a goal is absent."""


class Expert(ABC):
    """One factor of `GoalCoupled`: a causal log factor over (sample, goal), and the same for one observation at a time.

    Subclasses are frozen dataclasses of numbers. An expert either gathers evidence (``gathers``: what it says of a
    sample is the likelihood of that sample, and adds up in the belief as time passes) or judges each instant by itself
    (what it says of a sample holds for that sample only). Most look at nothing but distances and speeds: see
    `GeometryExpert`. `ppinfer.testing.check_expert` holds one to the laws.

    Attributes
    ----------
    name : str
        What ``experts=...`` calls it.
    gathers : bool
        Whether its evidence adds up over the row.
    needs_partner : bool
        Whether it looks at other agents.
    fitted : dict
        The parameters that may be fitted, with their scale: ``log`` for positive numbers, ``logit`` for shares,
        ``linear`` for any number.
    """

    name: ClassVar[str] = "custom"
    gathers: ClassVar[bool] = False
    needs_partner: ClassVar[bool] = False
    fitted: ClassVar[dict[str, str]] = {}

    @abstractmethod
    def log_factor(self, evidence: GoalEvidence) -> Factor:
        """Return the log weights, a Factor over (sample, goal), -inf exactly where a goal is absent.

        Up to a constant for each sample. An expert that gathers says 0 at dropouts; one that judges the instant goes by
        where everybody was last seen.
        """

    @abstractmethod
    def online(self, dt: float) -> OnlineExpert:
        """Return the same for one observation at a time; `dt` is the nominal time step in s."""

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters by name."""
        return {entry.name: getattr(self, entry.name) for entry in dataclasses.fields(cast(Any, self))}


class GeometryExpert(Expert):
    """An expert that looks at distances, directions and speeds only, and is one formula of them.

    Examples
    --------
    A person who never goes beyond some distance:

    >>> @dataclasses.dataclass(frozen=True)
    ... class Reach(GeometryExpert):
    ...     name = "reach"
    ...     fitted = {"weight": "linear"}
    ...     weight: float = 1.0
    ...     def log_weights(self, geometry):
    ...         return -self.weight * (geometry.distance > 5.0)
    >>> from ppinfer.testing import check_expert
    >>> check_expert(Reach(), examples=3)
    """

    @abstractmethod
    def log_weights(self, geometry: Geometry) -> Float[np.ndarray, "sample goal"]:
        """Return the log weight of every goal at every sample; anything where a goal is absent or nobody was seen."""

    def log_factor(self, evidence: GoalEvidence) -> Factor:
        """Return the log weights, 0 where the agent has not been seen (or, if they gather, made no step)."""
        geometry = evidence.geometry
        log_values = self._told(geometry)
        if not geometry.present.all():
            log_values = np.where(geometry.present_at, log_values, -np.inf)
        return Factor((evidence.sample_axis, evidence.goal_axis), log_values)

    def online(self, dt: float) -> OnlineExpert:
        """Return the same formula for one observation at a time."""
        return _OnlineGeometryExpert(self)

    def _told(self, geometry: Geometry) -> Float[np.ndarray, "sample goal"]:
        telling = geometry.stepped if self.gathers else geometry.known
        log_values = self.log_weights(geometry)
        return log_values if telling.all() else np.where(telling[:, None], log_values, 0.0)


class _OnlineGeometryExpert:
    def __init__(self, expert: GeometryExpert) -> None:
        self._expert = expert

    def restart(self, goals: Float[np.ndarray, "goal space"], present: Bool[np.ndarray, " goal"]) -> None:
        """Begin a row; the geometry knows."""

    def step(self, observation: Observation, geometry: Geometry) -> Float[np.ndarray, " goal"]:
        """Return the log weights now."""
        now: np.ndarray = self._expert._told(geometry)[0]
        return now
