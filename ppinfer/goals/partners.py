"""The other agents of a workspace: what was seen of them at the samples of the agent whose goals are inferred."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.errors import LogError


@dataclass(frozen=True, eq=False)
class PartnerMotion:
    """The motion of another agent, at the same samples as the evidence that holds it.

    Parameters
    ----------
    name : str
        What the log calls the agent.
    position : (sample, space) float64
        Position (m, or the log's unit); anything where `observed` is false.
    observed : (sample,) bool, optional
        False where this agent was not seen; default: always seen.
    velocity, control : (sample, space) float64, optional
        As logged.
    control_order : {1, 2, None}
        What the control is; see `GoalEvidence`.

    Raises
    ------
    LogError
        Where sizes disagree, or a position is not finite although it was observed.

    Examples
    --------
    >>> PartnerMotion("robot", np.zeros((3, 2))).samples
    3
    """

    name: str
    position: Float[np.ndarray, "sample space"]
    observed: Bool[np.ndarray, " _"] | None = None
    velocity: Float[np.ndarray, "_ _"] | None = None
    control: Float[np.ndarray, "_ _"] | None = None
    control_order: int | None = 2

    def __post_init__(self) -> None:
        for name in ("position", "velocity", "control"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, np.ascontiguousarray(value, dtype=np.float64))
        if self.observed is not None:
            object.__setattr__(self, "observed", np.ascontiguousarray(self.observed, dtype=np.bool_))
        if self.position.ndim != 2:
            raise LogError(
                f"partner {self.name!r}: position has shape {self.position.shape}; expected (sample, space)"
            )
        expected = {"observed": (self.samples,), "velocity": self.position.shape, "control": (self.samples,)}
        for name, shape in expected.items():
            value = getattr(self, name)
            if value is not None and value.shape[: len(shape)] != shape:
                raise LogError(
                    f"partner {self.name!r}: {name} has shape {value.shape}; expected {shape} as its positions"
                )
        wrong = ~np.isfinite(self.position).all(axis=1) & self.seen
        if wrong.any():
            raise LogError(
                f"partner {self.name!r}: position is not finite at sample {int(np.argmax(wrong))}; mark dropouts as "
                "not observed"
            )

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.position)

    @cached_property
    def seen(self) -> Bool[np.ndarray, " sample"]:
        """`observed`, spelled out."""
        return np.ones(self.samples, dtype=bool) if self.observed is None else self.observed

    def check_velocity(self) -> None:
        """Refuse a velocity that no model can look at; those that look at none do not ask.

        Raises
        ------
        LogError
            Where a logged velocity is not finite although the agent was observed.

        Examples
        --------
        >>> PartnerMotion("robot", np.zeros((3, 2)), velocity=np.ones((3, 2))).check_velocity()
        """
        if self.velocity is None:
            return
        wrong = ~np.isfinite(self.velocity).all(axis=1) & self.seen
        if wrong.any():
            raise LogError(
                f"partner {self.name!r}: velocity is not finite at sample {int(np.argmax(wrong))}; mark dropouts as "
                "not observed, or leave out all velocities"
            )

    def take_samples(self, index: Int[np.ndarray, " taken"]) -> PartnerMotion:
        """Return the motion at some samples.

        Examples
        --------
        >>> PartnerMotion("robot", np.zeros((3, 2))).take_samples(np.array([0, 2])).samples
        2
        """
        return PartnerMotion(
            self.name,
            self.position[index],
            None if self.observed is None else self.observed[index],
            None if self.velocity is None else self.velocity[index],
            None if self.control is None else self.control[index],
            self.control_order,
        )
