"""Numbers that summarise probabilities: modes, expectations, entropies, divergences, draws."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from ppinfer.distributions.axis import Axis, cell_name, first_cell
from ppinfer.distributions.logspace import Array
from ppinfer.errors import AxisError, FactorError


def value_grid(values: Any, axes: Sequence[Axis]) -> Array:
    """Return a function of labels as an array whose leading dimensions are the axes.

    Parameters
    ----------
    values : callable, mapping or array
        As `Distribution.expect` takes it.
    axes : sequence of Axis
        The axes whose labels it is a function of.

    Raises
    ------
    FactorError
        If a label has no value, or the value is NaN, or the shape does not fit.
    """
    shape = tuple(len(axis) for axis in axes)
    if isinstance(values, Mapping):
        if len(axes) != 1:
            raise AxisError(
                f"a mapping gives values of one axis, not of {len(axes)}; use a callable or an array"
            )
        missing = [label for label in axes[0].labels if label not in values]
        if missing:
            raise FactorError(
                f"the mapping has no value for {missing[0]!r}, a label of axis {axes[0].name!r}"
            )
        grid = np.array([values[label] for label in axes[0].labels], dtype=np.float64)
    elif isinstance(values, Callable):  # type: ignore[arg-type]
        flat = np.array(
            [values(*labels) for labels in product(*(axis.labels for axis in axes))], dtype=np.float64
        )
        grid = flat.reshape(shape + flat.shape[1:])
    else:
        grid = np.asarray(values, dtype=np.float64)
    if grid.shape[: len(shape)] != shape:
        names = ", ".join(f"{axis.name} {len(axis)}" for axis in axes)
        raise FactorError(f"values have shape {grid.shape}, but must lead with the axes ({names})")
    wrong = np.asarray(np.isnan(grid))
    if wrong.any():
        cells = np.asarray(wrong.reshape(*shape, -1).any(axis=-1))
        raise FactorError(f"the value to be expected is NaN at {first_cell(axes, cells)}")
    return grid


def expect(probabilities: Array, grid: Array, axes: Sequence[Axis]) -> Array:
    """Return sums of probability times value over the axes; values of probability 0 do not count.

    Parameters
    ----------
    probabilities : array, shape (..., *axes)
        The axes of the values are the last dimensions.
    grid : array, shape (*axes, ...)
        As from `value_grid`.
    axes : sequence of Axis
        For messages.
    """
    dims = len(axes)
    others, further = probabilities.shape[: probabilities.ndim - dims], grid.shape[dims:]
    p = probabilities.reshape(math.prod(others), -1)
    v = grid.reshape(p.shape[1], -1)
    infinite = np.isinf(v)
    result = p @ np.where(infinite, 0.0, v)
    if infinite.any():
        up = (p > 0.0) @ (v == math.inf)
        down = (p > 0.0) @ (v == -math.inf)
        if (up & down).any():
            column = int(np.argmax((up & down).any(axis=0)))
            rows = [int(np.argmax(v[:, column] == sign * math.inf)) for sign in (1, -1)]
            shape = tuple(len(axis) for axis in axes)
            names = [cell_name(axes, [int(i) for i in np.unravel_index(row, shape)]) for row in rows]
            raise FactorError(
                f"expectation undefined: +inf at {names[0]} and -inf at {names[1]} are both possible"
            )
        result = np.where(up, math.inf, np.where(down, -math.inf, result))
    return result.reshape(others + further)


def entropy(log_p: Float[np.ndarray, "cell outcome"]) -> Float[np.ndarray, "cell"]:
    """Return -sum p log p of each row, with 0 log 0 = 0."""
    # adding zero turns the -0.0 of a certain outcome into 0.0
    terms = np.exp(log_p) * np.where(log_p == -math.inf, 0.0, log_p)
    return np.asarray(-terms.sum(axis=1) + 0.0)


def divergence(log_p: Array, log_q: Array, over: tuple[int, ...]) -> Array:
    """Return sum p log(p / q) over some dimensions.

    Written as a sum of p log(p / q) - p + q, whose terms are all non-negative, so that nearly equal
    distributions do not cancel to a negative number.
    """
    possible = log_p > -math.inf
    p, q = np.exp(log_p), np.exp(log_q)
    ratio = np.subtract(log_p, log_q, out=np.zeros(log_p.shape), where=possible & (log_q > -math.inf))
    ratio = np.where(possible & (log_q == -math.inf), math.inf, ratio)
    # p (exp(-ratio) - 1 + ratio); for |ratio| past 1 nothing cancels, and exp(-ratio) may overflow
    small = np.clip(ratio, -1.0, 1.0)
    # p underflows to 0 before its logarithm does, and 0 times inf would be NaN
    far = np.where(ratio == math.inf, math.inf, p * np.where(ratio == math.inf, 0.0, ratio) - p + q)
    terms = np.where(possible, np.where(np.abs(ratio) < 1.0, p * (np.expm1(-small) + small), far), q)
    return np.asarray(np.maximum(terms, 0.0).sum(axis=over))


def sample(
    log_p: Float[np.ndarray, "cell outcome"],
    shape: tuple[int, ...],
    leading: tuple[int, ...],
    rng: np.random.Generator,
    *,
    random: Sequence[Axis],
) -> dict[str, Any]:
    """Draw outcomes of each row by inverting its cumulative distribution; see `Distribution.sample`."""
    cumulative = np.cumsum(np.exp(log_p), axis=1)
    draws = rng.random((math.prod(leading), len(log_p))) * cumulative[:, -1]
    # the first outcome whose cumulative probability exceeds the draw: one of probability 0 is never it
    cells, outcomes = log_p.shape
    if cells <= outcomes:
        chosen = np.empty(draws.shape, dtype=np.int64)
        for cell in range(cells):
            chosen[:, cell] = np.searchsorted(cumulative[cell], draws[:, cell], side="right")
    else:
        chosen = np.zeros(draws.shape, dtype=np.int64)
        for outcome in range(outcomes):
            chosen += cumulative[:, outcome] <= draws
    # rounding may bring a draw up to the total, past the last outcome that is possible
    last = outcomes - 1 - np.argmax(np.diff(cumulative, axis=1, prepend=0.0)[:, ::-1] > 0.0, axis=1)
    return labels_at(np.minimum(chosen, last).reshape(leading + shape), random)


def mode(
    log_p: Float[np.ndarray, "cell outcome"], shape: tuple[int, ...], *, random: Sequence[Axis]
) -> dict[str, Any]:
    """Return the labels of the largest entry of each row; see `Distribution.mode`."""
    return labels_at(np.argmax(log_p, axis=1).reshape(shape), random)


def labels_at(outcomes: Int[np.ndarray, "..."], axes: Sequence[Axis]) -> dict[str, Any]:
    """Return, for positions in the flattened grid of the axes, the labels of each axis."""
    # not np.unravel_index: NumPy 2.4.6 gets positions of shape (20000, 1) wrong, past its buffer of 8192
    places: list[np.ndarray] = []
    for axis in reversed(axes):
        outcomes, place = np.divmod(outcomes, len(axis))
        places.insert(0, np.asarray(place))
    if places[0].ndim == 0:
        return {axis.name: axis.labels[int(i)] for axis, i in zip(axes, places, strict=True)}
    return {axis.name: axis.label_array()[i] for axis, i in zip(axes, places, strict=True)}
