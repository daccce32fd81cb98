"""Where a belief over goals begins."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.errors import ModelError


def log_priors(
    present: Bool[np.ndarray, "row goal"], prior: Any = None, *, name_row: Callable[[int], str] | None = None
) -> Float[np.ndarray, "row goal"]:
    """Return the log of a prior over the goals present in each row: even, or in proportion to `prior`.

    Parameters
    ----------
    present : (row, goal) bool
        Goals that exist; at least one a row.
    prior : (goal,) or (row, goal) array of float, optional
        Weights that are finite and not negative; what they give to absent goals is left out.
    name_row : callable, optional
        How errors name a row.

    Raises
    ------
    ModelError
        Where the prior has another shape, is not finite, is negative, or gives nothing to the goals present.

    Examples
    --------
    >>> np.exp(log_priors(np.array([[True, True, False]])))
    array([[0.5, 0.5, 0. ]])
    """
    try:
        weights = np.ones(present.shape) if prior is None else np.asarray(prior, dtype=np.float64)
        weights = np.broadcast_to(weights, present.shape)
    except (TypeError, ValueError) as error:
        raise ModelError(
            f"a prior over goals must hold one number a goal, {present.shape[1]}, or a row of them for each of "
            f"{present.shape[0]} rows; got {prior!r}"
        ) from error
    if not np.isfinite(weights).all() or (weights < 0).any():
        raise ModelError("a prior over goals must hold finite probabilities that are not negative")
    weights = np.where(present, weights, 0.0)
    total = weights.sum(axis=1, keepdims=True)
    if (total <= 0).any():
        row = int(np.argmax(total[:, 0] <= 0))
        where = f"row {row}" if name_row is None else name_row(row)
        raise ModelError(f"{where}: the prior gives no probability to any goal that is present")
    with np.errstate(divide="ignore"):
        logs: np.ndarray = np.log(weights / total)
    return logs
