"""The experts of distance: people want what is near, and nearer to them than to their partner."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from ppinfer.goals.coupled.expert import GeometryExpert
from ppinfer.goals.coupled.geometry import Geometry
from ppinfer.goals.model import LARGEST, require_range


@dataclass(frozen=True)
class Distance(GeometryExpert):
    """A goal counts for less the farther it is: log weight -weight d, with d the distance to it.

    Parameters
    ----------
    weight : float
        Per m, or per the log's unit of position.

    Raises
    ------
    ModelError
        Where the weight is not finite.

    Examples
    --------
    >>> Distance(weight=0.5).parameters
    {'weight': 0.5}
    """

    name: ClassVar[str] = "distance"
    fitted: ClassVar[dict[str, str]] = {"weight": "linear"}

    weight: float = 0.297

    def __post_init__(self) -> None:
        require_range("distance.weight", self.weight, -LARGEST, LARGEST)

    def log_weights(self, geometry: Geometry) -> Float[np.ndarray, "sample goal"]:
        """Return -weight d."""
        return -self.weight * geometry.distance


@dataclass(frozen=True)
class Lead(GeometryExpert):
    """A goal counts for more the nearer the person is to it than the partner: weight min(d_partner - d, cap).

    Summed over partners; one that has not been seen says nothing.

    Parameters
    ----------
    weight : float
        Per m, or per the log's unit of position.
    cap : float
        A lead beyond this counts for no more.

    Raises
    ------
    ModelError
        Where a parameter is not finite.

    Examples
    --------
    >>> Lead().needs_partner
    True
    """

    name: ClassVar[str] = "lead"
    needs_partner: ClassVar[bool] = True
    fitted: ClassVar[dict[str, str]] = {"weight": "linear", "cap": "log"}

    weight: float = 0.137
    cap: float = 9.2

    def __post_init__(self) -> None:
        require_range("lead.weight", self.weight, -LARGEST, LARGEST)
        require_range("lead.cap", self.cap, -LARGEST, LARGEST)

    def log_weights(self, geometry: Geometry) -> Float[np.ndarray, "sample goal"]:
        """Return the capped lead over all partners, weighed."""
        lead = np.minimum(geometry.partner_distance - geometry.distance, self.cap)
        lead *= geometry.partner_known[..., None]
        total: np.ndarray = self.weight * lead.sum(axis=0)
        return total
