"""How often positions of conditions are as uneven where each participant's order is drawn at random."""

from __future__ import annotations

import math
from itertools import combinations_with_replacement, permutations

import numpy as np
from jaxtyping import Int

EXACT_ASSIGNMENTS = 200_000
RANDOM_ASSIGNMENTS = 20_000
# counts in memory at a time, and draws of a condition in all
_MAX_CELLS = 1 << 24
_MAX_DRAWS = 400_000_000


def p_of_unevenness(
    positions: Int[np.ndarray, "condition position"], participants: int, *, seed: int = 0
) -> tuple[float, str]:
    """Return how often random orders are at least as uneven as some counts, and how that was found out.

    1. Unevenness is the sum of squares of the counts: Anderson's statistic grows with it, and whole numbers have ties
       that are ties.
    2. With up to 200,000 ways to give participants orders, their probabilities are added up.
    3. With more, 20,000 are drawn (fewer of very large studies), and what occurred counts as one of them (Davison &
       Hinkley 1997, section 4.2.2).

    Parameters
    ----------
    positions : (condition, position) int64
        How many participants met each condition at each position.
    participants : int
        How many they are, at least 1.
    seed : int
        Of random assignments.

    Returns
    -------
    tuple
        The p-value, and ``"exact"`` or how many random assignments.

    Examples
    --------
    Three participants with one order of two conditions: 2 of the 8 ways to give them orders are as uneven.

    >>> p, method = p_of_unevenness(np.array([[3, 0], [0, 3]]), 3)
    >>> round(p, 6), method
    (0.25, 'exact')
    """
    k, n = len(positions), participants
    observed = int((positions**2).sum())
    orders = math.factorial(k)
    if k <= 6 and math.comb(n + orders - 1, orders - 1) <= EXACT_ASSIGNMENTS:
        return _exact(observed, k, n), "exact"
    assignments = max(1, min(RANDOM_ASSIGNMENTS, _MAX_DRAWS // (n * k)))
    rng = np.random.default_rng(seed)
    step = max(1, _MAX_CELLS // k**2)
    reached = sum(
        _as_uneven(observed, k, n, min(step, assignments - start), rng)
        for start in range(0, assignments, step)
    )
    return (reached + 1) / (assignments + 1), f"{assignments} random assignments"


def _as_uneven(observed: int, k: int, n: int, assignments: int, rng: np.random.Generator) -> int:
    """Draw some assignments, and count those that are at least as uneven."""
    counts = np.zeros((assignments, k, k), np.int64)
    draws = np.arange(assignments)[:, None]
    for _ in range(n):
        drawn = rng.permuted(np.tile(np.arange(k), (assignments, 1)), axis=1)
        counts[draws, drawn, np.arange(k)] += 1
    return int(((counts**2).sum(axis=(1, 2)) >= observed).sum())


def _exact(observed: int, k: int, n: int) -> float:
    """Add up the probabilities of all ways to give n participants orders, by how many have each order."""
    tables = np.array(
        [[[int(order[at] == c) for at in range(k)] for c in range(k)] for order in permutations(range(k))]
    )
    orders = len(tables)
    # bars between stars: every composition of n into as many parts as there are orders
    bars = np.array(list(combinations_with_replacement(range(n + 1), orders - 1)), np.int64)
    edges = np.column_stack([np.zeros(len(bars), np.int64), bars, np.full(len(bars), n)])
    counts = np.diff(edges, axis=1)
    log_factorial = np.array([math.lgamma(i + 1) for i in range(n + 1)])
    log_p = log_factorial[n] - log_factorial[counts].sum(axis=1) - n * math.log(orders)
    squares = (np.tensordot(counts, tables, axes=(1, 0)) ** 2).sum(axis=(1, 2))
    return min(1.0, float(np.exp(log_p[squares >= observed]).sum()))
