"""How the arrays of two factors are brought onto one grid: axes align by name and must carry equal labels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal, TypeAlias

from ppinfer.distributions.axis import Axis, check_same
from ppinfer.distributions.logspace import Array
from ppinfer.errors import AxisError

Axes: TypeAlias = tuple[Axis, ...]
Kind: TypeAlias = Literal["random", "given", "batch"]
"""What an axis of a distribution is: summed to one over, a condition, or an index of independent copies."""
Kinds: TypeAlias = tuple[Kind, ...]


def positions_of(axes: Axes, names: Iterable[str]) -> tuple[int, ...]:
    """Return where the named axes are.

    Raises
    ------
    AxisError
        If there is no such axis, or a name is given twice.
    """
    known = [axis.name for axis in axes]
    positions = []
    for name in names:
        if name not in known:
            has = ", ".join(known) if known else "none"
            raise AxisError(f"there is no axis {name!r} here; the axes are: {has}")
        position = known.index(name)
        if position in positions:
            raise AxisError(f"axis {name!r} is named twice")
        positions.append(position)
    return tuple(positions)


def check_axes(axes: Iterable[Axis]) -> Axes:
    """Return axes as a tuple, or say which of them is no `Axis` or repeats a name."""
    checked = tuple(axes)
    names: set[str] = set()
    for axis in checked:
        if not isinstance(axis, Axis):
            raise AxisError(f"expected an Axis, got {axis!r}; write Axis(name, labels)")
        if axis.name in names:
            raise AxisError(f"two axes are called {axis.name!r}; rename one of them")
        names.add(axis.name)
    return checked


def joined(left: Axes, right: Axes) -> Axes:
    """Return the axes of the left, then those that only the right has.

    Raises
    ------
    AxisError
        If an axis of the same name carries other labels on the two sides.
    """
    if left is right or left == right:
        return left
    mine = {axis.name: axis for axis in left}
    extra = []
    for axis in right:
        same = mine.get(axis.name)
        if same is None:
            extra.append(axis)
        elif same is not axis:
            check_same(same, axis)
    return left + tuple(extra) if extra else left


def laid_out(log_values: Array, axes: Axes, onto: Sequence[Axis]) -> Array:
    """Return a view of the values with dimensions in the order of `onto`, length 1 for axes that they lack.

    Every axis of the values must be among `onto`, with equal labels.
    """
    if axes is onto or axes == onto:
        return log_values
    place = {axis.name: position for position, axis in enumerate(axes)}
    order = [place[axis.name] for axis in onto if axis.name in place]
    if order != list(range(len(order))):
        log_values = log_values.transpose(order)
    shape = [len(axis) if axis.name in place else 1 for axis in onto]
    return log_values.reshape(shape)
