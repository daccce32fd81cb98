"""What counted rollouts tell about the probability of staying safe, and with which confidence."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.errors import SafetyError


def clopper_pearson_lower(safe: Any, rollouts: int, confidence: float = 0.99) -> Any:
    """Return the one-sided Clopper-Pearson lower bound on a probability, of which `safe` of `rollouts` came true.

    Whatever the true probability p is, the bound exceeds it with a chance of at most 1 - confidence: it is the p at
    which as many successes or more have just that chance, a quantile of Beta(safe, rollouts - safe + 1).

    Parameters
    ----------
    safe : int or array of int
        How many came true.
    rollouts : int
        Of how many independent ones.
    confidence : float
        In (0, 1).

    Returns
    -------
    float or array of float64
        The bound, for every count.

    Examples
    --------
    >>> round(clopper_pearson_lower(966, 1000), 4), clopper_pearson_lower(0, 10)
    (0.9502, 0.0)
    """
    # imported here: nothing else that is imported with goals needs it
    from scipy.special import betaincinv

    count = np.asarray(safe, dtype=np.float64)
    bound = np.where(
        count > 0, betaincinv(np.maximum(count, 1.0), rollouts - count + 1.0, 1.0 - confidence), 0.0
    )
    return float(bound) if bound.ndim == 0 else bound


def clopper_pearson_upper(violated: Any, rollouts: int, confidence: float = 0.95) -> Any:
    """Return the one-sided Clopper-Pearson upper bound on a probability, of which `violated` of `rollouts` came true.

    Examples
    --------
    >>> bool(clopper_pearson_upper(38, 1000) <= 0.05 < clopper_pearson_upper(39, 1000))
    True
    """
    return 1.0 - clopper_pearson_lower(rollouts - np.asarray(violated), rollouts, confidence)


@lru_cache(maxsize=256)
def least_safe(rollouts: int, eps: float = 0.05, confidence: float = 0.99, among: int = 1) -> int:
    """Return how many of the rollouts must stay safe for the lower bound to reach 1 - eps; one more than all if none.

    Parameters
    ----------
    rollouts : int
        How many there are.
    eps : float
        Tolerated probability of a violation, in (0, 1).
    confidence : float
        With which 1 - eps is to be claimed, in (0, 1).
    among : int
        Among how many candidates the plan may be chosen by its own count: the Bonferroni correction.

    Raises
    ------
    SafetyError
        Where an argument is out of its range.

    Examples
    --------
    >>> least_safe(1000), least_safe(1000, among=50), least_safe(50)
    (966, 974, 51)
    """
    if rollouts < 1 or among < 1 or not 0.0 < eps < 1.0 or not 0.0 < confidence < 1.0:
        raise SafetyError(
            f"rollouts and among must be at least 1, eps and confidence in (0, 1); got {rollouts!r}, {among!r}, "
            f"{eps!r}, {confidence!r}"
        )
    counts = np.arange(rollouts + 1)
    enough = clopper_pearson_lower(counts, rollouts, 1.0 - (1.0 - confidence) / among) >= 1.0 - eps
    return int(np.argmax(enough)) if enough.any() else rollouts + 1


@dataclass(frozen=True)
class SafeProbability:
    """How many rollouts of one plan stayed safe.

    Parameters
    ----------
    safe : int
        Rollouts without a violation.
    rollouts : int
        Of how many, independent of each other and of how the plan was chosen (otherwise see `among`).

    Examples
    --------
    >>> found = SafeProbability(970, 1000)
    >>> found.estimate, round(found.lower(), 3), found.is_safe(), found.is_safe(among=50)
    (0.97, 0.955, True, False)
    """

    safe: int
    rollouts: int

    @property
    def estimate(self) -> float:
        """mean(F), which the printed algorithm compares with 1 - eps: with no confidence in particular."""
        return self.safe / self.rollouts

    def lower(self, confidence: float = 0.99, among: int = 1) -> float:
        """Return the one-sided Clopper-Pearson lower bound; `among` candidates share 1 - confidence (Bonferroni)."""
        return float(clopper_pearson_lower(self.safe, self.rollouts, 1.0 - (1.0 - confidence) / among))

    def is_safe(self, eps: float = 0.05, confidence: float = 0.99, among: int = 1) -> bool:
        """Return whether a probability of staying safe of at least 1 - eps can be claimed with that confidence."""
        return self.safe >= least_safe(self.rollouts, eps, confidence, among)


@dataclass(frozen=True, eq=False)
class SafeProbabilities:
    """How many rollouts of each candidate plan stayed safe; all candidates met the same rollouts of the others.

    Parameters
    ----------
    safe : (candidate,) int64
        Rollouts without a violation.
    rollouts : int
        Of how many.

    Examples
    --------
    >>> found = SafeProbabilities(np.array([960, 990]), 1000)
    >>> found.is_safe(), found[1].estimate
    (array([False,  True]), 0.99)
    """

    safe: Int[np.ndarray, " candidate"]
    rollouts: int

    def __len__(self) -> int:
        return len(self.safe)

    def __getitem__(self, candidate: int) -> SafeProbability:
        return SafeProbability(int(self.safe[candidate]), self.rollouts)

    @property
    def estimate(self) -> Float[np.ndarray, " candidate"]:
        """mean(F) of every candidate."""
        share: np.ndarray = self.safe / self.rollouts
        return share

    def lower(self, confidence: float = 0.99, among: int | None = None) -> Float[np.ndarray, " candidate"]:
        """Return lower bounds that hold for all candidates at once; `among` is their number unless it is given."""
        shared = 1.0 - (1.0 - confidence) / (among or max(len(self), 1))
        bound: np.ndarray = clopper_pearson_lower(self.safe, self.rollouts, shared)
        return bound

    def is_safe(
        self, eps: float = 0.05, confidence: float = 0.99, among: int | None = None
    ) -> Bool[np.ndarray, " candidate"]:
        """Return for which candidates 1 - eps can be claimed, whichever of them is chosen."""
        enough: np.ndarray = self.safe >= least_safe(
            self.rollouts, eps, confidence, among or max(len(self), 1)
        )
        return enough
