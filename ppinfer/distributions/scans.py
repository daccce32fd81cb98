"""Compiled scans over ragged rows. Importing this module loads numba; nothing imports it before it is needed.

The signatures are explicit, so that each kernel is compiled once and cached, whether or not its inputs are
read-only. Kernels return a status instead of raising: `OK`, the flat index of the sample at which nothing is
possible, or ``INVALID - index`` of a sample whose log likelihood is NaN or +inf.
"""

from __future__ import annotations

import numba
import numpy as np
from numba import types

OK = -1
INVALID = -2


def _read_only(kind: types.Type, ndim: int) -> types.Array:
    # arrays that may be written to are accepted for these as well
    return types.Array(kind, ndim, "C", readonly=True)


_F8_1 = types.float64[::1]
_F8_2 = types.float64[:, ::1]
_ROWS = _read_only(types.int64, 1)
_FLAGS = _read_only(types.boolean, 1)
_LOGS_1 = _read_only(types.float64, 1)
_LOGS_2 = _read_only(types.float64, 2)
_LOGS_3 = _read_only(types.float64, 3)


@numba.njit(cache=True, nogil=True)
def _restarting_cumsum(values, row_size, out):  # type: ignore[no-untyped-def]
    width = values.shape[1]
    sample = 0
    for row in range(row_size.shape[0]):
        for position in range(row_size[row]):
            for k in range(width):
                if position == 0:
                    out[sample, k] = values[sample, k]
                else:
                    out[sample, k] = out[sample - 1, k] + values[sample, k]
            sample += 1


@numba.njit(
    [
        types.void(_LOGS_2, _ROWS, _F8_2),
        types.void(_read_only(types.int64, 2), _ROWS, types.int64[:, ::1]),
    ],
    cache=True,
    nogil=True,
)
def _cumsum(values, row_size, out):  # type: ignore[no-untyped-def]
    _restarting_cumsum(values, row_size, out)


def restarting_cumsum(values: np.ndarray, row_size: np.ndarray) -> np.ndarray:
    """Return running sums, shape (sample, k) of float64 or int64, that start anew at each row."""
    out = np.empty_like(values)
    _cumsum(values, row_size, out)
    return out


# below this a sum of probabilities may have lost terms to underflow, and is taken again in logs
_TOO_SMALL = 1e-290


@numba.njit(types.boolean(_F8_1, _F8_1), cache=True, nogil=True)
def _centre(log_weights, weights):  # type: ignore[no-untyped-def]
    """Centre log weights on their peak, in place, and write their exponentials; false if none is possible.

    Centred weights are what is carried on: next to a peak of 0, differences of 1e-12 keep all their digits.
    """
    peak = log_weights[0]
    for k in range(1, log_weights.shape[0]):
        peak = max(peak, log_weights[k])
    if not peak > -np.inf:
        return False
    for k in range(log_weights.shape[0]):
        log_weights[k] -= peak
        weights[k] = np.exp(log_weights[k])
    return True


@numba.njit(types.void(_F8_1, _F8_1, _F8_1), cache=True, nogil=True)
def _normalise(log_weights, weights, out):  # type: ignore[no-untyped-def]
    """Write the normalised form of centred log weights."""
    total = 0.0
    for k in range(weights.shape[0]):
        total += weights[k]
    log_total = np.log(total)
    for k in range(weights.shape[0]):
        out[k] = log_weights[k] - log_total


@numba.njit(types.void(_F8_1, _F8_1, _LOGS_2, _LOGS_2, _F8_1), cache=True, nogil=True)
def _propagate(log_weights, weights, log_matrix, matrix, out):  # type: ignore[no-untyped-def]
    """Write ``out[j] = log sum_i weights[i] matrix[i, j]`` of centred weights.

    A plain sum of products wherever no term of it can have underflowed, which spares an exponential a term.
    """
    size = weights.shape[0]
    for j in range(size):
        total = 0.0
        for i in range(size):
            total += weights[i] * matrix[i, j]
        if total > _TOO_SMALL:
            out[j] = np.log(total)
            continue
        peak = -np.inf
        for i in range(size):
            peak = max(peak, log_weights[i] + log_matrix[i, j])
        if peak == -np.inf:
            out[j] = -np.inf
            continue
        total = 0.0
        for i in range(size):
            total += np.exp(log_weights[i] + log_matrix[i, j] - peak)
        out[j] = peak + np.log(total)


