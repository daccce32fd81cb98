"""The motion expert: a person moves towards what they want, more surely so the faster they move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from ppinfer.goals.coupled.expert import GeometryExpert
from ppinfer.goals.coupled.geometry import Geometry
from ppinfer.goals.model import LARGEST, require_range


@dataclass(frozen=True)
class Motion(GeometryExpert):
    """The direction of each step: von Mises about the direction to the goal, or anywhere (an outlier).

    With s the step's speed and cos that of the angle between the step and the direction from where it began to the
    goal, the evidence of a step, relative to that of any direction being as likely as any other, is

        log L = tempering log[ (1 - outliers) exp(kappa cos) / I0(kappa) + outliers ],
        kappa = concentration s / (s + half_speed).

    In three dimensions sinh(kappa) / kappa stands for I0, and in one cosh.

    Parameters
    ----------
    concentration : float
        kappa of a step of boundless speed.
    half_speed : float
        Speed (m/s, or the log's unit of position per second) at which kappa is half of that.
    outliers : float
        Share of steps whose direction tells nothing, in [0, 1].
    tempering : float
        Exponent on the evidence of a step, since steps depend on each other.

    Raises
    ------
    ModelError
        Where a parameter is out of its range.

    Examples
    --------
    >>> Motion().name
    'motion'
    """

    name: ClassVar[str] = "motion"
    gathers: ClassVar[bool] = True
    fitted: ClassVar[dict[str, str]] = {
        "concentration": "log",
        "half_speed": "log",
        "outliers": "logit",
        "tempering": "log",
    }

    concentration: float = 14.0
    half_speed: float = 2.72
    outliers: float = 0.055
    tempering: float = 0.281

    def __post_init__(self) -> None:
        require_range("motion.concentration", self.concentration, 0.0, LARGEST)
        require_range("motion.half_speed", self.half_speed, 0.0, LARGEST)
        require_range("motion.outliers", self.outliers, 0.0, 1.0)
        require_range("motion.tempering", self.tempering, 0.0, LARGEST)

    def log_weights(self, geometry: Geometry) -> Float[np.ndarray, "sample goal"]:
        """Return the log evidence of every step under every goal."""
        # a step of no length has no direction, whatever the half speed
        share = np.divide(
            geometry.speed,
            geometry.speed + self.half_speed,
            out=np.zeros_like(geometry.speed),
            where=geometry.speed > 0,
        )
        kappa = self.concentration * share
        log_density = kappa[:, None] * (geometry.cosine - 1.0)
        log_density -= log_scaled_volume(kappa, geometry.position.shape[1])[:, None]
        if self.outliers > 0:
            np.exp(log_density, out=log_density)
            log_density *= 1.0 - self.outliers
            log_density += self.outliers
            np.log(log_density, out=log_density)
        log_density *= self.tempering
        weighed: np.ndarray = log_density
        return weighed


def log_scaled_volume(kappa: Float[np.ndarray, " sample"], space: int) -> Float[np.ndarray, " sample"]:
    """Return the log of the mean of exp(kappa (cos - 1)) over all directions in 1, 2 or 3 dimensions.

    Examples
    --------
    >>> from scipy.special import i0
    >>> kappa = np.array([0.0, 2.0])
    >>> np.exp(log_scaled_volume(kappa, 2) + kappa) - i0(kappa) < 1e-14
    array([ True,  True])
    """
    if space == 1:
        volume: np.ndarray = np.log1p(np.exp(-2 * kappa)) - np.log(2.0)
        return volume
    if space == 2:
        from scipy.special import i0e

        volume = np.log(i0e(kappa))
        return volume
    twice = 2.0 * kappa
    volume = np.log(np.divide(-np.expm1(-twice), twice, out=np.ones_like(twice), where=twice > 0))
    return volume
