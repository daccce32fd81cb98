"""Bodies made of capsules, along plans, and how near those of two agents come."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from ppinfer.errors import SafetyError


@dataclass(frozen=True, eq=False, init=False)
class PlanBodies:
    """Where the capsules that an agent is made of are, at every step of each of its plans.

    Parameters
    ----------
    ends : (plan, step, capsule, 2, space) float64
        Both ends of each capsule's axis (m), at steps the same for all agents: the first is one step from now.
    radius : (capsule,) float64
        Of each capsule (m); one number for all.
    steps : (plan,) int64, optional
        For how many steps the body is there: who has finished leaves. Default: for all of them.

    Raises
    ------
    SafetyError
        Where shapes disagree, a number is not finite, or a radius or a count of steps is out of its range.

    Examples
    --------
    A disc that moves to the right, and one that stays:

    >>> PlanBodies.points(np.array([[[1.0, 0.0], [2.0, 0.0]], [[0.0, 0.0], [0.0, 0.0]]]), radius=0.3).plans
    2
    """

    ends: Float[np.ndarray, "_ _ _ 2 _"]
    radius: Float[np.ndarray, " _"]
    steps: Int[np.ndarray, " _"]

    def __init__(self, ends: Any, radius: Any, steps: Any = None) -> None:
        ends = np.ascontiguousarray(ends, np.float64)
        if ends.ndim != 5 or ends.shape[3] != 2 or not ends.shape[4]:
            raise SafetyError(f"ends must have shape (plan, step, capsule, 2, space); got {ends.shape}")
        plans, count, capsules = ends.shape[:3]
        try:
            radius = np.ascontiguousarray(np.broadcast_to(np.asarray(radius, np.float64), (capsules,)))
        except ValueError as error:
            raise SafetyError(
                f"there are {capsules} capsules; radius has shape {np.shape(radius)}"
            ) from error
        steps = np.full(plans, count) if steps is None else np.asarray(steps)
        if steps.shape != (plans,) or steps.dtype.kind not in "iu" or ((steps < 0) | (steps > count)).any():
            raise SafetyError(f"steps must be {plans} integers from 0 to {count}; got {steps!r}")
        if not np.isfinite(ends).all() or not np.isfinite(radius).all() or (radius < 0).any():
            raise SafetyError("ends must be finite, and radii finite and not negative")
        # frozen for everybody else
        vars(self).update(ends=ends, radius=radius, steps=steps.astype(np.int64))

    @classmethod
    def points(cls, positions: Any, *, radius: Any = 0.0, steps: Any = None) -> PlanBodies:
        """Return the bodies of an agent that is a disc (or ball) about a point: positions (plan, step, space)."""
        positions = np.asarray(positions, np.float64)
        if positions.ndim != 3:
            raise SafetyError(f"positions must have shape (plan, step, space); got {positions.shape}")
        return cls(np.stack([positions, positions], axis=2)[:, :, None], radius, steps)

    @classmethod
    def still(cls, ends: Any, radius: Any, *, steps: int) -> PlanBodies:
        """Return static capsules, (capsule, 2, space), as one plan of so many steps: walls and other obstacles.

        Examples
        --------
        >>> PlanBodies.still([[[0.0, 0.0], [0.0, 1.0]]], 0.1, steps=5).ends.shape
        (1, 5, 1, 2, 2)
        """
        ends = np.asarray(ends, np.float64)
        return cls(np.broadcast_to(ends, (1, steps, *ends.shape)), radius)

    @property
    def plans(self) -> int:
        """How many plans there are."""
        return len(self.ends)

    def take(self, plans: Any) -> PlanBodies:
        """Return some of the plans, by number."""
        index = np.asarray(plans, np.int64)
        return PlanBodies(self.ends[index], self.radius, self.steps[index])


def plan_distances(
    own: PlanBodies, other: PlanBodies, *, shift: Float[np.ndarray, "rollout step space"] | None = None
) -> Float[np.ndarray, "..."]:
    """Return the smallest distance between two agents for each pair of their plans, m; negative where they overlap.

    Only the steps count at which both are there; inf where there is none.

    Parameters
    ----------
    own, other : PlanBodies
        At the same steps.
    shift : (rollout, step, space) float64, optional
        By how much the other's body is away from where its plan has it (m), in each of some rollouts.

    Returns
    -------
    (plan, other plan) float64
        Or (rollout, plan, other plan) with `shift`.

    Raises
    ------
    SafetyError
        Where the two have other steps or dimensions.

    Examples
    --------
    Two discs meet half way, unless the other one waits:

    >>> right, left = np.linspace([0.0, 0.0], [4.0, 0.0], 5), np.linspace([4.0, 1.0], [0.0, 1.0], 5)
    >>> own = PlanBodies.points(right[None], radius=0.2)
    >>> other = PlanBodies.points(np.stack([left, np.full((5, 2), 9.0)]), radius=0.2)
    >>> plan_distances(own, other).round(3)
    array([[0.6  , 9.896]])
    """
    if own.ends.shape[1] != other.ends.shape[1] or own.ends.shape[4] != other.ends.shape[4]:
        raise SafetyError(
            f"bodies are compared at the same steps in the same space; got {own.ends.shape[1]} steps in "
            f"{own.ends.shape[4]} dimensions and {other.ends.shape[1]} in {other.ends.shape[4]}"
        )
    from ppinfer.safety.clearance.scans import smallest_distances

    away = np.zeros((1, own.ends.shape[1], own.ends.shape[4])) if shift is None else shift
    if away.shape[1:] != (own.ends.shape[1], own.ends.shape[4]) or not np.isfinite(away).all():
        raise SafetyError(f"shift must be finite, of shape (rollout, step, space); got {away.shape}")
    smallest = np.empty((len(away), own.plans, other.plans))
    smallest_distances(
        own.ends,
        own.radius,
        own.steps,
        other.ends,
        other.radius,
        other.steps,
        np.ascontiguousarray(away, np.float64),
        smallest,
    )
    return smallest[0] if shift is None else smallest
