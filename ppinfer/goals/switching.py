"""How goals change from one sample to the next."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from ppinfer.goals.model import require_range


def goal_transition(
    present: Bool[np.ndarray, " goal"], stay: float, *, appeared: Bool[np.ndarray, " goal"] | None = None
) -> Float[np.ndarray, "goal goal"]:
    """Return p(next goal | goal): stay with probability `stay`, else any other goal that is present.

    A goal that is no longer there leaves its probability to all that are, evenly; a lone goal stays. Goals that have
    just appeared, k of the n present, are pursued with probability k / n, whatever was believed before they were there.

    Parameters
    ----------
    present : (goal,) bool
        Which goals there are.
    stay : float
        Probability per sample that the goal stays what it is, in [0, 1].
    appeared : (goal,) bool, optional
        Which of them were not there at the sample before.

    Examples
    --------
    >>> goal_transition(np.array([True, True, True]), 0.98)
    array([[0.98, 0.01, 0.01],
           [0.01, 0.98, 0.01],
           [0.01, 0.01, 0.98]])
    """
    require_range("stay", stay, 0.0, 1.0)
    if appeared is not None and (appeared & present).any():
        new, old = appeared & present, present & ~appeared
        share = new.sum() / present.sum()
        before = goal_transition(old, stay) if old.any() else np.zeros((len(present), len(present)))
        entering: np.ndarray = (1.0 - share) * before + share * new / new.sum()
        return entering
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
    redraws: bool = False,
    appeared: Bool[np.ndarray, "row goal"] | None = None,
) -> tuple[Float[np.ndarray, "kind goal goal"], Int[np.ndarray, " row"]]:
    """Return the distinct log transitions that rows need, and which one each row uses.

    A memoryless model draws the goal anew from the row's prior at every sample. One that redraws does so with
    probability 1 - stay: b <- stay b + (1 - stay) prior.
    """
    goals = present.shape[1]
    if redraws and not memoryless:
        kept, which_kept = row_transitions(log_prior, present, 1.0, memoryless=False, appeared=appeared)
        distinct, which = _distinct(np.column_stack([log_prior, which_kept]))
        matrices = stay * np.exp(kept[distinct[:, -1].astype(np.int64)])
        with np.errstate(divide="ignore"):
            log_transition = np.log(matrices + (1.0 - stay) * np.exp(distinct[:, None, :-1]))
        return log_transition, which
    if memoryless:
        distinct, which = _distinct(log_prior)
        log_transition = np.repeat(distinct[:, None, :], goals, axis=1)
        return log_transition, which
    new = np.zeros_like(present) if appeared is None else appeared
    distinct, which = _distinct(np.concatenate([present, new], axis=1))
    stacked = np.stack([goal_transition(kind[:goals], stay, appeared=kind[goals:]) for kind in distinct])
    with np.errstate(divide="ignore"):
        log_transition = np.log(stacked)
    return log_transition, which


def _distinct(
    kinds: Shaped[np.ndarray, "row entry"],
) -> tuple[Shaped[np.ndarray, "kind entry"], Int[np.ndarray, " row"]]:
    """Return the distinct rows, and which one each is."""
    if (kinds == kinds[0]).all():
        # most logs, and many times as fast as sorting
        return kinds[:1], np.zeros(len(kinds), dtype=np.int64)
    distinct, which = np.unique(kinds, axis=0, return_inverse=True)
    return distinct, which.reshape(-1).astype(np.int64)
