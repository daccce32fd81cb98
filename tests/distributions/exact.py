"""A second algebra in rational arithmetic, cell by cell, to hold the first to."""

from fractions import Fraction
from itertools import product

import numpy as np

from ppinfer import Factor


class Exact:
    """A function over named labels as a dictionary of fractions."""

    def __init__(self, axes, table):
        self.axes = {axis.name: axis for axis in axes}
        self.table = table  # frozenset of (name, label) -> Fraction

    @classmethod
    def of(cls, axes, weights):
        cells = product(*([(axis.name, label) for label in axis.labels] for axis in axes))
        flat = np.asarray(weights).reshape(-1).tolist()
        return cls(axes, {frozenset(cell): Fraction(w) for cell, w in zip(cells, flat, strict=True)})

    def _cells(self, axes):
        return (
            frozenset(cell)
            for cell in product(*([(a.name, label) for label in a.labels] for a in axes.values()))
        )

    def at(self, cell):
        return self.table[frozenset(item for item in cell if item[0] in self.axes)]

    def __mul__(self, other):
        axes = self.axes | other.axes
        return Exact(axes.values(), {cell: self.at(cell) * other.at(cell) for cell in self._cells(axes)})

    def __truediv__(self, other):
        axes = self.axes | other.axes
        table = {}
        for cell in self._cells(axes):
            above, below = self.at(cell), other.at(cell)
            table[cell] = Fraction(0) if above == below == 0 else above / below
        return Exact(axes.values(), table)

    def _over(self, names, combine):
        rest = {name: axis for name, axis in self.axes.items() if name not in names}
        groups = {}
        for cell, value in self.table.items():
            groups.setdefault(frozenset(item for item in cell if item[0] in rest), []).append(value)
        return Exact(rest.values(), {cell: combine(values) for cell, values in groups.items()})

    def sum(self, *names):
        return self._over(names, sum)

    def max(self, *names):
        return self._over(names, max)

    def normalize(self, *names):
        return self / self.sum(*names)

    def agrees_with(self, factor: Factor, tolerance=2e-14):
        """Whether every cell has the same zero, and the same value relatively."""
        assert set(factor.axes) == set(self.axes.values())
        values = np.exp(factor.log_values)
        for index in np.ndindex(*factor.shape):
            cell = frozenset((axis.name, axis.labels[i]) for axis, i in zip(factor.axes, index, strict=True))
            exact = self.table[cell]
            if exact == 0:
                assert factor.log_values[index] == -np.inf, (dict(cell), values[index])
            else:
                assert abs(values[index] / float(exact) - 1.0) <= tolerance, (
                    dict(cell),
                    values[index],
                    exact,
                )
        return True
