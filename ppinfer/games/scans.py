"""Compiled passes over batches of games. Importing this module loads numba; nothing imports it before it is needed.

The signatures are explicit, so that each kernel is compiled once and cached, whether or not its inputs are read-only.
Costs hold no NaN and no -inf, which `Game` sees to.
"""

from __future__ import annotations

import numba
import numpy as np
from numba import types


def _read_only(kind: types.Type, ndim: int) -> types.Array:
    # arrays that may be written to are accepted for these as well
    return types.Array(kind, ndim, "C", readonly=True)


_COSTS_4 = _read_only(types.float64, 4)
_COSTS_3 = _read_only(types.float64, 3)
_MASK_2 = _read_only(types.boolean, 2)
_MASK_3 = _read_only(types.boolean, 3)


@numba.njit(
    [
        types.void(_COSTS_4, types.boolean, types.boolean, types.boolean[:, :, ::1]),
        types.void(_COSTS_4, types.float64, types.float64, types.float64[:, :, ::1]),
    ],
    cache=True,
    nogil=True,
    # costs are no NaN, and -0.0 = 0.0: then the least of a row may be sought in any order
    fastmath={"nnan", "nsz"},
)
def _mark_pure2(costs, yes, no, out):  # type: ignore[no-untyped-def]
    """Write `yes` at the pure equilibria of two-player games, and `no` elsewhere, in one pass over the costs."""
    games, _, m, n = costs.shape
    best = np.empty(n)
    for game in range(games):
        first, second, marked = costs[game, 0], costs[game, 1], out[game]
        for j in range(n):
            best[j] = first[0, j]
        for i in range(1, m):
            for j in range(n):
                best[j] = min(best[j], first[i, j])
        for i in range(m):
            least = second[i, 0]
            for j in range(1, n):
                least = min(least, second[i, j])
            for j in range(n):
                marked[i, j] = yes if (first[i, j] <= best[j]) & (second[i, j] <= least) else no


def pure_mask2(costs: np.ndarray) -> np.ndarray:
    """Return which profiles of two-player games are pure equilibria.

    Parameters
    ----------
    costs : (game, 2, m, n) float64, C order
        Without NaN or -inf; inf is allowed.

    Returns
    -------
    (game, m, n) bool
        True where neither player's cost is above that of its best reply (inf is not above inf).

    Examples
    --------
    >>> pure_mask2(np.array([[[[1.0, np.inf]], [[2.0, 3.0]]]]))
    array([[[ True, False]]])
    """
    # NumPy's memory, which is handed out in large pages
    mask = np.empty((len(costs), *costs.shape[2:]), np.bool_)
    _mark_pure2(costs, True, False, mask)
    return mask


def pure_log_indicator2(costs: np.ndarray) -> np.ndarray:
    """Return `pure_mask2` as log values: 0 at the equilibria, -inf elsewhere.

    Examples
    --------
    >>> pure_log_indicator2(np.array([[[[1.0, np.inf]], [[2.0, 3.0]]]]))
    array([[[  0., -inf]]])
    """
    log_values = np.empty((len(costs), *costs.shape[2:]))
    _mark_pure2(costs, 0.0, -np.inf, log_values)
    return log_values


@numba.njit(types.void(_COSTS_3, types.float64[:, ::1]), cache=True, nogil=True)
def _mark_finite(costs, out):  # type: ignore[no-untyped-def]
    games, players, profiles = costs.shape
    for game in range(games):
        for profile in range(profiles):
            out[game, profile] = 0.0 if costs[game, 0, profile] < np.inf else -np.inf
        for player in range(1, players):
            for profile in range(profiles):
                if not costs[game, player, profile] < np.inf:
                    out[game, profile] = -np.inf


def finite_log_indicator(costs: np.ndarray) -> np.ndarray:
    """Return, for (game, player, profile) costs in C order, 0 where no player's is infinite and -inf elsewhere.

    Examples
    --------
    >>> finite_log_indicator(np.array([[[1.0, np.inf], [2.0, 3.0]]]))
    array([[  0., -inf]])
    """
    log_values = np.empty((costs.shape[0], costs.shape[2]))
    _mark_finite(costs, log_values)
    return log_values


@numba.njit(types.boolean[:, ::1](_COSTS_3, _MASK_2, types.boolean), cache=True, nogil=True)
def undominated_mask(costs, among, strict):  # type: ignore[no-untyped-def]
    """Return which of the marked profiles no other marked one dominates, for any number of players.

    Parameters
    ----------
    costs : (game, player, profile) float64
        Without NaN or -inf; the grid of plans laid out flat.
    among : (game, profile) bool
        The profiles that are compared with each other.
    strict : bool
        Whether only being beaten for every player counts; otherwise being at most as dear for all players and
        cheaper for one does.

    Returns
    -------
    (game, profile) bool
        Steps: the profiles are gone through in order, and those that nothing seen so far dominates are kept; a new
        one drops those kept that it dominates. Dominance is transitive, so comparing with those kept is enough.
    """
    games, players, profiles = costs.shape
    mask = np.zeros((games, profiles), np.bool_)
    kept = np.empty(profiles, np.int64)
    for game in range(games):
        table = costs[game]
        count = 0
        for new in range(profiles):
            if not among[game, new]:
                continue
            dominated = False
            left = 0
            for k in range(count):
                old = kept[k]
                cheaper, dearer = 0, 0
                for player in range(players):
                    cheaper += table[player, new] < table[player, old]
                    dearer += table[player, new] > table[player, old]
                if (dearer == players) if strict else (dearer > 0 and cheaper == 0):
                    # then the new one has dropped nothing yet: what it dominates, the old one does as well
                    dominated = True
                    break
                if not ((cheaper == players) if strict else (cheaper > 0 and dearer == 0)):
                    kept[left] = old
                    left += 1
            if not dominated:
                kept[left] = new
                count = left + 1
        for k in range(count):
            mask[game, kept[k]] = True
    return mask


@numba.njit(types.boolean[:, :, ::1](_COSTS_4, _MASK_3, types.boolean), cache=True, nogil=True)
def undominated_mask2(costs, among, strict):  # type: ignore[no-untyped-def]
    """Return `undominated_mask` of two-player games, on the grid of their plans.

    Parameters
    ----------
    costs : (game, 2, m, n) float64
        Without NaN or -inf.
    among : (game, m, n) bool
        The profiles that are compared with each other.
    strict : bool
        As in `undominated_mask`.

    Returns
    -------
    (game, m, n) bool
        Those that no other dominates.
    """
    games, players, m, n = costs.shape
    flat = undominated_mask(costs.reshape((games, players, m * n)), among.reshape((games, m * n)), strict)
    return flat.reshape((games, m, n))
