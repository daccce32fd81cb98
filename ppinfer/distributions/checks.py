"""Are these numbers fit to be the values of a factor? If not, the message names the cell."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ppinfer.distributions.axis import first_cell
from ppinfer.distributions.layout import Axes
from ppinfer.distributions.logspace import Array, log_of
from ppinfer.errors import FactorError


def check_shape(axes: Axes, array: np.ndarray, what: str) -> None:
    """Say what shape the axes call for, where the array has another."""
    shape = tuple(len(axis) for axis in axes)
    if array.shape != shape:
        names = ", ".join(f"{axis.name} {len(axis)}" for axis in axes) or "none"
        raise FactorError(f"{what} have shape {array.shape}, but the axes ({names}) call for {shape}")


def numbers(array: Any, what: str) -> Array:
    """Return a fresh array of float64, or say that these are no numbers."""
    try:
        return np.array(array, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise FactorError(f"{what} must be real numbers on a rectangular grid: {error}") from None


def checked_values(axes: Axes, log_values: Any) -> Array:
    """Return a read-only copy of log values, or name the cell that is NaN or +inf."""
    array = numbers(log_values, "log values")
    check_shape(axes, array, "log values")
    wrong = ~(array < math.inf)
    if wrong.any():
        value = array[wrong][0]
        raise FactorError(
            f"log value is {value} at {first_cell(axes, wrong)}; log values are finite, or -inf for zero"
        )
    array.setflags(write=False)
    return array


def checked_logs(axes: Axes, values: Any) -> Array:
    """Return logarithms of non-negative finite numbers, or name the cell that is not one."""
    array = numbers(values, "values")
    check_shape(axes, array, "values")
    wrong = ~((array >= 0.0) & (array < math.inf))
    if wrong.any():
        raise FactorError(
            f"value is {array[wrong][0]} at {first_cell(axes, wrong)}; values are finite and at least 0"
        )
    return log_of(array)


def checked_mask(axes: Axes, mask: Any) -> np.ndarray:
    """Return a mask of the axes' shape as an array of bool."""
    array = np.asarray(mask)
    if array.dtype != np.bool_:
        raise FactorError(
            f"a mask must be an array of bool, not of {array.dtype}; write for example `values > 0`"
        )
    check_shape(axes, array, "the mask's values")
    return array


def check_power(axes: Axes, log_values: Array, result: Array, power: float) -> None:
    """Name the cell whose logarithm, multiplied by a power, left the range of floating point."""
    over = np.isinf(result) & np.isfinite(log_values)
    if over.any():
        raise FactorError(
            f"log value {log_values[over][0]} to the power of {power} is beyond the largest float, at "
            f"{first_cell(axes, over)}"
        )
