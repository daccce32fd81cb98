"""A second implementation in rational arithmetic: sums of squares by means, epsilon by covariances of levels."""

import itertools
from fractions import Fraction

import numpy as np


def exact_effects(values):
    """Return {effect: (SS effect, df1, SS error, df2)} by inclusion and exclusion of marginal means."""
    values = np.vectorize(Fraction, otypes=[object])(values)
    axes = range(values.ndim)
    found = {}
    for effect in itertools.chain.from_iterable(
        itertools.combinations(axes[1:], size) for size in range(1, values.ndim)
    ):
        both = [_sum_of_squares(values, effect), _sum_of_squares(values, (0, *effect))]
        df1 = int(np.prod([values.shape[axis] - 1 for axis in effect]))
        found[tuple(axis - 1 for axis in effect)] = (both[0], df1, both[1], df1 * (len(values) - 1))
    return found


def _sum_of_squares(values, effect):
    """Return the sum of squares of an effect: of the marginal means with all lower effects taken off."""
    residual = np.zeros_like(values)
    for size in range(len(effect) + 1):
        for part in itertools.combinations(effect, size):
            rest = tuple(axis for axis in range(values.ndim) if axis not in part)
            count = int(np.prod([values.shape[axis] for axis in rest])) if rest else 1
            mean = values.sum(axis=rest, keepdims=True) / Fraction(count) if rest else values
            residual = residual + (-1) ** (len(effect) - size) * mean
    return (residual**2).sum()


def exact_epsilon(values):
    """Return Greenhouse and Geisser's epsilon of a one-factor design from the covariances of its levels (Box 1954)."""
    n, k = values.shape
    table = [[Fraction(int(value)) for value in row] for row in values]
    means = [sum(column) / n for column in zip(*table, strict=True)]
    s = [
        [sum((row[i] - means[i]) * (row[j] - means[j]) for row in table) / (n - 1) for j in range(k)]
        for i in range(k)
    ]
    diagonal = sum(s[i][i] for i in range(k)) / k
    grand = sum(map(sum, s)) / k**2
    rows = [sum(row) / k for row in s]
    under = (k - 1) * (
        sum(cell**2 for row in s for cell in row) - 2 * k * sum(row**2 for row in rows) + k**2 * grand**2
    )
    return k**2 * (diagonal - grand) ** 2 / under if under else None
