"""Classes of equilibria by whom they favour, and what a class makes of a profile: (8)-(10)."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions.logspace import log_of, log_sum_exp

FAIR = "fair"
"""Label of the class of equilibria that favour nobody by more than a few seconds."""


def favoured_classes(
    costs: Float[np.ndarray, "player ..."],
    among: Bool[np.ndarray, "..."],
    *,
    ties: bool = True,
    fair_within: float | None = None,
) -> Bool[np.ndarray, "theta ..."]:
    """Return which profiles favour whom.

    A profile favours agent i where c_i(a) <= c_j(a) for all j. With `fair_within`, those whose costs all lie that
    close to each other are a class of their own, the last, and favour nobody.

    Parameters
    ----------
    costs : (player, ...) float64
        Seconds, players first.
    among : (...) bool
        The equilibria; nothing else belongs to a class.
    ties : bool
        Whether a profile that costs several agents the same (least) belongs to the class of each; if not, to none.
    fair_within : float, optional
        Seconds.

    Examples
    --------
    >>> costs = np.array([[2.0, 4.0, 3.0], [5.0, 3.0, 3.0]])
    >>> favoured_classes(costs, np.ones(3, bool))
    array([[ True, False,  True],
           [False,  True,  True]])
    >>> favoured_classes(costs, np.ones(3, bool), fair_within=1.0)
    array([[ True, False, False],
           [False, False, False],
           [False,  True,  True]])
    """
    cheapest = costs == costs.min(axis=0)
    if not ties:
        cheapest &= cheapest.sum(axis=0) == 1
    classes: np.ndarray = cheapest & among
    if fair_within is None:
        return classes
    # infinite costs occur only where nothing is an equilibrium
    finite = np.where(among, costs, 0.0)
    fair = among & (finite.max(axis=0) - finite.min(axis=0) <= fair_within)
    return np.concatenate([classes & ~fair, fair[None]])


def log_p_alpha(
    log_belief: Float[np.ndarray, " theta"],
    classes: Bool[np.ndarray, "theta profile"],
    among: Bool[np.ndarray, " profile"],
) -> Float[np.ndarray, " profile"]:
    """Return log p_alpha(a) = log sum_theta p(theta) p(a | theta) of (7), every profile of a class as likely (8).

    Classes without a profile are left out, and p(theta) is renormalised over the others. Where the belief then has
    nothing left to say, every equilibrium is as likely.
    """
    count = classes.sum(axis=1)
    # an empty class holds no profile that this could count for
    share = log_belief - np.log(np.maximum(count, 1))
    weights = log_sum_exp(np.where(classes, share[:, None], -math.inf), (0,))
    peak = weights.max()
    if peak == -math.inf:
        weights = np.where(among, 0.0, -math.inf)
        peak = 0.0
    result: np.ndarray = weights - peak
    result -= math.log(np.exp(result).sum())
    return result


def log_class_likelihood(
    log_profile: Float[np.ndarray, "replan profile"],
    classes: Bool[np.ndarray, "theta replan profile"],
    among: Bool[np.ndarray, "replan profile"],
    *,
    average: bool,
    skip_empty: bool,
) -> Float[np.ndarray, "theta replan"]:
    """Return how likely what was seen is in each class, from how likely it is in each profile (6).

    Parameters
    ----------
    log_profile : (replan, profile) float64
        -lambda_alpha f_dist(a, H).
    classes, among : bool
        The profiles of each class, and the equilibria.
    average : bool
        True: the mean over the class, which is sum_a p(a | theta) p(H | a). False: (9) and (10) as printed, the sum
        over the class for equally likely profiles; a profile of no class says nothing about theta.
    skip_empty : bool
        True: a class without profiles gets the mean of the others, since the game says nothing about it (with two
        classes: no update at all). False: nothing that was seen speaks for it.

    Returns
    -------
    (theta, replan) float64
        Up to a constant for each replan; 0 where there is nothing to learn.
    """
    count = classes.sum(axis=2)
    size = np.maximum(count, 1)
    if average:
        likelihood = log_sum_exp(np.where(classes, log_profile, -math.inf), (2,)) - np.log(size)
    else:
        given_theta = classes / size[:, :, None]
        total = given_theta.sum(axis=0)
        unknown = total == 0.0
        of_profile = np.where(unknown, 1.0 / len(classes), given_theta / np.where(unknown, 1.0, total))
        likelihood = log_sum_exp(np.where(among, log_profile + log_of(of_profile), -math.inf), (2,))
    empty = count == 0
    if skip_empty and empty.any():
        said = np.where(empty, -math.inf, likelihood)
        mean = log_sum_exp(said, (0,)) - np.log(np.maximum((~empty).sum(axis=0), 1))
        likelihood = np.where(empty, mean, likelihood)
    silent = likelihood.max(axis=0) == -math.inf
    if silent.any():
        likelihood = np.where(silent, 0.0, likelihood)
    return likelihood


def contaminated(
    log_likelihood: Float[np.ndarray, "theta replan"], share: float
) -> Float[np.ndarray, "theta replan"]:
    """Return (1 - e) L + e / K, for likelihoods L of K classes scaled to sum to one; times K, so that 0 says nothing.

    That is the likelihood of an agent that, with probability e, acts this once as one of another personality would.

    Examples
    --------
    >>> contaminated(np.array([[0.0], [-1e6]]), 0.04).round(3)
    array([[ 0.673],
           [-3.219]])
    """
    total = log_sum_exp(log_likelihood, (0,))
    scaled: np.ndarray = log_likelihood - total + math.log(len(log_likelihood))
    if share == 0.0:
        return scaled
    mixed: np.ndarray = np.logaddexp(math.log1p(-share) + scaled, math.log(share))
    return mixed
