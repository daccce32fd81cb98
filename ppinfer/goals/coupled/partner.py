"""The partner expert: two agents do not pick the same goal, and where the partner is heading shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from ppinfer.goals.coupled.expert import GeometryExpert
from ppinfer.goals.coupled.geometry import Geometry
from ppinfer.goals.model import LARGEST, require_range


@dataclass(frozen=True)
class Partner(GeometryExpert):
    """The partner's goal is inferred, and is not the person's: log weight log(1 - q_g).

    q = softmax(-distance d + closing v) is the belief over the partner's goal, with d the partner's distance to a goal
    and v the speed at which it comes nearer. log(1 - q_g) is the exact marginal of "the two never pick the same goal".
    Summed over partners; one that has not been seen says nothing, and where there is one goal only it is shared.

    Parameters
    ----------
    distance : float
        Per m, or per the log's unit of position.
    closing : float
        Per m/s, or per that unit and second.

    Raises
    ------
    ModelError
        Where a parameter is not finite.

    Examples
    --------
    >>> Partner().parameters
    {'distance': 0.47, 'closing': 0.656}
    """

    name: ClassVar[str] = "partner"
    needs_partner: ClassVar[bool] = True
    fitted: ClassVar[dict[str, str]] = {"distance": "linear", "closing": "linear"}

    distance: float = 0.47
    closing: float = 0.656

    def __post_init__(self) -> None:
        require_range("partner.distance", self.distance, -LARGEST, LARGEST)
        require_range("partner.closing", self.closing, -LARGEST, LARGEST)

    def log_weights(self, geometry: Geometry) -> Float[np.ndarray, "sample goal"]:
        """Return the sum of log(1 - q) over partners."""
        log_q = partner_goal(geometry, distance=self.distance, closing=self.closing)
        left = log_others(log_q)
        left *= geometry.partner_known[..., None]
        total: np.ndarray = left.sum(axis=0)
        return total


def partner_goal(
    geometry: Geometry, *, distance: float, closing: float
) -> Float[np.ndarray, "partner sample goal"]:
    """Return the log belief over each partner's goal: softmax(-distance d + closing v), -inf for absent goals.

    Examples
    --------
    >>> from ppinfer.goals import GoalEvidence
    >>> from ppinfer.goals.partners import PartnerMotion
    >>> evidence = GoalEvidence(
    ...     time=np.zeros(1), position=np.zeros((1, 2)), goals=np.array([[[1.0, 0.0], [3.0, 0.0]]]),
    ...     row_size=np.array([1]), goal_labels=("cup", "bowl"), partners=(PartnerMotion("robot", np.zeros((1, 2))),),
    ... )
    >>> np.exp(partner_goal(evidence.geometry, distance=0.5, closing=0.0)).round(3)
    array([[[0.731, 0.269]]])
    """
    from ppinfer.goals.coupled.scans import partner_goals

    log_q = np.empty_like(geometry.partner_distance)
    partner_goals(
        geometry.partner_distance,
        geometry.partner_closing,
        distance,
        closing,
        geometry.present,
        geometry.row,
        log_q,
    )
    return log_q


def log_others(log_q: Float[np.ndarray, "partner sample goal"]) -> Float[np.ndarray, "partner sample goal"]:
    """Return log(1 - q_g) as the log of the sum over the other goals, which keeps its digits where q_g is nearly 1.

    Zero where there is no other goal.

    Examples
    --------
    >>> log_others(np.array([[[-1e-30, -69.0]]]))[0, 0, 0]
    np.float64(-69.0)
    >>> log_others(np.array([[[0.0, -np.inf]]]))[0, 0, 0]
    np.float64(0.0)
    """
    from ppinfer.goals.coupled.scans import log_of_the_others

    out = np.empty_like(log_q)
    log_of_the_others(log_q, out)
    return out
