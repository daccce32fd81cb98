"""What stands still."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ppinfer.errors import SafetyError


@dataclass(frozen=True, eq=False)
class StaticObstacle:
    """Something that does not move, and how near the robot may come to it.

    Parameters
    ----------
    position : (space,) float64
        Its centre (m).
    distance : float
        Least distance of the robot's position from it that counts as safe (m): both radii together.

    Raises
    ------
    SafetyError
        Where a value is not finite, or the distance is negative.

    Examples
    --------
    >>> StaticObstacle([0.0, 3.0], 0.8).distance
    0.8
    """

    position: Float[np.ndarray, " space"] | Sequence[float]
    distance: float

    def __post_init__(self) -> None:
        position = np.array(self.position, dtype=np.float64)
        if position.ndim != 1 or not np.isfinite(position).all():
            raise SafetyError(f"position must be finite numbers, one a dimension; got {self.position!r}")
        if not 0.0 <= self.distance < np.inf:
            raise SafetyError(f"distance must be finite and not negative; got {self.distance!r}")
        position.setflags(write=False)
        object.__setattr__(self, "position", position)


def stack_obstacles(
    obstacles: Sequence[StaticObstacle], space: int
) -> tuple[Float[np.ndarray, "static space"], Float[np.ndarray, " static"]]:
    """Return the positions and distances of obstacles in arrays.

    Raises
    ------
    SafetyError
        Where an obstacle lies in a space of other dimension.
    """
    for index, obstacle in enumerate(obstacles):
        if len(obstacle.position) != space:
            raise SafetyError(
                f"static obstacle {index} has a position of {len(obstacle.position)} entries, the agents of {space}"
            )
    positions = np.array([obstacle.position for obstacle in obstacles], dtype=np.float64)
    return positions.reshape(len(obstacles), space), np.array(
        [one.distance for one in obstacles], dtype=np.float64
    )
