"""A non-negative function over named, labelled, finite axes, in log space."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from jaxtyping import Float

from ppinfer.distributions import faces
from ppinfer.distributions.axis import Axis, Label, check_same, first_cell
from ppinfer.distributions.checks import check_power, checked_logs, checked_mask, checked_values
from ppinfer.distributions.layout import Axes, Kinds, check_axes, joined, laid_out, positions_of
from ppinfer.distributions.logspace import Array, log_indicator, log_sum_exp
from ppinfer.errors import AxisError, FactorError

if TYPE_CHECKING:
    from ppinfer.distributions.distribution import Distribution


class Factor:
    """A non-negative function over its axes, in log space, where -inf is an honest zero.

    Frozen: the array is read-only and every operation returns a new factor. Axes align by name and must carry
    equal labels, in the same order; anything else is an error that names both sides.

    Products and quotients add and subtract log values without looking at each sum, for speed: where log values beyond
    about 1e308 add up, NumPy warns of the overflow, and normalising refuses the result. Powers look, and refuse.

    Parameters
    ----------
    axes : sequence of Axis
        One for each dimension of `log_values`; none for a scalar.
    log_values : array of float, shape (len(axis), ...)
        Natural logarithms; -inf for zero.

    Raises
    ------
    AxisError
        If two axes share a name.
    FactorError
        If the shape does not fit the axes, or a value is NaN or +inf; the message names the cell.

    See Also
    --------
    Factor.from_values : the same from the numbers themselves.
    Distribution : a factor that sums to one.

    Examples
    --------
    >>> goal = Axis("goal", ["cup", "bowl"])
    >>> f = Factor.from_values([goal], [1.0, 3.0])
    >>> (f * f).values
    array([1., 9.])
    >>> f.normalize("goal").prob(goal="bowl")
    0.75
    """

    __slots__ = ("_axes", "_log_values")
    _axes: Axes
    _log_values: Array
    # NumPy scalars and arrays must not take over `array * factor`
    __array_ufunc__ = None

    def __init__(self, axes: Sequence[Axis], log_values: Any) -> None:
        self._axes = check_axes(axes)
        self._log_values = checked_values(self._axes, log_values)

    @staticmethod
    def _trusted(axes: Axes, log_values: Array) -> Factor:
        """Wrap values that are known to be sound, and that nobody else will write to, unseen."""
        new = object.__new__(Factor)
        log_values.setflags(write=False)
        new._axes = axes
        new._log_values = log_values
        return new

    @classmethod
    def from_values(cls, axes: Sequence[Axis], values: Any) -> Factor:
        """Make a factor from the non-negative numbers themselves.

        Examples
        --------
        >>> Factor.from_values([Axis("goal", ["cup", "bowl"])], [0.0, 2.0]).log_values.tolist()
        [-inf, 0.6931471805599453]
        """
        return Factor(axes, checked_logs(check_axes(axes), values))

    @classmethod
    def from_mask(cls, axes: Sequence[Axis], mask: Any) -> Factor:
        """Make an indicator: one where the mask is true, zero elsewhere.

        Examples
        --------
        >>> Factor.from_mask([Axis("goal", ["cup", "bowl"])], [True, False]).values
        array([1., 0.])
        """
        return Factor(axes, log_indicator(checked_mask(check_axes(axes), mask)))

    @classmethod
    def from_xarray(cls, array: xr.DataArray) -> Factor:
        """Make a factor from log values in an `xarray.DataArray`; a dimension without labels is a range axis.

        Examples
        --------
        >>> f = Factor.from_values([Axis("goal", ["cup", "bowl"])], [1.0, 3.0])
        >>> Factor.from_xarray(f.to_xarray()) == f
        True
        """
        return Factor(faces.axes_of_xarray(array), array.values)

    # what it holds

    @property
    def axes(self) -> Axes:
        """The axes, in the order of the array's dimensions."""
        return self._axes

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the axes, in order."""
        return tuple(axis.name for axis in self._axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """The lengths of the axes, in order."""
        return self._log_values.shape

    @property
    def log_values(self) -> Float[np.ndarray, "..."]:
        """Natural logarithms of the values, one dimension an axis (read-only)."""
        return self._log_values

    @property
    def values(self) -> Float[np.ndarray, "..."]:
        """The values themselves; they may underflow to 0 (or overflow) where their logarithms do not."""
        return np.asarray(np.exp(self._log_values))

    def axis(self, name: str) -> Axis:
        """Return the axis of a name.

        Examples
        --------
        >>> Factor.from_values([Axis("goal", ["cup", "bowl"])], [1, 3]).axis("goal")
        Axis('goal', ['cup', 'bowl'])
        """
        return self._axes[positions_of(self._axes, (name,))[0]]

    # arithmetic

    def __mul__(self, other: Factor) -> Factor:
        if not isinstance(other, Factor):
            return NotImplemented
        axes, left, right = self._meet(other)
        return Factor._trusted(axes, np.asarray(left + right))

    def __truediv__(self, other: Factor) -> Factor:
        if not isinstance(other, Factor):
            return NotImplemented
        axes, left, right = self._meet(other)
        zero = right == -math.inf
        if not zero.any():
            return Factor._trusted(axes, np.asarray(left - right))
        shape = tuple(len(axis) for axis in axes)
        undefined = np.broadcast_to(zero & (left > -math.inf), shape)
        if undefined.any():
            raise FactorError(
                f"division by zero at {first_cell(axes, undefined)}: the numerator is positive where the "
                "denominator is 0 (only 0 / 0 is defined, as 0)"
            )
        # 0 / 0 = 0: support only shrinks
        return Factor._trusted(axes, np.asarray(left - np.where(zero, 0.0, right)))

    def __pow__(self, exponent: float) -> Factor:
        power = float(exponent)
        if not math.isfinite(power):
            raise FactorError(f"the exponent of a factor must be finite, not {power}")
        if power == 0.0:
            return Factor._trusted(self._axes, np.zeros_like(self._log_values))  # 0 ** 0 = 1
        if power < 0.0:
            zero = self._log_values == -math.inf
            if zero.any():
                raise FactorError(f"0 ** {power} is undefined, at {first_cell(self._axes, zero)}")
        if abs(power) <= 1.0:
            return Factor._trusted(self._axes, np.asarray(self._log_values * power))
        with np.errstate(over="ignore"):
            result = np.asarray(self._log_values * power)
        check_power(self._axes, self._log_values, result, power)
        return Factor._trusted(self._axes, result)

    def sum(self, *names: str) -> Factor:
        """Sum over the named axes (all, if none is named).

        Examples
        --------
        >>> grid = Factor.from_values([Axis("a", 2), Axis("b", 2)], [[1.0, 2.0], [3.0, 4.0]])
        >>> grid.sum("a").values
        array([4., 6.])
        """
        over, rest = self._split(names)
        return Factor._trusted(rest, np.asarray(log_sum_exp(self._log_values, over)))

    def max(self, *names: str) -> Factor:
        """Take the largest value over the named axes (all, if none is named).

        Examples
        --------
        >>> grid = Factor.from_values([Axis("a", 2), Axis("b", 2)], [[1.0, 2.0], [4.0, 3.0]])
        >>> grid.max("b").values
        array([2., 4.])
        """
        over, rest = self._split(names)
        return Factor._trusted(rest, np.array(self._log_values.max(axis=over)))

    # picking and arranging

    def restrict(self, **labels: Label | np.generic | Iterable[Any]) -> Factor:
        """Keep some labels: one label drops its axis; several (a list, a range) reorder or shorten it.

        Examples
        --------
        >>> f = Factor.from_values([Axis("goal", ["cup", "bowl", "mug"])], [1.0, 2.0, 3.0])
        >>> f.restrict(goal="mug").values.round(12).item()
        3.0
        >>> f.restrict(goal=["mug", "cup"]).values.round(12)
        array([3., 1.])
        """
        axes, values = self._restricted(labels)
        return Factor._trusted(axes, values)

    def _restricted(self, labels: dict[str, Any]) -> tuple[Axes, Array]:
        places = dict(zip(positions_of(self._axes, labels), labels.values(), strict=True))
        axes, values, dimension = [], self._log_values, 0
        for position, axis in enumerate(self._axes):
            if position not in places:
                axes.append(axis)
                dimension += 1
                continue
            chosen = places[position]
            if isinstance(chosen, str) or not isinstance(chosen, Iterable):
                values = values.take(axis.index(chosen), axis=dimension)
                continue
            shorter, indices = axis.restrict(chosen)
            values = values.take(indices, axis=dimension)
            axes.append(shorter)
            dimension += 1
        return tuple(axes), np.array(values)

    def rename(self, **names: str) -> Factor:
        """Rename axes, old name to new.

        Examples
        --------
        >>> Factor.from_values([Axis("goal", ["cup", "bowl"])], [1, 3]).rename(goal="post_goal").names
        ('post_goal',)
        """
        return Factor._trusted(self._renamed(names), self._log_values)

    def _renamed(self, names: dict[str, str]) -> Axes:
        positions_of(self._axes, names)
        return check_axes(
            axis.rename(names[axis.name]) if axis.name in names else axis for axis in self._axes
        )

    def where(self, mask: Any) -> Factor:
        """Keep the values where a mask is true; zero elsewhere.

        Parameters
        ----------
        mask : array of bool, of this factor's shape; or Factor
            A factor must be an indicator (values 0 and 1) and aligns by name.

        Examples
        --------
        >>> f = Factor.from_values([Axis("goal", ["cup", "bowl"])], [1.0, 3.0])
        >>> f.where(np.array([False, True])).normalize("goal").prob(goal="bowl")
        1.0
        """
        if isinstance(mask, Factor):
            odd = (mask._log_values != 0.0) & (mask._log_values != -math.inf)
            if odd.any():
                raise FactorError(
                    f"a mask has values 0 and 1 only, but is neither at {first_cell(mask._axes, odd)}; "
                    "multiply by it, or make an indicator with Factor.from_mask"
                )
            axes, left, right = self._meet(mask)
            return Factor._trusted(axes, np.asarray(left + right))
        keep = checked_mask(self._axes, mask)
        return Factor._trusted(self._axes, np.where(keep, self._log_values, -math.inf))

    def align(self, *axes: Axis | str) -> Factor:
        """Lay the same function out over these axes, in this order.

        Parameters
        ----------
        *axes : Axis or str
            All axes of the factor, by name or whole. An `Axis` that it lacks is added: the factor is constant
            there.

        Examples
        --------
        >>> grid = Factor.from_values([Axis("a", 2), Axis("b", 3)], np.arange(6.0).reshape(2, 3))
        >>> grid.align("b", "a").shape, grid.align(Axis("c", 4), "a", "b").shape
        ((3, 2), (4, 2, 3))
        """
        onto, values = self._aligned(axes)
        return Factor._trusted(onto, values)

    def _aligned(self, axes: Sequence[Axis | str]) -> tuple[Axes, Array]:
        onto = check_axes(self.axis(axis) if isinstance(axis, str) else axis for axis in axes)
        mine = {axis.name: axis for axis in self._axes}
        for axis in onto:
            if axis.name in mine:
                check_same(mine.pop(axis.name), axis)
        if mine:
            raise AxisError(
                f"align must name every axis; {', '.join(mine)} would be lost (sum or restrict first)"
            )
        shape = tuple(len(axis) for axis in onto)
        return onto, np.array(np.broadcast_to(laid_out(self._log_values, self._axes, onto), shape))

    # becoming a distribution

    def normalize(self, *random: str, batch: Iterable[str] = ()) -> Distribution:
        """Divide by the sum over the random axes.

        Parameters
        ----------
        *random : str
            The axes over which the result sums to one.
        batch : iterable of str
            The axes that index independent copies. All others are `given`: the result is a conditional in
            them.

        Raises
        ------
        ImpossibleEvidenceError
            If a cell of the other axes has no support; the message names it.

        Examples
        --------
        >>> grid = Factor.from_values([Axis("goal", 2), Axis("trial", 2)], [[1.0, 1.0], [3.0, 1.0]])
        >>> grid.normalize("goal", batch=["trial"])
        Distribution p(goal; trial): goal 2, trial 2
        """
        from ppinfer.distributions.distribution import Distribution

        apart = (batch,) if isinstance(batch, str) else tuple(batch)
        positions_of(self._axes, (*random, *apart))
        if not random:
            raise AxisError("normalize must name at least one axis to sum to one over")
        kinds: Kinds = tuple(
            "random" if name in random else "batch" if name in apart else "given" for name in self.names
        )
        return Distribution._normalised(self._axes, self._log_values, kinds)

    # comparing and showing

    def __eq__(self, other: object) -> bool:
        """Whether the other is the same function, exactly; the order of the axes does not matter."""
        if type(other) is not type(self):
            return NotImplemented
        assert isinstance(other, Factor)
        if set(self._axes) != set(other._axes):
            return False
        return np.array_equal(self._log_values, laid_out(other._log_values, other._axes, self._axes))

    __hash__ = None  # type: ignore[assignment]  # compared by value, and values are floats

    def allclose(self, other: Factor, *, atol: float = 1e-12, rtol: float = 0.0) -> bool:
        """Tell whether the logarithms agree within a tolerance and the zeros exactly, in any order of axes.

        Parameters
        ----------
        other : Factor
            Over the same axes.
        atol, rtol : float
            Absolute and relative tolerance of the log values.

        Raises
        ------
        AxisError
            If an axis carries other labels there.

        Examples
        --------
        >>> f = Factor.from_values([Axis("goal", 2)], [1.0, 3.0])
        >>> (f * f).allclose(f**2)
        True
        """
        axes = joined(self._axes, other._axes)
        if len(axes) != len(self._axes) or len(axes) != len(other._axes):
            return False
        theirs = laid_out(other._log_values, other._axes, self._axes)
        zero = self._log_values == -math.inf
        if not np.array_equal(zero, theirs == -math.inf):
            return False
        return bool(np.allclose(self._log_values[~zero], theirs[~zero], rtol=rtol, atol=atol))

    def to_xarray(self) -> xr.DataArray:
        """Return the log values as an `xarray.DataArray` (a copy), named ``log_value``.

        Examples
        --------
        >>> Factor.from_values([Axis("goal", ["cup", "bowl"])], [1.0, 3.0]).to_xarray().dims
        ('goal',)
        """
        return faces.to_xarray(self._axes, self._log_values, name="log_value", attrs={})

    def __repr__(self) -> str:
        return f"Factor {faces.signature('f', self._axes)}"

    def _repr_html_(self) -> str:
        return faces.html_table(repr(self), self._axes, self._log_values, "log value")

    def __reduce__(self) -> tuple[Any, ...]:
        return (_rebuilt, (self._axes, self._log_values))

    def _meet(self, other: Factor) -> tuple[Axes, Array, Array]:
        """Return the union of the axes and both arrays laid out on it."""
        if not isinstance(other, Factor):
            raise FactorError(
                f"expected a Factor to go with {self!r}, got {type(other).__name__}; Factor(axes, log_values) or "
                "Factor.from_values(axes, values) makes one"
            )
        mine, theirs = self._axes, other._axes
        if mine is theirs:
            return mine, self._log_values, other._log_values
        axes = joined(mine, theirs)
        return axes, laid_out(self._log_values, mine, axes), laid_out(other._log_values, theirs, axes)

    def _split(self, names: tuple[str, ...]) -> tuple[tuple[int, ...], Axes]:
        """Return the positions of the named axes (all, if none) and the other axes."""
        over = positions_of(self._axes, names or self.names)
        return over, tuple(axis for position, axis in enumerate(self._axes) if position not in over)


def _rebuilt(axes: Axes, log_values: Array) -> Factor:
    return Factor._trusted(axes, log_values)
