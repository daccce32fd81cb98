"""What a motion tracker makes of the truth: noise, dropouts and outliers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.goals.model import require_range
from ppsim.errors import SimulationError


@dataclass(frozen=True)
class Tracker:
    """A motion tracker, which sees each agent at each sample independently of the others.

    Parameters
    ----------
    noise : float
        Standard deviation (m) of a position about the true one, per dimension.
    dropouts : float
        Share of the samples at which an agent is not seen.
    outliers : float
        Share of the samples seen at which the position is anywhere in the workspace instead.

    Raises
    ------
    SimulationError
        Where the noise is negative or not finite.
    ModelError
        Where a share is not in [0, 1].

    Examples
    --------
    >>> tracker = Tracker(noise=0.01)
    >>> seen, observed = tracker.track(np.zeros((4, 2, 2)), 10.0, np.random.default_rng(0))
    >>> bool(observed.all()), bool((seen != 0).all())
    (True, True)
    """

    noise: float = 0.0
    dropouts: float = 0.0
    outliers: float = 0.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.noise) and self.noise >= 0):
            raise SimulationError(f"noise must be finite and not negative (m); got {self.noise!r}")
        for name in ("dropouts", "outliers"):
            require_range(name, getattr(self, name), 0.0, 1.0)

    def track(
        self, position: Float[np.ndarray, "sample agent 2"], extent: float, rng: np.random.Generator
    ) -> tuple[Float[np.ndarray, "sample agent 2"], Bool[np.ndarray, "sample agent"]]:
        """Return the positions that are logged, NaN at dropouts, and where each agent was seen."""
        # every draw is made whatever the shares, so that one option does not change what another one does
        noise = rng.standard_normal(position.shape)
        chance = rng.random((2, *position.shape[:2]))
        elsewhere = rng.uniform(-extent, extent, position.shape)
        tracked = position + self.noise * noise
        tracked = np.where((chance[0] < self.outliers)[..., None], elsewhere, tracked)
        observed = chance[1] >= self.dropouts
        return np.where(observed[..., None], tracked, np.nan), observed
