"""Distances between segments, and bodies made of capsules."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ppinfer.errors import SafetyError


def segment_distance(
    first_start: Float[np.ndarray, "*#batch space"],
    first_end: Float[np.ndarray, "*#batch space"],
    second_start: Float[np.ndarray, "*#batch space"],
    second_end: Float[np.ndarray, "*#batch space"],
) -> Float[np.ndarray, "*batch"]:
    """Return the least distance between two segments; a segment may be a point.

    Capsules are as far apart as their segments, less both radii.

    Parameters
    ----------
    first_start, first_end, second_start, second_end : (..., space) float64
        Ends of the segments (m), in any number of dimensions; leading axes broadcast.

    Examples
    --------
    >>> one, other = np.array([[0.0, 0.0], [2.0, 0.0]]), np.array([[1.0, 1.0], [1.0, 5.0]])
    >>> segment_distance(one[0], one[1], other[0], other[1])
    array(1.)
    """
    # imported here: compiled
    from ppinfer.safety.scans import segment_gaps

    ends = np.broadcast_arrays(first_start, first_end, second_start, second_end)
    batch, space = ends[0].shape[:-1], ends[0].shape[-1]
    distance = np.empty(batch)
    a, b, c, d = (np.array(end, dtype=np.float64, order="C").reshape(-1, space) for end in ends)
    segment_gaps(np.zeros(space), a, b, c, d, distance.reshape(-1))
    return distance


@dataclass(frozen=True, eq=False)
class Body:
    """Capsules that move with an agent's position and do not turn.

    Parameters
    ----------
    start, end : (capsule, space) float64
        Ends of each capsule's segment, relative to the agent's position (m).
    radius : (capsule,) float64
        Of each capsule (m).

    Raises
    ------
    SafetyError
        Where shapes disagree, a value is not finite, a radius is negative or there is no capsule.

    Examples
    --------
    >>> body = Body([[0.0, -0.2]], [[0.0, 0.2]], [0.1])
    >>> body.reach.round(2)
    array([0.3])
    """

    start: Float[np.ndarray, "capsule space"] | Sequence[Sequence[float]]
    end: Float[np.ndarray, "capsule space"] | Sequence[Sequence[float]]
    radius: Float[np.ndarray, " capsule"] | Sequence[float]

    def __post_init__(self) -> None:
        for name in ("start", "end", "radius"):
            value = np.array(getattr(self, name), dtype=np.float64, order="C")
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        start, end, radius = np.asarray(self.start), np.asarray(self.end), np.asarray(self.radius)
        if start.ndim != 2 or start.shape != end.shape or radius.shape != start.shape[:1] or not len(radius):
            raise SafetyError(
                f"a body needs start and end of one shape (capsule, space) and a radius for each capsule; got "
                f"{start.shape}, {end.shape} and {radius.shape}"
            )
        if not (
            np.isfinite(start).all()
            and np.isfinite(end).all()
            and (radius >= 0).all()
            and np.isfinite(radius).all()
        ):
            raise SafetyError("a body needs finite segments, and radii that are finite and not negative")

    @classmethod
    def point(cls, space: int) -> Body:
        """Return the body of an agent that is nothing but its position."""
        return cls(np.zeros((1, space)), np.zeros((1, space)), np.zeros(1))

    @property
    def reach(self) -> Float[np.ndarray, " capsule"]:
        """How far each capsule reaches from the agent's position (m)."""
        ends = np.maximum(np.linalg.norm(self.start, axis=1), np.linalg.norm(self.end, axis=1))
        reach: np.ndarray = ends + self.radius
        return reach


def body_gap(
    body: Body,
    position: Float[np.ndarray, "*#batch space"],
    other: Body,
    other_position: Float[np.ndarray, "*#batch space"],
) -> Float[np.ndarray, "*batch"]:
    """Return the least distance between the surfaces of two bodies; negative where they overlap.

    Parameters
    ----------
    body, other : Body
        What they look like.
    position, other_position : (..., space) float64
        Where they are (m).

    Examples
    --------
    >>> rod = Body([[0.0, -1.0]], [[0.0, 1.0]], [0.1])
    >>> body_gap(rod, np.array([[0.0, 0.0], [3.0, 0.0]]), Body.point(2), np.array([1.0, 0.5]))
    array([0.9, 1.9])
    """
    own, its = np.asarray(body.radius), np.asarray(other.radius)
    apart = segment_distance(
        position[..., None, None, :] + np.asarray(body.start)[:, None],
        position[..., None, None, :] + np.asarray(body.end)[:, None],
        other_position[..., None, None, :] + np.asarray(other.start),
        other_position[..., None, None, :] + np.asarray(other.end),
    )
    gap: np.ndarray = np.asarray((apart - own[:, None] - its).min(axis=(-2, -1)))
    return gap


def stack_bodies(
    body: Body | None,
    others: Sequence[Body | None],
    distance: Float[np.ndarray, " other"],
    space: int,
) -> tuple[np.ndarray, ...]:
    """Return the capsules of a robot and of others in arrays, where each other's begin, and beyond what all are clear.

    Raises
    ------
    SafetyError
        Where a body is of another dimension.
    """
    own = body or Body.point(space)
    bodies = [one or Body.point(space) for one in others]
    for one in (own, *bodies):
        if np.shape(one.start)[1] != space:
            raise SafetyError(f"a body of {np.shape(one.start)[1]} dimensions moves in {space}")
    first = np.cumsum([0, *(len(one.radius) for one in bodies)])
    empty = np.empty((0, space))
    # a hair more, so that rounding never passes over what is just in reach
    reach = np.array([own.reach.max() + one.reach.max() for one in bodies]) + distance
    return (
        np.asarray(own.start),
        np.asarray(own.end),
        np.asarray(own.radius),
        first.astype(np.int64),
        np.concatenate([empty, *(one.start for one in bodies)]),
        np.concatenate([empty, *(one.end for one in bodies)]),
        np.concatenate([empty[:, 0], *(one.radius for one in bodies)]),
        np.maximum(reach, 0.0) * (1.0 + 1e-9),
    )
