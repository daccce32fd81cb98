"""Choosing the cheapest of many plans that is safe, without believing a count because it was the best of many."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from ppinfer.errors import SafetyError
from ppinfer.safety.long_term import plan_safe_probability
from ppinfer.safety.motion import LinearAgent, Mover
from ppinfer.safety.obstacles import StaticObstacle
from ppinfer.safety.probability import SafeProbabilities, SafeProbability, least_safe


@dataclass(frozen=True, eq=False)
class PlanChoice:
    """Which plan, and what is known about its safety.

    Parameters
    ----------
    plan : int
        The candidate chosen.
    certificate : SafeProbability
        The count that it was accepted by; where it was not accepted, that of the screening.
    flagged : bool
        True where no candidate was accepted: this one only had the largest count.
    screened : SafeProbabilities
        The counts of all candidates on the rollouts that they shared.
    """

    plan: int
    certificate: SafeProbability
    flagged: bool
    screened: SafeProbabilities


def choose_safe_plan(
    plans: Float[np.ndarray, "candidate instant space"],
    costs: Float[np.ndarray, " candidate"],
    others: Sequence[Mover],
    *,
    method: Literal["fresh", "bonferroni"] = "fresh",
    attempts: int = 2,
    eps: float = 0.05,
    confidence: float = 0.99,
    distance: float | Sequence[float] = 1.0,
    rollouts: int = 1000,
    static: Sequence[StaticObstacle] = (),
    robot: LinearAgent | None = None,
    rng: np.random.Generator,
) -> PlanChoice:
    """Choose the cheapest plan that stays safe with probability 1 - eps, at the confidence stated.

    A plan whose probability is below 1 - eps is accepted with a chance of at most 1 - confidence, however many
    candidates there are:

    - "bonferroni": all candidates share one set of rollouts, and each has to pass at 1 - (1 - confidence) / candidates;
    - "fresh": the shared rollouts only screen. The cheapest that passes there is looked at again on rollouts that had
      no part in its choice, and accepted by these alone; if it fails the next one is, up to `attempts` of them, which
      share 1 - confidence.

    Parameters
    ----------
    plans : (candidate, instant, space) float64
        Positions at t = 0..H (m).
    costs : (candidate,) float64
        The less the better; `inf` for what is not to be chosen while anything else is safe.
    others, distance, rollouts, static, robot, rng
        As of `plan_safe_probability`.
    method : {"fresh", "bonferroni"}
        See above.
    attempts : int
        How many candidates may be looked at afresh.
    eps, confidence : float
        What is claimed.

    Returns
    -------
    PlanChoice
        Flagged, with the plan of the largest count, where none is accepted.

    Raises
    ------
    SafetyError
        Where shapes or counts do not fit, there is no candidate, or the method is unknown.

    Examples
    --------
    >>> walker = LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1), noise=0.0004 * np.eye(2))
    >>> human = Mover(walker, np.array([4.0, 0.0]), np.array([[-4.0, 0.0]]), np.array([1.0]))
    >>> away = np.linspace(0.0, 1.0, 21)[:, None] * np.array([0.0, 1.0])
    >>> plans = np.stack([0.0 * away, 8.0 * away, 9.0 * away])
    >>> choice = choose_safe_plan(plans, np.array([0.0, 1.0, 2.0]), [human], rng=np.random.default_rng(0))
    >>> choice.plan, choice.flagged, choice.screened.is_safe()
    (1, False, array([False,  True,  True]))
    """
    costs = np.asarray(costs, dtype=np.float64)
    if costs.shape != (len(plans),) or not len(plans) or np.isnan(costs).any():
        raise SafetyError(f"give one cost, and no NaN, for each of at least one plan; got {costs.shape}")
    if method not in ("fresh", "bonferroni") or attempts < 1:
        raise SafetyError(
            f"method must be 'fresh' or 'bonferroni' and attempts at least 1; got {method!r} and {attempts!r}"
        )

    def count(some: Float[np.ndarray, "some instant space"]) -> SafeProbabilities:
        return plan_safe_probability(
            some, others, distance=distance, rollouts=rollouts, static=static, robot=robot, rng=rng
        )

    screened = count(plans)
    among = len(plans) if method == "bonferroni" else 1
    passed = np.flatnonzero(screened.is_safe(eps, confidence, among=among) & (costs < np.inf))
    cheapest = passed[np.argsort(costs[passed], kind="stable")].tolist()
    if method == "bonferroni":
        if len(cheapest):
            return PlanChoice(cheapest[0], screened[cheapest[0]], False, screened)
    else:
        # each attempt has rollouts of its own: those of the last one had a part in going on to the next
        needed = least_safe(rollouts, eps, confidence, attempts)
        for plan in cheapest[:attempts]:
            certificate = count(plans[plan : plan + 1])[0]
            if certificate.safe >= needed:
                return PlanChoice(plan, certificate, False, screened)
    best = int(np.lexsort((costs, -screened.safe))[0])
    return PlanChoice(best, screened[best], True, screened)
