"""Sums and normalisation of numbers held as logarithms: nothing is exponentiated before it is centred."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

Array = Float[np.ndarray, "..."]
"""Float64 values on a grid."""


def log_sum_exp(log_values: Array, over: tuple[int, ...] | None = None) -> Array:
    """Return ``log(sum(exp(log_values)))`` over some dimensions (None: all); -inf is an honest zero.

    Unlike `scipy.special.logsumexp` it makes no fuss (and no warning) about cells that are zero throughout,
    and costs about what the bare arithmetic costs.

    Examples
    --------
    >>> log_sum_exp(np.array([-1e6, -1e6])).item()
    -999999.3068528194
    """
    if over == ():
        return log_values.copy()
    peak = np.maximum.reduce(log_values, axis=over, keepdims=True)
    # a cell without support stays -inf: centre it at 0 instead of making -inf - -inf
    dead = peak == -math.inf
    lifeless = bool(dead.any())
    if lifeless:
        peak = np.where(dead, 0.0, peak)
    total = np.add.reduce(np.exp(log_values - peak), axis=over, keepdims=True)
    if lifeless:
        total = np.where(dead, 1.0, total)
    result = np.log(total)
    result += peak
    if lifeless:
        result[dead] = -math.inf
    if over is None:
        return result.reshape(())
    return np.squeeze(result, axis=over)


def log_normalise(log_values: Array, over: tuple[int, ...] | None = None) -> tuple[Array, Any]:
    """Return values whose exponentials sum to one over some dimensions (None: all), and where none do.

    Values are centred on their peak before the sum is taken off. Subtracting the log of the total in one go
    would leave, at a total of exp(-1e6), only ten digits.

    Returns
    -------
    normalised : array
        Shaped like `log_values`; undefined where dead.
    dead : None, or array of bool
        None when every cell has support; else which cells, kept dimensions of length 1, have none or are
        infinite.
    """
    if over is None:
        # scalars are much cheaper than arrays of one element, and this is the step of a control loop
        peak = np.maximum.reduce(log_values, axis=None)
        if not math.isfinite(peak):
            return log_values, np.ones((1,) * log_values.ndim, dtype=bool)
        centred = np.subtract(log_values, peak)
        centred -= math.log(np.add.reduce(np.exp(centred), axis=None))
        return centred, None
    peak = np.maximum.reduce(log_values, axis=over, keepdims=True)
    alive = np.isfinite(peak)
    if not alive.all():
        return log_values, ~alive
    centred = log_values - peak
    centred -= np.log(np.add.reduce(np.exp(centred), axis=over, keepdims=True))
    return centred, None


def log_of(values: Array) -> Array:
    """Return logarithms of non-negative numbers, log 0 = -inf without a warning."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(values))


def log_indicator(mask: Bool[np.ndarray, "..."]) -> Array:
    """Return 0 where the mask is true and -inf elsewhere."""
    return np.asarray(np.where(mask, 0.0, -math.inf))
