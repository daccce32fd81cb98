"""Filtering and smoothing over time, in log space, on ragged rows and on distributions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from ppinfer.distributions.axis import Axis, cell_name
from ppinfer.distributions.distribution import Distribution, moving_axes
from ppinfer.distributions.factor import Factor
from ppinfer.distributions.layout import Kinds
from ppinfer.distributions.ragged import checked_row_size
from ppinfer.errors import AxisError, FactorError, ImpossibleEvidenceError


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


def filter_states(
    prior: Distribution, transition: Distribution | None, likelihood: Factor, *, time: str = "sample"
) -> Distribution:
    """Return the posterior of a state at each instant, given the evidence so far.

    The first instant multiplies the prior by its likelihood; before each later one the state moves
    (`predict`).

    Parameters
    ----------
    prior : Distribution
        Of the state: its random axes, together.
    transition : Distribution or None
        Random in ``next_goal`` and given ``goal`` for each axis ``goal`` of the state that changes; None if
        none does.
    likelihood : Factor
        Over `time` and axes of the state; other axes (trials) are independent copies.
    time : str
        The likelihood's axis that is time.

    Returns
    -------
    Distribution
        Over the state, with batch axes: the copies, then `time`.

    Raises
    ------
    AxisError
        If an axis is missing, carries other labels, or the prior or transition depends on time.
    ImpossibleEvidenceError
        If nothing is possible at an instant; the message names it.

    Examples
    --------
    >>> goal, sample = Axis("goal", ["cup", "bowl"]), Axis("sample", 2)
    >>> likelihood = Factor.from_values([sample, goal], [[0.8, 0.2], [0.8, 0.2]])
    >>> filter_states(Distribution.uniform(goal), None, likelihood).prob(goal="cup").round(4)
    array([0.8   , 0.9412])
    """
    return _over_time(forward_filter, prior, transition, likelihood, time)


def smooth_states(
    prior: Distribution, transition: Distribution | None, likelihood: Factor, *, time: str = "sample"
) -> Distribution:
    """Return the posterior of a state at each instant, given all the evidence, later evidence included.

    Parameters
    ----------
    prior, transition, likelihood, time
        As `filter_states` takes them.

    Examples
    --------
    >>> goal, sample = Axis("goal", ["cup", "bowl"]), Axis("sample", 2)
    >>> likelihood = Factor.from_values([sample, goal], [[0.5, 0.5], [0.8, 0.2]])
    >>> smooth_states(Distribution.uniform(goal), None, likelihood).prob(goal="cup").round(4)
    array([0.8, 0.8])
    """
    return _over_time(smooth, prior, transition, likelihood, time)


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
    """Run the forward kernel, or name the sample that stops it."""
    from ppinfer.distributions.scans import OK, forward_kernel

    plain = _filtered_plainly(rows)
    if plain is not None:
        return plain
    out = np.empty_like(rows.log_likelihood)
    transition = np.exp(rows.log_transition)
    status = forward_kernel(
        rows.log_likelihood,
        rows.row_size,
        rows.log_prior,
        rows.log_transition,
        transition,
        rows.which,
        rows.continues,
        out,
    )
    if status != OK:
        _refuse(status, rows, describe)
    return out


def _filtered_plainly(rows: _Rows) -> np.ndarray | None:
    """Filter with probabilities in place of their logs, or return None where these would not do."""
    from ppinfer.distributions.scans import centre_samples, plain_forward_kernel

    # without a transition nothing bounds how far apart hypotheses drift, and tiny differences add up: that needs logs
    if not len(rows.log_transition):
        return None
    transition = np.exp(rows.log_transition)
    if ((transition == 0.0) & (rows.log_transition > -math.inf)).any():
        return None
    centred = np.empty_like(rows.log_likelihood)
    if not centre_samples(rows.log_likelihood, centred):
        return None
    out = np.empty_like(centred)
    if not plain_forward_kernel(
        np.exp(centred), rows.row_size, rows.log_prior, transition, rows.which, rows.continues, out
    ):
        return None
    with np.errstate(divide="ignore"):
        np.log(out, out=out)
    out += centred
    return out


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


def _over_time(
    scan: Callable[..., np.ndarray],
    prior: Distribution,
    transition: Distribution | None,
    likelihood: Factor,
    time: str,
) -> Distribution:
    """Lay distributions out as rows for a scan, and its result as a distribution again."""
    instants = likelihood.axis(time)
    for name, factor in (("prior", prior), ("transition", transition)):
        if factor is not None and time in factor.names:
            raise AxisError(f"the {name} has the time axis {time!r}; only the likelihood may")
    state = [axis for axis in prior.axes if axis.name in prior.random]
    apart = {axis.name: axis for axis in prior.axes if axis.name not in prior.random}
    apart |= {axis.name: axis for axis in likelihood.axes if axis.name not in (time, *prior.random)} | apart
    matrices = None
    if transition is not None:
        moved = moving_axes(transition, prior)
        matrices = _matrices(transition, moved, state)
        inside = {axis.name for axis in state} | {f"next_{axis.name}" for axis in state}
        apart |= {axis.name: axis for axis in matrices.axes if axis.name not in inside} | apart
    copies, size = list(apart.values()), math.prod(len(axis) for axis in state)
    evidence = likelihood.align(*copies, instants, *state).log_values
    rows = math.prod(len(axis) for axis in copies)
    log_transition, which = None, None
    if matrices is not None:
        changing = [axis for axis in copies if axis.name in matrices.names]
        onto = copies if changing else []
        arrow = [*state, *(axis.rename(f"next_{axis.name}") for axis in state)]
        log_transition = matrices.align(*onto, *arrow).log_values.reshape(-1, size, size)
        which = np.arange(rows) if changing else np.zeros(rows, dtype=np.int64)
    cells = (*copies, instants)
    lengths = tuple(len(axis) for axis in cells)
    log_posterior = scan(
        evidence.reshape(-1, size),
        np.full(rows, len(instants)),
        prior.align(*copies, *state).log_values.reshape(rows, size),
        log_transition,
        which,
        describe=lambda sample: cell_name(cells, [int(i) for i in np.unravel_index(sample, lengths)]),
    )
    given = {*prior.conditions, *(transition.conditions if transition is not None else ())}
    kinds: Kinds = tuple("given" if axis.name in given else "batch" for axis in cells)
    axes = (*cells, *state)
    random: Kinds = tuple("random" for _ in state)
    shape = tuple(len(axis) for axis in axes)
    return Distribution._sound(axes, log_posterior.reshape(shape), kinds + random)


def _matrices(transition: Distribution, moved: list[str], state: list[Axis]) -> Factor:
    """Return the transition of the whole state: axes that do not move stay where they are."""
    whole: Factor = Factor(transition.axes, transition.log_values)
    for axis in state:
        if axis.name not in moved:
            still = np.eye(len(axis), dtype=np.bool_)
            whole = whole * Factor.from_mask([axis, axis.rename(f"next_{axis.name}")], still)
    return whole
