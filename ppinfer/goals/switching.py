"""How goals change from one sample to the next."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.goals.model import require_range


def goal_transition(present: Bool[np.ndarray, " goal"], stay: float) -> Float[np.ndarray, "goal goal"]:
    """Return p(next goal | goal): stay with probability `stay`, else any other goal that is present.

    A goal that is no longer there leaves its probability to all that are, evenly; a lone goal stays.

    Parameters
    ----------
    present : (goal,) bool
        Which goals there are.
    stay : float
        Probability per sample that the goal stays what it is, in [0, 1].

    Examples
    --------
    >>> goal_transition(np.array([True, True, True]), 0.98)
    array([[0.98, 0.01, 0.01],
           [0.01, 0.98, 0.01],
           [0.01, 0.01, 0.98]])
    """
    require_range("stay", stay, 0.0, 1.0)
    count = int(present.sum())
    there = present.astype(np.float64)
    if count == 1:
        return np.tile(there, (len(present), 1))
    move = there / (count - 1) * (1.0 - stay)
    matrix = np.tile(move, (len(present), 1))
    np.fill_diagonal(matrix, np.where(present, stay, 0.0))
    matrix[~present] = there / count
    return matrix


def row_transitions(
    log_prior: Float[np.ndarray, "row goal"],
    present: Bool[np.ndarray, "row goal"],
    stay: float,
    *,
    memoryless: bool,
) -> tuple[Float[np.ndarray, "kind goal goal"], Int[np.ndarray, " row"]]:
    """Return the distinct log transitions that rows need, and which one each row uses.

    A memoryless model draws the goal anew from the row's prior at every sample.
    """
    key = log_prior if memoryless else present.astype(np.float64)
    distinct, which = np.unique(key, axis=0, return_inverse=True)
    if memoryless:
        log_transition = np.repeat(distinct[:, None, :], distinct.shape[1], axis=1)
    else:
        with np.errstate(divide="ignore"):
            log_transition = np.log(np.stack([goal_transition(row > 0, stay) for row in distinct]))
    return log_transition, which.reshape(-1).astype(np.int64)
