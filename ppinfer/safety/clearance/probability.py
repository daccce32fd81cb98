"""The probability that a plan stays clear, given a posterior over what others will do."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from ppinfer.distributions import Distribution
from ppinfer.errors import SafetyError
from ppinfer.safety.clearance.bodies import PlanBodies, plan_distances


@dataclass(frozen=True, eq=False)
class ClearProbability:
    """The probability that each of an agent's plans stays clear, and how near the others may come.

    Parameters
    ----------
    clear : (plan,) float64
        Exact where bodies are where their plans have them; else the mean over rollouts.
    standard_error : (plan,) float64
        Of that mean; 0 where it is exact.
    distance : tuple of (plan, other plan) float64
        For each of the others the smallest distance over the horizon without noise, m.
    """

    clear: Float[np.ndarray, " plan"]
    standard_error: Float[np.ndarray, " plan"]
    distance: tuple[Float[np.ndarray, "plan _"], ...]

    def is_clear(self, eps: float = 0.05) -> np.ndarray:
        """Return whether each plan stays clear with probability at least 1 - eps, (plan,) bool."""
        # sums of probabilities are off by a rounding
        return self.clear >= 1.0 - eps - 1e-9


def clear_probability(
    own: PlanBodies,
    others: Sequence[tuple[PlanBodies, Any]],
    *,
    margin: float = 0.0,
    obstacles: PlanBodies | None = None,
    noise: Any = 0.0,
    rollouts: int = 1000,
    rng: np.random.Generator | None = None,
) -> ClearProbability:
    """Return the probability that each of an agent's plans stays clear of the others by more than a margin.

    Where bodies follow their plans, this is a sum over the others' plans, without sampling: others that choose
    independently, with distances D to plan i,

        P(i clear) = prod_others sum_j p(j) 1[D_ij > margin].

    With noise it is the mean of that over rollouts, in each of which every other's body is displaced by an offset of
    its own that lasts: z times the noise of the step, z ~ N(0, I). The rollouts are the same for all plans.

    Parameters
    ----------
    own : PlanBodies
        Of the agent that asks.
    others : sequence of (PlanBodies, probabilities)
        For each of the others its plans and their (plan,) probabilities, an array or a Distribution over one axis.
    margin : float
        m.
    obstacles : PlanBodies, optional
        What is there for certain, without noise: one plan; see `PlanBodies.still`.
    noise : float or (step,) array
        Standard deviation, m, of the others' bodies about their plans in each dimension, by step.
    rollouts : int
        How many, where there is noise.
    rng : numpy.random.Generator, optional
        Needed where there is noise.

    Raises
    ------
    SafetyError
        Where shapes disagree, probabilities are no distribution, a number is out of its range, or there is noise and
        no generator.

    Examples
    --------
    The other one comes towards us with probability .3, else it waits far away:

    >>> right, left = np.linspace([0.0, 0.0], [4.0, 0.0], 5), np.linspace([4.0, 0.0], [0.0, 0.0], 5)
    >>> own = PlanBodies.points(np.stack([right, 0.0 * right]), radius=0.2)
    >>> other = PlanBodies.points(np.stack([left + [0.0, 0.5], np.full((5, 2), 9.0)]), radius=0.2)
    >>> found = clear_probability(own, [(other, [0.3, 0.7])], margin=0.2)
    >>> found.clear, found.is_clear(eps=0.05)
    (array([0.7, 0.7]), array([False, False]))
    >>> clear_probability(own, [(other, [0.3, 0.7])]).clear
    array([1., 1.])
    """
    if not math.isfinite(margin):
        raise SafetyError(f"margin must be finite (m); got {margin!r}")
    spread = np.asarray(noise, np.float64)
    count, space = own.ends.shape[1], own.ends.shape[4]
    if spread.shape not in ((), (count,)) or not np.isfinite(spread).all() or (spread < 0).any():
        raise SafetyError(
            f"noise must be a number of metres, or one for each of {count} steps; got {noise!r}"
        )
    noisy = bool(spread.any())
    if noisy and (rng is None or rollouts < 2):
        raise SafetyError("with noise, give a random generator and at least 2 rollouts")
    distance = tuple(plan_distances(own, bodies) for bodies, _ in others)
    chance = np.ones((rollouts if noisy else 1, own.plans))
    if obstacles is not None:
        if obstacles.plans != 1:
            raise SafetyError(f"obstacles have one plan, which is not to move; got {obstacles.plans}")
        chance *= plan_distances(own, obstacles)[:, 0] > margin
    for (bodies, belief), apart in zip(others, distance, strict=True):
        probability = _probabilities(belief, bodies.plans)
        if noisy and rng is not None:
            offset = rng.standard_normal((rollouts, 1, space))
            shift = offset * np.broadcast_to(spread, (count,))[None, :, None]
            apart = plan_distances(own, bodies, shift=shift)
        chance *= (apart > margin) @ probability
    error = chance.std(axis=0, ddof=1) / math.sqrt(rollouts) if noisy else np.zeros(own.plans)
    # rounding: probabilities that sum to one may sum to a little more
    return ClearProbability(np.minimum(chance.mean(axis=0), 1.0), error, distance)


def _probabilities(belief: Any, plans: int) -> Float[np.ndarray, " plan"]:
    if isinstance(belief, Distribution):
        belief = belief.values
    probability = np.asarray(belief, np.float64)
    if (
        probability.shape != (plans,)
        or not (probability >= 0).all()
        or not abs(probability.sum() - 1.0) < 1e-9
    ):
        raise SafetyError(
            f"probabilities over {plans} plans must be that many numbers that sum to 1; got {belief!r}"
        )
    return probability
