"""Compiled scans over bodies of capsules; imported only when plans are first held against each other."""

from __future__ import annotations

from math import inf, sqrt

import numba
import numpy as np
from jaxtyping import Float, Int

from ppinfer.safety.scans import segment_gap


@numba.njit(cache=True, nogil=True)
def smallest_distances(
    own: Float[np.ndarray, "plan step capsule two space"],
    own_radius: Float[np.ndarray, " capsule"],
    own_steps: Int[np.ndarray, " plan"],
    other: Float[np.ndarray, "other step capsule two space"],
    other_radius: Float[np.ndarray, " capsule"],
    other_steps: Int[np.ndarray, " other"],
    shift: Float[np.ndarray, "rollout step space"],
    smallest: Float[np.ndarray, "rollout plan other"],
) -> None:
    """Write the smallest distance over the steps at which both are there, the other shifted; inf without any."""
    space = own.shape[4]
    offset = np.empty(space)
    for r in range(shift.shape[0]):
        for i in range(own.shape[0]):
            for j in range(other.shape[0]):
                least = inf
                for step in range(min(own_steps[i], other_steps[j])):
                    for k in range(space):
                        offset[k] = -shift[r, step, k]
                    for a in range(own.shape[2]):
                        for b in range(other.shape[2]):
                            radii = own_radius[a] + other_radius[b]
                            uu = vv = middle = 0.0
                            for k in range(space):
                                u = own[i, step, a, 1, k] - own[i, step, a, 0, k]
                                v = other[j, step, b, 1, k] - other[j, step, b, 0, k]
                                between = own[i, step, a, 0, k] - other[j, step, b, 0, k]
                                between += offset[k] + 0.5 * (u - v)
                                middle += between * between
                                uu += u * u
                                vv += v * v
                            # too far off to matter, whichever way they lie
                            if sqrt(middle) - 0.5 * (sqrt(uu) + sqrt(vv)) - radii >= least:
                                continue
                            one, its = own[i, step, a], other[j, step, b]
                            least = min(least, segment_gap(offset, one[0], one[1], its[0], its[1]) - radii)
                smallest[r, i, j] = least