@numba.njit(
    types.int64(_LOGS_2, _ROWS, _LOGS_2, _LOGS_3, _LOGS_3, _ROWS, _FLAGS, _F8_2),
    cache=True,
    nogil=True,
)
def forward_kernel(  # type: ignore[no-untyped-def]
    log_likelihood, row_size, log_prior, log_transition, transition, which_transition, continues, out
):
    """Filter forwards into `out`; a transition numbered -1 is the identity."""
    size = log_likelihood.shape[1]
    state, weights, predicted = np.empty(size), np.empty(size), np.empty(size)
    sample = 0
    for row in range(row_size.shape[0]):
        which = which_transition[row]
        for position in range(row_size[row]):
            if position == 0 and not continues[row]:
                state[:] = log_prior[row]
            elif which >= 0:
                _propagate(state, weights, log_transition[which], transition[which], predicted)
                state[:] = predicted
            for k in range(size):
                if not log_likelihood[sample, k] < np.inf:
                    return INVALID - sample
                state[k] += log_likelihood[sample, k]
            if not _centre(state, weights):
                return sample
            _normalise(state, weights, out[sample])
            sample += 1
    return OK


@numba.njit(types.boolean(_LOGS_2, _F8_2), cache=True, nogil=True)
def centre_samples(log_likelihood, out):  # type: ignore[no-untyped-def]
    """Write log likelihoods less each sample's peak; false where exponentials of them would lose anything."""
    lowest = np.log(_TOO_SMALL)
    for sample in range(log_likelihood.shape[0]):
        peak = log_likelihood[sample, 0]
        for k in range(1, log_likelihood.shape[1]):
            peak = max(peak, log_likelihood[sample, k])
        if not -np.inf < peak < np.inf:
            return False
        for k in range(log_likelihood.shape[1]):
            centred = log_likelihood[sample, k] - peak
            if not (centred > lowest or centred == -np.inf):
                return False
            out[sample, k] = centred
    return True


@numba.njit(
    types.boolean(_LOGS_2, _ROWS, _LOGS_2, _LOGS_3, _ROWS, _FLAGS, _F8_2),
    cache=True,
    nogil=True,
)
def plain_forward_kernel(  # type: ignore[no-untyped-def]
    likelihood, row_size, log_prior, transition, which_transition, continues, out
):
    """Filter forwards in plain numbers: write prediction / evidence, which times the likelihood is the posterior.

    Several times as fast as `forward_kernel`, as no exponential or logarithm is taken here; false, with `out` to be
    thrown away, as soon as a number is so small that terms may have underflowed, or nothing is possible.
    """
    size = likelihood.shape[1]
    state, predicted = np.zeros(size), np.empty(size)
    sample = 0
    for row in range(row_size.shape[0]):
        for position in range(row_size[row]):
            if position == 0 and not continues[row]:
                for k in range(size):
                    predicted[k] = np.exp(log_prior[row, k])
                    if predicted[k] <= _TOO_SMALL and log_prior[row, k] > -np.inf:
                        return False
            else:
                matrix = transition[which_transition[row]]
                for j in range(size):
                    probability = 0.0
                    for i in range(size):
                        probability += state[i] * matrix[i, j]
                    predicted[j] = probability
                    if probability <= _TOO_SMALL:
                        # zero is sound where no way leads there
                        for i in range(size):
                            if state[i] > 0.0 and matrix[i, j] > 0.0:
                                return False
            evidence = 0.0
            for k in range(size):
                state[k] = predicted[k] * likelihood[sample, k]
                if state[k] <= _TOO_SMALL and predicted[k] > 0.0 and likelihood[sample, k] > 0.0:
                    return False
                evidence += state[k]
            if not 0.0 < evidence < np.inf:
                return False
            scale = 1.0 / evidence
            for k in range(size):
                out[sample, k] = predicted[k] * scale
                state[k] *= scale
            sample += 1
    return True


@numba.njit(
    types.void(_LOGS_2, _ROWS, _LOGS_3, _LOGS_3, _ROWS, _FLAGS, _F8_2),
    cache=True,
    nogil=True,
)
def backward_kernel(  # type: ignore[no-untyped-def]
    log_likelihood, row_size, log_reverse, reverse, which_transition, continues, log_posterior
):
    """Turn filtered log posteriors into smoothed ones, in place, from the last sample to the first.

    The transitions come transposed, ``log_reverse[m, j, i] = log p(next = j given now = i)``.
    """
    size = log_likelihood.shape[1]
    future = np.zeros(size)  # log p(all later evidence of the chain | now), up to a constant
    work, weights = np.empty(size), np.empty(size)
    sample = log_likelihood.shape[0]
    for row in range(row_size.shape[0] - 1, -1, -1):
        for position in range(row_size[row] - 1, -1, -1):
            sample -= 1
            later = row if position < row_size[row] - 1 else row + 1
            if later > row and (later == row_size.shape[0] or not continues[later]):
                future[:] = 0.0  # the chain ends here
                continue
            for k in range(size):
                work[k] = log_likelihood[sample + 1, k] + future[k]
            _centre(work, weights)
            which = which_transition[later]
            if which < 0:
                future[:] = work
            else:
                _propagate(work, weights, log_reverse[which], reverse[which], future)
            for k in range(size):
                work[k] = log_posterior[sample, k] + future[k]
            _centre(work, weights)
            _normalise(work, weights, log_posterior[sample])
