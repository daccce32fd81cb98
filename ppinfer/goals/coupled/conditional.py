"""The paper's softmax conditional as an expert, to be compared with `Partner`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from ppinfer.goals.conditional import conditional_log_weights
from ppinfer.goals.coupled.expert import GeometryExpert
from ppinfer.goals.coupled.geometry import Geometry
from ppinfer.goals.coupled.partner import partner_goal
from ppinfer.goals.model import LARGEST, require_range

# samples of one pass: tables of goal x goal x goal a sample stay small
BLOCK_SAMPLES = 8192


@dataclass(frozen=True)
class Conditional(GeometryExpert):
    """Algorithm 1's conditional prediction, averaged over the partner's goal.

    log weight_i = log sum_R q(R) sum_j p(i | j, R) / n, with q the belief over the partner's goal as in `Partner`, the
    prior goal j any of the n present, and

        p(i | j, R) = softmax_i( -human_weight |theta_i - x| + robot_weight |theta_i - theta_R|
                                 - stay_weight |theta_i - theta_j| )

    (the paper's rationality beta_c is a factor of all three weights). Summed over partners.

    Parameters
    ----------
    human_weight, robot_weight, stay_weight : float
        beta_c w1, beta_c w2, beta_c w3, per m or the log's unit of position.
    distance, closing : float
        Of the belief over the partner's goal; see `Partner`.

    Raises
    ------
    ModelError
        Where a parameter is out of its range.

    Examples
    --------
    >>> Conditional().needs_partner
    True
    """

    name: ClassVar[str] = "conditional"
    needs_partner: ClassVar[bool] = True
    fitted: ClassVar[dict[str, str]] = {
        "human_weight": "log",
        "robot_weight": "log",
        "stay_weight": "log",
        "distance": "linear",
        "closing": "linear",
    }

    human_weight: float = 0.3
    robot_weight: float = 0.3
    stay_weight: float = 0.1
    distance: float = 0.47
    closing: float = 0.656

    def __post_init__(self) -> None:
        for name in ("human_weight", "robot_weight", "stay_weight"):
            require_range(f"conditional.{name}", getattr(self, name), 0.0, LARGEST)
        for name in ("distance", "closing"):
            require_range(f"conditional.{name}", getattr(self, name), -LARGEST, LARGEST)

    def log_weights(self, geometry: Geometry) -> Float[np.ndarray, "sample goal"]:
        """Return the log of the conditional averaged over prior goals and partners' goals."""
        q = np.exp(partner_goal(geometry, distance=self.distance, closing=self.closing))
        total = np.zeros_like(geometry.distance)
        for start in range(0, len(total), BLOCK_SAMPLES):
            block = slice(start, start + BLOCK_SAMPLES)
            row = geometry.row[block]
            present = geometry.present[row]
            log_conditional = conditional_log_weights(
                geometry.goals[row],
                geometry.position[block],
                human_weight=self.human_weight,
                robot_weight=self.robot_weight,
                stay_weight=self.stay_weight,
                rationality=1.0,
                present=present,
            )
            prior = present / present.sum(axis=1, keepdims=True)
            post = np.einsum("sj,sjri->sri", prior, np.exp(log_conditional))
            for partner, known in zip(q[:, block], geometry.partner_known[:, block], strict=True):
                weights = np.einsum("sr,sri->si", partner, post)
                told = present & known[:, None]
                # no weight of a goal that is present is zero unless it underflows; then the least number stands for it
                np.maximum(weights, np.finfo(np.float64).tiny, out=weights)
                total[block] += np.where(told, np.log(weights), 0.0)
        return total
