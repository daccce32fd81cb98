"""Compiled scans over bodies of capsules; imported only when plans are first held against each other."""

from __future__ import annotations

from math import inf, sqrt

import numba
import numpy as np
from jaxtyping import Float, Int


@numba.njit(cache=True, nogil=True, inline="always")
def _dot(a: Float[np.ndarray, " space"], b: Float[np.ndarray, " space"]) -> float:
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@numba.njit(cache=True, nogil=True, inline="always")
def _share(value: float) -> float:
    return min(1.0, max(0.0, value))


@numba.njit(cache=True, nogil=True)
def _apart(uu: float, uv: float, vv: float, uw: float, vw: float, ww: float) -> float:
    """Return the squared distance of segments a + s u and c + t v, s and t in [0, 1], from products with w = a - c."""
    # where the lines are nearest, if that is within both; else it is at one of the four ends
    least = inf
    across = uu * vv - uv * uv
    if across > 1e-14 * uu * vv:
        s, t = (uv * vw - vv * uw) / across, (uu * vw - uv * uw) / across
        if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
            least = ww + s * (s * uu + 2.0 * uw - 2.0 * t * uv) + t * (t * vv - 2.0 * vw)
    for end in range(2):
        t = _share((vw + end * uv) / vv) if vv > 0.0 else 0.0
        least = min(least, ww + end * (uu + 2.0 * uw - 2.0 * t * uv) + t * (t * vv - 2.0 * vw))
        s = _share((end * uv - uw) / uu) if uu > 0.0 else 0.0
        least = min(least, ww + s * (s * uu + 2.0 * uw - 2.0 * end * uv) + end * (vv - 2.0 * vw))
    return max(least, 0.0)


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
    u, v, w = np.empty(space), np.empty(space), np.empty(space)
    for r in range(shift.shape[0]):
        for i in range(own.shape[0]):
            for j in range(other.shape[0]):
                least = inf
                for step in range(min(own_steps[i], other_steps[j])):
                    for a in range(own.shape[2]):
                        for b in range(other.shape[2]):
                            radii = own_radius[a] + other_radius[b]
                            uu = uv = vv = uw = vw = ww = middle = 0.0
                            for k in range(space):
                                u[k] = own[i, step, a, 1, k] - own[i, step, a, 0, k]
                                v[k] = other[j, step, b, 1, k] - other[j, step, b, 0, k]
                                w[k] = own[i, step, a, 0, k] - other[j, step, b, 0, k] - shift[r, step, k]
                                between = w[k] + 0.5 * (u[k] - v[k])
                                middle += between * between
                                uu += u[k] * u[k]
                                vv += v[k] * v[k]
                            # too far off to matter, whichever way they lie
                            if sqrt(middle) - 0.5 * (sqrt(uu) + sqrt(vv)) - radii >= least:
                                continue
                            uv, uw, vw, ww = _dot(u, v), _dot(u, w), _dot(v, w), _dot(w, w)
                            least = min(least, sqrt(_apart(uu, uv, vv, uw, vw, ww)) - radii)
                smallest[r, i, j] = least
