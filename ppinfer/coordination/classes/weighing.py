"""What a class makes of a profile, and what motion that fits a profile makes of its class: (7)-(10)."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float


def log_p_alpha(
    log_belief: Float[np.ndarray, " theta"],
    classes: Bool[np.ndarray, "theta profile"],
    among: Bool[np.ndarray, " profile"],
) -> Float[np.ndarray, " profile"]:
    """Return log p_alpha(a) = log sum_theta p(theta) p(a | theta) of (7), every profile of a class as likely (8).

    Classes without a profile are left out, and p(theta) is renormalised over the others. Where the belief then has
    nothing left to say, every equilibrium is as likely.

    Parameters
    ----------
    log_belief : (theta,) float64
        log p(theta).
    classes : (theta, profile) bool
        Which profiles favour whom.
    among : (profile,) bool
        The equilibria.

    Examples
    --------
    >>> classes = np.array([[True, True, False], [False, False, True]])
    >>> np.exp(log_p_alpha(np.log([0.2, 0.8]), classes, np.ones(3, bool))).round(3)
    array([0.1, 0.1, 0.8])
    """
    from ppinfer.coordination.classes.scans import profile_probabilities

    result: np.ndarray = profile_probabilities(log_belief, classes, among)
    return result


def log_class_likelihood(
    log_profile: Float[np.ndarray, "replan profile"],
    classes: Bool[np.ndarray, "theta replan profile"],
    among: Bool[np.ndarray, "replan profile"],
    *,
    average: bool,
    skip_empty: bool,
    contamination: float,
) -> Float[np.ndarray, "replan theta"]:
    """Return how likely what was seen is for each theta, from how likely it is in each profile (6).

    The likelihoods L, scaled to sum to one over the K classes, become (1 - e) L + e / K: those of an agent that, with
    probability e, acts this once as one of a personality drawn evenly would.

    Parameters
    ----------
    log_profile : (replan, profile) float64
        -lambda_alpha f_dist(a, H).
    classes : (theta, replan, profile) bool
        Which profiles favour whom.
    among : (replan, profile) bool
        The equilibria.
    average : bool
        True: the mean over the class, which is sum_a p(a | theta) p(H | a). False: (9) and (10) as printed, the sum
        over the class for equally likely profiles; a profile of no class says nothing about theta.
    skip_empty : bool
        True: a class without profiles gets the mean of the others, since the game says nothing about it (with two
        classes: no update at all). False: nothing that was seen speaks for it.
    contamination : float
        e.

    Returns
    -------
    (replan, theta) float64
        Logarithms, times the number of classes: 0 says nothing.

    Examples
    --------
    >>> classes = np.array([[[True, True, False]], [[False, False, True]]])
    >>> among, log_profile = np.ones((1, 3), bool), np.array([[-1.0, -1.0, -3.0]])
    >>> for average in (True, False):
    ...     found = log_class_likelihood(
    ...         log_profile, classes, among, average=average, skip_empty=True, contamination=0.0
    ...     )
    ...     print((np.exp(found) / 2).round(3))
    [[0.881 0.119]]
    [[0.937 0.063]]
    """
    from ppinfer.coordination.classes.scans import class_likelihoods

    result: np.ndarray = class_likelihoods(
        np.ascontiguousarray(log_profile),
        np.ascontiguousarray(classes),
        np.ascontiguousarray(among),
        average,
        skip_empty,
        float(contamination),
    )
    return result
