"""Filtering and smoothing over time, in log space, on ragged rows."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from ppinfer.distributions.ragged import checked_row_size
from ppinfer.errors import FactorError, ImpossibleEvidenceError


def forward_filter(
    log_likelihood: Any,
    row_size: Any,
    log_prior: Any,
    log_transition: Any = None,
    which_transition: Any = None,
    continues: Any = None,
    *,
    describe: Callable[[int], str] | None = None,
) -> Float[np.ndarray, "sample hypothesis"]:
    """Return the posterior at each sample given the evidence of its chain so far.

    A row's first sample multiplies its prior by its likelihood. At each later one the last posterior first
    moves,

        p_t(j)  is proportional to  L_t(j) sum_i p_(t-1)(i) T(i, j),

    with the transition of the row that the sample is in.

    Parameters
    ----------
    log_likelihood : array of float, shape (sample, hypothesis)
        Rows end to end; -inf where a hypothesis is impossible.
    row_size : array of int, shape (row,)
        Samples of each row, at least 1.
    log_prior : array of float, shape (row, hypothesis)
        Up to a constant for each row. Ignored where a row continues the one before it.
    log_transition : array of float, shape (transition, hypothesis, hypothesis), optional
        ``log_transition[m, i, j]`` is log p(next = j given now = i); None: nothing ever changes.
    which_transition : array of int, shape (row,), optional
        The transition of each row; needed where there are several.
    continues : array of bool, shape (row,), optional
        Whether a row takes the last posterior of the row before it through its transition, instead of its
        prior.
    describe : callable, optional
        Says in words which sample a flat index is, for messages; by default its row and its place there.

    Returns
    -------
    log_posterior : array of float64, shape (sample, hypothesis)
        Each row sums to one.

    Raises
    ------
    FactorError
        If shapes do not fit, a row is empty, a value is NaN or +inf, or a transition's row does not sum to
        one.
    ImpossibleEvidenceError
        If no hypothesis is possible at a sample; the message names it.

    Examples
    --------
    >>> stay = np.log([[[0.9, 0.1], [0.1, 0.9]]])
    >>> log_likelihood = np.log([[0.8, 0.2], [0.8, 0.2], [0.5, 0.5]])
    >>> np.exp(forward_filter(log_likelihood, [2, 1], np.log([[0.5, 0.5], [0.5, 0.5]]), stay)).round(4)
    array([[0.8   , 0.2   ],
           [0.9193, 0.0807],
           [0.5   , 0.5   ]])
    """
    rows = _checked(log_likelihood, row_size, log_prior, log_transition, which_transition, continues)
    return _filtered(rows, describe)


def smooth(
    log_likelihood: Any,
    row_size: Any,
    log_prior: Any,
    log_transition: Any = None,
    which_transition: Any = None,
    continues: Any = None,
    *,
    describe: Callable[[int], str] | None = None,
) -> Float[np.ndarray, "sample hypothesis"]:
    """Return the posterior at each sample given all the evidence of its chain, later evidence included.

    A chain is a row together with the rows that continue it. Exact, by forward filtering and backward
    messages

        beta_t(i) = sum_j T(i, j) L_(t+1)(j) beta_(t+1)(j),

    both in log space.

    Parameters
    ----------
    log_likelihood, row_size, log_prior, log_transition, which_transition, continues, describe
        As `forward_filter` takes them.

    Returns
    -------
    log_posterior : array of float64, shape (sample, hypothesis)
        Each row sums to one. At the last sample of a chain it is the filter's.

    Raises
    ------
    FactorError, ImpossibleEvidenceError
        As in `forward_filter`.

    Examples
    --------
    >>> log_likelihood = np.log([[0.5, 0.5], [0.8, 0.2]])
    >>> np.exp(smooth(log_likelihood, [2], np.log([[0.5, 0.5]]))).round(4)
    array([[0.8, 0.2],
           [0.8, 0.2]])
    """
    from ppinfer.distributions.scans import backward_kernel

    rows = _checked(log_likelihood, row_size, log_prior, log_transition, which_transition, continues)
    out = _filtered(rows, describe)
    log_reverse = np.ascontiguousarray(rows.log_transition.transpose(0, 2, 1))
    backward_kernel(
        rows.log_likelihood, rows.row_size, log_reverse, np.exp(log_reverse), rows.which, rows.continues, out
    )
    return out


@dataclass(frozen=True)
class _Rows:
    """Inputs of the kernels: contiguous, of the types that they are compiled for, and consistent."""

    log_likelihood: np.ndarray
    row_size: np.ndarray
    log_prior: np.ndarray
    log_transition: np.ndarray
    which: np.ndarray
    continues: np.ndarray


def _checked(
    log_likelihood: Any,
    row_size: Any,
    log_prior: Any,
    log_transition: Any,
    which_transition: Any,
    continues: Any,
) -> _Rows:
    likelihood = np.ascontiguousarray(log_likelihood, dtype=np.float64)
    if likelihood.ndim != 2 or not likelihood.shape[1]:
        raise FactorError(f"log_likelihood must have shape (sample, hypothesis), got {likelihood.shape}")
    sizes = checked_row_size(row_size)
    samples, hypotheses = likelihood.shape
    if int(sizes.sum()) != samples:
        raise FactorError(
            f"row sizes add up to {int(sizes.sum())} samples over {len(sizes)} rows, "
            f"but log_likelihood has {samples}"
        )
    if not sizes.all():
        raise FactorError(f"row {int(np.argmin(sizes))} has no samples; leave empty rows out")
    joins = _checked_flags(continues, sizes)
    prior = np.ascontiguousarray(log_prior, dtype=np.float64)
    if prior.shape != (len(sizes), hypotheses):
        raise FactorError(
            f"log_prior must have shape (row, hypothesis) = {(len(sizes), hypotheses)}, got {prior.shape}"
        )
    wrong = ~(prior < math.inf) & ~joins[:, None]
    if wrong.any():
        row, column = np.argwhere(wrong)[0]
        raise FactorError(
            f"log_prior is {prior[row, column]} in row {row}, hypothesis {column}; finite or -inf needed"
        )
    transitions, which = _checked_transition(log_transition, which_transition, len(sizes), hypotheses)
    return _Rows(likelihood, sizes, prior, transitions, which, joins)


def _checked_flags(continues: Any, row_size: np.ndarray) -> np.ndarray:
    if continues is None:
        return np.zeros(len(row_size), dtype=np.bool_)
    flags = np.ascontiguousarray(continues)
    if flags.dtype != np.bool_ or flags.shape != row_size.shape:
        raise FactorError(
            f"continues must be an array of bool of shape {row_size.shape}, "
            f"got {flags.dtype} of shape {flags.shape}"
        )
    if flags.size and flags[0]:
        raise FactorError("row 0 cannot continue another: there is none before it")
    return flags


def _checked_transition(
    log_transition: Any, which_transition: Any, rows: int, hypotheses: int
) -> tuple[np.ndarray, np.ndarray]:
    if log_transition is None:
        if which_transition is not None:
            raise FactorError("which_transition says which of no transitions; give log_transition as well")
        return np.zeros((0, hypotheses, hypotheses)), np.full(rows, -1, dtype=np.int64)
    transitions = np.ascontiguousarray(log_transition, dtype=np.float64)
    if transitions.ndim != 3 or transitions.shape[1:] != (hypotheses, hypotheses) or not len(transitions):
        raise FactorError(
            f"log_transition must have shape (transition, {hypotheses}, {hypotheses}), "
            f"got {transitions.shape}"
        )
    sums = np.exp(np.minimum(transitions, 1.0)).sum(axis=2)
    wrong = ~(np.abs(sums - 1.0) <= 1e-9)
    if wrong.any():
        m, i = np.argwhere(wrong)[0]
        raise FactorError(
            f"transition {m} from hypothesis {i}: its probabilities sum to {sums[m, i]:.12g}, not 1 "
            "(log_transition[m, i, j] is log p(next = j given now = i))"
        )
    if which_transition is None:
        if len(transitions) > 1:
            raise FactorError(
                f"there are {len(transitions)} transitions; which_transition must say which a row takes"
            )
        return transitions, np.zeros(rows, dtype=np.int64)
    which = np.asarray(which_transition)
    if which.shape != (rows,) or which.dtype.kind not in "iu":
        raise FactorError(
            f"which_transition must be {rows} integers, got shape {which.shape} of {which.dtype}"
        )
    outside = (which < 0) | (which >= len(transitions))
    if outside.any():
        row = int(np.argmax(outside))
        raise FactorError(
            f"which_transition of row {row} is {which[row]}, but there are {len(transitions)} transitions"
        )
    return transitions, np.ascontiguousarray(which, dtype=np.int64)


def _filtered(rows: _Rows, describe: Callable[[int], str] | None) -> np.ndarray:
    """Filter rows in plain numbers where these will do, else in logs, or name the sample that stops it.

    What a chain of rows is filtered in must not depend on the other rows, or these would change its last digit: where
    plain numbers do not do for all, each half of the chains is tried by itself.
    """
    out = np.empty_like(rows.log_likelihood)
    transition = np.exp(rows.log_transition)
    # without a transition nothing bounds how far apart hypotheses drift, and tiny differences add up: that needs logs
    plain = bool(len(transition)) and not ((transition == 0.0) & (rows.log_transition > -math.inf)).any()
    first_sample = np.concatenate([[0], np.cumsum(rows.row_size)])
    # rows that begin a chain, and the end
    chains = np.append(np.flatnonzero(~rows.continues), len(rows.row_size))
    waiting = [(0, len(chains) - 1)] if len(rows.row_size) else []
    while waiting:
        begin, end = waiting.pop()
        some = slice(int(chains[begin]), int(chains[end]))
        offset = int(first_sample[some.start])
        samples = slice(offset, int(first_sample[some.stop]))
        part = _Rows(
            rows.log_likelihood[samples],
            rows.row_size[some],
            rows.log_prior[some],
            rows.log_transition,
            rows.which[some],
            rows.continues[some],
        )
        if plain:
            if _filtered_plainly(part, transition, out[samples]):
                continue
            if end - begin > 1:
                middle = (begin + end) // 2
                waiting += [(middle, end), (begin, middle)]
                continue
        _filter_logs(part, transition, out[samples], offset, rows, describe)
    return out


def _filter_logs(
    part: _Rows,
    transition: np.ndarray,
    out: np.ndarray,
    offset: int,
    whole: _Rows,
    describe: Callable[[int], str] | None,
) -> None:
    """Filter rows that begin at a sample of the whole, or name the sample that stops it."""
    from ppinfer.distributions.scans import OK, forward_kernel

    status = forward_kernel(
        part.log_likelihood,
        part.row_size,
        part.log_prior,
        part.log_transition,
        transition,
        part.which,
        part.continues,
        out,
    )
    if status != OK:
        _refuse(status + offset if status >= 0 else status - offset, whole, describe)


def _filtered_plainly(rows: _Rows, transition: np.ndarray, out: np.ndarray) -> bool:
    """Filter with probabilities in place of their logs; false, and `out` of no use, where these would not do."""
    from ppinfer.distributions.scans import centre_samples, plain_forward_kernel

    centred = np.empty_like(rows.log_likelihood)
    if not centre_samples(rows.log_likelihood, centred):
        return False
    if not plain_forward_kernel(
        np.exp(centred), rows.row_size, rows.log_prior, transition, rows.which, rows.continues, out
    ):
        return False
    with np.errstate(divide="ignore"):
        np.log(out, out=out)
    out += centred
    return True


def _refuse(status: int, rows: _Rows, describe: Callable[[int], str] | None) -> None:
    """Raise what a kernel's status means, naming the sample."""
    sample = status if status >= 0 else -2 - status
    if describe is None:
        ends = np.cumsum(rows.row_size)
        row = int(np.searchsorted(ends, sample, side="right"))
        where = f"row {row}, sample {sample - int(ends[row] - rows.row_size[row])} of that row"
    else:
        where = describe(sample)
    if status >= 0:
        raise ImpossibleEvidenceError(
            f"no hypothesis is possible at {where}: each has likelihood zero there or was ruled out before. "
            "Check the evidence for contradictions, or give the hypotheses it rules out some probability"
        )
    wrong = rows.log_likelihood[sample]
    column = int(np.argmax(~(wrong < math.inf)))
    raise FactorError(
        f"log_likelihood is {wrong[column]} at {where}, hypothesis {column}; finite or -inf needed"
    )
