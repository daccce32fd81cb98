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


@numba.njit(types.boolean(_F8_1), cache=True, nogil=True)
def _normalise(log_p):  # type: ignore[no-untyped-def]
    """Centre on the peak, then take the log of the sum off; false when nothing is possible."""
    peak = log_p[0]
    for k in range(1, log_p.shape[0]):
        peak = max(peak, log_p[k])
    if not peak > -np.inf:
        return False
    total = 0.0
    for k in range(log_p.shape[0]):
        log_p[k] -= peak
        total += np.exp(log_p[k])
    log_total = np.log(total)
    for k in range(log_p.shape[0]):
        log_p[k] -= log_total
    return True


@numba.njit(types.void(_LOGS_1, _LOGS_2, types.boolean, _F8_1), cache=True, nogil=True)
def _propagate(log_p, log_transition, backward, out):  # type: ignore[no-untyped-def]
    """Forward: out[j] = log sum_i p[i] T[i, j]; backward: out[i] = log sum_j T[i, j] p[j]."""
    size = log_p.shape[0]
    for target in range(size):
        peak = -np.inf
        for source in range(size):
            step = log_transition[target, source] if backward else log_transition[source, target]
            peak = max(peak, log_p[source] + step)
        if peak == -np.inf:
            out[target] = -np.inf
            continue
        total = 0.0
        for source in range(size):
            step = log_transition[target, source] if backward else log_transition[source, target]
            total += np.exp(log_p[source] + step - peak)
        out[target] = peak + np.log(total)


@numba.njit(
    types.int64(_LOGS_2, _ROWS, _LOGS_2, _LOGS_3, _ROWS, _FLAGS, _F8_2),
    cache=True,
    nogil=True,
)
def forward_kernel(  # type: ignore[no-untyped-def]
    log_likelihood, row_size, log_prior, log_transition, which_transition, continues, out
):
    """Filter forwards into `out`; a transition numbered -1 is the identity."""
    size = log_likelihood.shape[1]
    predicted = np.empty(size)
    sample = 0
    for row in range(row_size.shape[0]):
        which = which_transition[row]
        for position in range(row_size[row]):
            if position == 0 and not continues[row]:
                predicted[:] = log_prior[row]
            elif which < 0:
                predicted[:] = out[sample - 1]
            else:
                _propagate(out[sample - 1], log_transition[which], False, predicted)
            for k in range(size):
                if not log_likelihood[sample, k] < np.inf:
                    return INVALID - sample
                out[sample, k] = predicted[k] + log_likelihood[sample, k]
            if not _normalise(out[sample]):
                return sample
            sample += 1
    return OK


@numba.njit(
    types.void(_LOGS_2, _ROWS, _LOGS_3, _ROWS, _FLAGS, _F8_2),
    cache=True,
    nogil=True,
)
def backward_kernel(  # type: ignore[no-untyped-def]
    log_likelihood, row_size, log_transition, which_transition, continues, log_posterior
):
    """Turn filtered log posteriors into smoothed ones, in place, from the last sample to the first."""
    size = log_likelihood.shape[1]
    future = np.zeros(size)  # log p(all later evidence of the chain | now), up to a constant
    work = np.empty(size)
    sample = log_likelihood.shape[0]
    for row in range(row_size.shape[0] - 1, -1, -1):
        for position in range(row_size[row] - 1, -1, -1):
            sample -= 1
            later = row if position < row_size[row] - 1 else row + 1
            if later > row and (later == row_size.shape[0] or not continues[later]):
                future[:] = 0.0  # the chain ends here
                continue
            which = which_transition[later]
            for k in range(size):
                work[k] = log_likelihood[sample + 1, k] + future[k]
            if which < 0:
                future[:] = work
            else:
                _propagate(work, log_transition[which], True, future)
            peak = -np.inf
            for k in range(size):
                peak = max(peak, future[k])
            for k in range(size):
                future[k] -= peak
                log_posterior[sample, k] += future[k]
            _normalise(log_posterior[sample])
