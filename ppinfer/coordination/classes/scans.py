"""Compiled scans over the classes of theta; imported only when a class is first weighed."""

from __future__ import annotations

import numba
import numpy as np
from jaxtyping import Bool, Float


@numba.njit(cache=True, nogil=True)
def class_likelihoods(
    log_profile: Float[np.ndarray, "replan profile"],
    classes: Bool[np.ndarray, "theta replan profile"],
    among: Bool[np.ndarray, "replan profile"],
    average: bool,
    skip_empty: bool,
    contamination: float,
) -> Float[np.ndarray, "replan theta"]:
    """Return the log of the likelihood of each class, contaminated, times the number of classes."""
    thetas, replans, profiles = classes.shape
    result = np.zeros((replans, thetas))
    count = np.empty(thetas)
    peak = np.empty(thetas)
    mass = np.empty(thetas)
    share = np.empty(thetas)
    for replan in range(replans):
        count[:] = 0.0
        peak[:] = -np.inf
        mass[:] = 0.0
        for theta in range(thetas):
            for profile in range(profiles):
                count[theta] += classes[theta, replan, profile]
        # each class is centred on its own peak, in a first pass; in the second its mass is summed
        for step in range(2):
            for profile in range(profiles):
                if not among[replan, profile]:
                    continue
                value = log_profile[replan, profile]
                total = 0.0
                for theta in range(thetas):
                    share[theta] = 0.0
                    if classes[theta, replan, profile]:
                        share[theta] = 1.0 / count[theta]
                        total += share[theta]
                if not average:
                    # (10); 0 / 0 says nothing about theta
                    for theta in range(thetas):
                        share[theta] = share[theta] / total if total > 0.0 else 1.0 / thetas
                for theta in range(thetas):
                    if share[theta] > 0.0:
                        if step == 0:
                            peak[theta] = max(peak[theta], value)
                        else:
                            mass[theta] += share[theta] * np.exp(value - peak[theta])
        most, held, nonempty = -np.inf, 0.0, 0
        for theta in range(thetas):
            result[replan, theta] = -np.inf
            if mass[theta] > 0.0 and not (skip_empty and count[theta] == 0.0):
                result[replan, theta] = peak[theta] + np.log(mass[theta])
                most = max(most, result[replan, theta])
            nonempty += count[theta] > 0.0
        if most == -np.inf:
            # no equilibrium of any class: nothing to learn
            result[replan] = 0.0
            continue
        for theta in range(thetas):
            held += np.exp(result[replan, theta] - most)
        if skip_empty and nonempty < thetas:
            # the mean of the others: what was seen says nothing about a class that could not be chosen
            for theta in range(thetas):
                if count[theta] == 0.0:
                    result[replan, theta] = most + np.log(held / nonempty)
            held *= thetas / nonempty
        for theta in range(thetas):
            scaled = result[replan, theta] - most - np.log(held / thetas)
            if contamination > 0.0:
                clean = np.log1p(-contamination) + scaled if contamination < 1.0 else -np.inf
                spoilt = np.log(contamination)
                high, low = max(clean, spoilt), min(clean, spoilt)
                scaled = high + np.log1p(np.exp(low - high))
            result[replan, theta] = scaled
    return result


@numba.njit(cache=True, nogil=True)
def profile_probabilities(
    log_belief: Float[np.ndarray, " theta"],
    classes: Bool[np.ndarray, "theta profile"],
    among: Bool[np.ndarray, " profile"],
) -> Float[np.ndarray, " profile"]:
    """Return log p_alpha over the profiles; -inf where there is no equilibrium of a class that is believed in."""
    thetas, profiles = classes.shape
    result = np.full(profiles, -np.inf)
    count = np.zeros(thetas)
    top = -np.inf
    for theta in range(thetas):
        for profile in range(profiles):
            count[theta] += classes[theta, profile]
        if count[theta] > 0.0:
            top = max(top, log_belief[theta])
    if top == -np.inf:
        equal = -np.log(among.sum()) if among.any() else -np.inf
        for profile in range(profiles):
            if among[profile]:
                result[profile] = equal
        return result
    total = 0.0
    for theta in range(thetas):
        if count[theta] > 0.0:
            total += np.exp(log_belief[theta] - top)
    for profile in range(profiles):
        peak = -np.inf
        for theta in range(thetas):
            if classes[theta, profile]:
                peak = max(peak, log_belief[theta] - np.log(count[theta]))
        if peak == -np.inf:
            continue
        weight = 0.0
        for theta in range(thetas):
            if classes[theta, profile]:
                weight += np.exp(log_belief[theta] - np.log(count[theta]) - peak)
        result[profile] = peak + np.log(weight) - top - np.log(total)
    return result
