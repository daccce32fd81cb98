"""Quadratic forms over the last axis."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float


def quadratic_form(
    vectors: Float[np.ndarray, "*batch n"], matrix: Float[np.ndarray, "n n"]
) -> Float[np.ndarray, "*batch"]:
    """Return v' M v for every vector of the last axis.

    Examples
    --------
    >>> quadratic_form(np.array([[1.0, 2.0]]), np.eye(2))
    array([5.])
    """
    return np.asarray(np.einsum("...i,...i->...", vectors @ matrix, vectors))
