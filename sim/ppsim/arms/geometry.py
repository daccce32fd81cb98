"""An arm with two joints on a table: where its links are, and which joint angles reach a point."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, radians
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from ppsim.errors import SimulationError


@dataclass(frozen=True)
class Arm:
    """Two links in a plane, each a capsule; its joint angles are (shoulder, elbow) in rad.

    The shoulder's angle is counted from where the arm faces, the elbow's from the upper link. Neither wraps: an angle
    and the same one a full turn on are different configurations, and only one is within the limits.

    Parameters
    ----------
    base : (2,) float
        Where the shoulder is, m.
    heading : float
        Which way the arm faces, rad from the table's x axis.
    links : (2,) float
        Lengths of the upper and the lower link, m.
    radius : float
        Of the capsules, m.
    home : (2,) float
        Where it starts, rad.
    limits : (2,) float
        The largest angle of each joint to either side, rad.
    joint_speed : float
        The largest speed of each joint, rad/s.

    Raises
    ------
    SimulationError
        If a length or speed is not positive, or home is beyond the limits.

    Examples
    --------
    >>> Arm(base=(-0.6, 0.0)).end_effector([0.0, 0.0])
    array([0.4, 0. ])
    """

    base: tuple[float, float]
    heading: float = 0.0
    links: tuple[float, float] = (0.5, 0.5)
    radius: float = 0.05
    home: tuple[float, float] = (radians(75.0), radians(-150.0))
    limits: tuple[float, float] = (pi, 2.7)
    joint_speed: float = 0.25

    def __post_init__(self) -> None:
        sizes = (*self.links, self.radius, *self.limits, self.joint_speed)
        if not all(np.isfinite(size) and size > 0.0 for size in sizes):
            raise SimulationError(
                f"links, radius, limits and joint speed of an arm must be positive and finite; got {self}"
            )
        if not self.within_limits(self.home):
            raise SimulationError(f"home {self.home} rad is beyond the limits of +-{self.limits} rad")

    def points(self, joints: Any) -> Float[np.ndarray, "*batch 3 2"]:
        """Return where shoulder, elbow and end effector are, m.

        Parameters
        ----------
        joints : (*batch, 2) float
            Joint angles, rad.

        Examples
        --------
        >>> Arm(base=(0.0, 0.0)).points([0.0, np.pi / 2]).round(3).tolist()
        [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5]]
        """
        angles = self.heading + np.cumsum(np.asarray(joints, np.float64), axis=-1)
        links = np.stack([np.cos(angles), np.sin(angles)], axis=-1) * np.asarray(self.links)[:, None]
        base = np.broadcast_to(np.asarray(self.base, np.float64), (*links.shape[:-2], 1, 2))
        points: np.ndarray = np.concatenate([base, base + np.cumsum(links, axis=-2)], axis=-2)
        return points

    def end_effector(self, joints: Any) -> Float[np.ndarray, "*batch 2"]:
        """Return where the end effector is, m."""
        return self.points(joints)[..., 2, :]

    def configurations(self, point: Any) -> Float[np.ndarray, "*batch 2 2"]:
        """Return the joint angles that reach a point: first with the elbow's angle positive, then negative.

        1. The law of cosines gives the elbow's angle for the distance from the base.
        2. The shoulder's angle is the bearing of the point less the angle that the bent elbow adds.

        A point that is out of reach, or reached only beyond a limit, has NaN there.

        Parameters
        ----------
        point : (*batch, 2) float
            m.

        Returns
        -------
        (*batch, elbow, joint) float64
            rad.

        Examples
        --------
        >>> arm = Arm(base=(0.0, 0.0))
        >>> arm.end_effector(arm.configurations([0.3, 0.4])).round(3).tolist()
        [[0.3, 0.4], [0.3, 0.4]]
        >>> arm.configurations([3.0, 0.0])[0]
        array([nan, nan])
        """
        apart = np.asarray(point, np.float64) - np.asarray(self.base)
        upper, lower = self.links
        bent = (np.square(apart).sum(axis=-1) - upper**2 - lower**2) / (2.0 * upper * lower)
        # rounding may put a point at the very edge of reach a little beyond it
        bent = np.where(np.abs(bent) <= 1.0 + 1e-12, np.clip(bent, -1.0, 1.0), np.nan)
        elbow = np.arccos(bent)[..., None] * np.array([1.0, -1.0])
        ahead = np.arctan2(lower * np.sin(elbow), upper + lower * np.cos(elbow))
        bearing = np.arctan2(apart[..., 1], apart[..., 0])[..., None]
        shoulder = (bearing - ahead - self.heading + pi) % (2.0 * pi) - pi
        joints: np.ndarray = np.stack([shoulder, elbow], axis=-1)
        joints[~self.within_limits(joints)] = np.nan
        return joints

    def within_limits(self, joints: Any) -> Bool[np.ndarray, "*batch"]:
        """Return whether joint angles are within the arm's limits."""
        within = np.abs(np.asarray(joints, np.float64)) <= np.asarray(self.limits)
        return np.asarray(within.all(axis=-1))


#: The two arms of the study, facing each other across the table.
ARMS = {"robot": Arm(base=(-0.6, 0.0)), "human": Arm(base=(0.6, 0.0), heading=pi)}
