"""What to simulate personalities in: games and plans that are given, and whom each replan's equilibrium favours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from ppinfer.coordination.evidence import PlayEvidence
from ppinfer.errors import ModelError


@dataclass(frozen=True, eq=False)
class PlayDesign:
    """Games, plans and times as one agent saw them, whose motion is to be drawn anew for given personalities.

    Parameters
    ----------
    evidence : PlayEvidence
        Its plans, costs and times are kept; what a model draws replaces positions and velocities.
    theta : (replan,) int64
        Whom the others' equilibrium favours from each of ego's replans to the next, as places on the model's theta
        axis.

    Raises
    ------
    ModelError
        If there is not one theta for each of ego's replans.
    """

    evidence: PlayEvidence
    theta: Int[np.ndarray, " replan"]

    def __post_init__(self) -> None:
        if self.theta.shape != self.evidence.replans.shape:
            raise ModelError(
                f"there are {len(self.evidence.replans)} replans of {self.evidence.ego!r}; theta has shape "
                f"{self.theta.shape}"
            )
