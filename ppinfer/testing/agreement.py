"""Do two answers agree to the last digits? What the laws compare with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ppinfer.distributions import Axis, Factor
from ppinfer.distributions.axis import cell_name
from ppinfer.errors import ImpossibleEvidenceError

TOLERANCE = 1e-13
"""Relative to the largest log value that went in (at least 1): a few units of its last digit."""


def attempt(answer: Callable[[], Any]) -> Any:
    """Return an answer, or None where the evidence is refused as impossible."""
    try:
        return answer()
    except ImpossibleEvidenceError:
        return None


def magnitude_of(*factors: Factor) -> float:
    """Return the largest finite log value, at least 1: it sets the last digit that sums can keep."""
    finite = [np.abs(f.log_values[np.isfinite(f.log_values)]) for f in factors]
    return max([1.0, *(float(values.max()) for values in finite if values.size)])


def agree(what: str, left: Factor, right: Factor, magnitude: float, tolerance: float) -> None:
    """Compare log values, -inf exactly, and name the first cell where they differ."""
    if set(left.axes) != set(right.axes):
        raise AssertionError(f"{what} have different axes: {left!r}; {right!r}")
    mine, theirs = left.log_values, right.align(*left.names).log_values
    with np.errstate(invalid="ignore"):
        close = (mine == theirs) | (np.abs(mine - theirs) <= tolerance * magnitude)
    for index in np.argwhere(~close):
        cell = tuple(index)
        raise AssertionError(
            f"{what} differ at {at_cell(left.axes, index)}: log values {float(mine[cell])!r} "
            f"and {float(theirs[cell])!r} (allowed: {tolerance * magnitude:.3g})"
        )


def at_cell(axes: Sequence[Axis], index: Any) -> str:
    """Name a cell by its labels."""
    return cell_name(axes, [int(i) for i in index])
