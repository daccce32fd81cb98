"""A factor that sums to one: joint, conditional and batched distributions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

import numpy as np
import xarray as xr
from jaxtyping import Float

from ppinfer.distributions import expectations, faces
from ppinfer.distributions.axis import Axis, Label, first_cell
from ppinfer.distributions.checks import checked_logs
from ppinfer.distributions.factor import Factor
from ppinfer.distributions.kinds import axes_apart, chained, kinds_of, moving_axes, random_positions
from ppinfer.distributions.layout import Axes, Kind, Kinds, check_axes, positions_of
from ppinfer.distributions.logspace import Array, log_normalise, log_sum_exp
from ppinfer.errors import AxisError, FactorError, ImpossibleEvidenceError

Numbers: TypeAlias = float | Float[np.ndarray, "..."]
"""A float; or, where there are given or batch axes, an array over these, in order."""

_BATCH: Kinds = ("batch",)

SUM_TOLERANCE = 1e-9
"""How far from one a sum may be and still be taken for rounding."""


class Distribution(Factor):
    """A factor with three kinds of axes: it sums to one over the *random* ones, in every cell of the others.

    *Given* axes are those that it is a conditional in; *batch* axes (trial, sample) index independent copies.
    Factor arithmetic works on it as well. A product of two distributions is again one where the chain rule
    says so: ``p(x | y) * p(y)`` is the joint over x and y. A product over the same random axis twice (a
    product of experts), or one whose conditioning runs in a circle, is a plain `Factor`, which
    `Factor.normalize` makes a distribution.

    Parameters
    ----------
    axes : sequence of Axis
        One for each dimension of `log_values`.
    log_values : array of float, shape (len(axis), ...)
        Log probabilities; their exponentials must sum to one within 1e-9 and are scaled to do so within
        1e-12.
    given, batch : iterable of str
        Names of the axes of these kinds. All the others are random; at least one must be.

    Raises
    ------
    AxisError
        If an axis is unknown, named as two kinds, or none is random.
    FactorError
        If a value is NaN or +inf, or a sum is not one; the message names the cell.

    Examples
    --------
    >>> goal = Axis("goal", ["cup", "bowl"])
    >>> prior = Distribution.uniform(goal)
    >>> prior.update(Factor.from_values([goal], [0.2, 0.6])).values.round(12)
    array([0.25, 0.75])
    """

    __slots__ = ("_kinds", "_over")
    _kinds: Kinds
    _over: tuple[int, ...] | None

    def __init__(
        self, axes: Sequence[Axis], log_values: Any, *, given: Iterable[str] = (), batch: Iterable[str] = ()
    ) -> None:
        super().__init__(axes, log_values)
        self._kinds = kinds_of(self._axes, given, batch)
        self._over = random_positions(self._kinds)
        self._log_values = _summing_to_one(self._axes, self._log_values, self._kinds, self._over)

    @staticmethod
    def _sound(axes: Axes, log_values: Array, kinds: Kinds) -> Distribution:
        """Wrap values that are known to sum to one, and that nobody else will write to."""
        new = object.__new__(Distribution)
        log_values.setflags(write=False)
        new._axes = axes
        new._log_values = log_values
        new._kinds = kinds
        new._over = random_positions(kinds)
        return new

    @staticmethod
    def _normalised(axes: Axes, log_values: Array, kinds: Kinds) -> Distribution:
        """Make values sum to one over the random axes, or name the cell that has no support."""
        values, dead = log_normalise(log_values, random_positions(kinds))
        if dead is not None:
            random = ", ".join(axis.name for axis, kind in zip(axes, kinds, strict=True) if kind == "random")
            cells = np.squeeze(dead, axis=tuple(i for i, kind in enumerate(kinds) if kind == "random"))
            where = f" at {first_cell(axes_apart(axes, kinds), cells)}" if cells.ndim else ""
            raise ImpossibleEvidenceError(
                f"no hypothesis over {random} is possible{where}: every value there is zero (or its log is "
                "infinite). Check the evidence for contradictions, or give the hypotheses that it rules out "
                "some probability"
            )
        return Distribution._sound(axes, values, kinds)

    @classmethod
    def uniform(cls, *axes: Axis, given: Iterable[str] = (), batch: Iterable[str] = ()) -> Distribution:
        """Make the distribution that is uniform over its random axes.

        Examples
        --------
        >>> Distribution.uniform(Axis("goal", ["cup", "bowl"]), Axis("trial", 2), batch=["trial"]).values
        array([[0.5, 0.5],
               [0.5, 0.5]])
        """
        checked = check_axes(axes)
        kinds = kinds_of(checked, given, batch)
        cells = math.prod(len(axis) for axis, kind in zip(checked, kinds, strict=True) if kind == "random")
        shape = tuple(len(axis) for axis in checked)
        return cls._sound(checked, np.full(shape, -math.log(cells)), kinds)

    @classmethod
    def from_probabilities(
        cls, axes: Sequence[Axis], probabilities: Any, *, given: Iterable[str] = (), batch: Iterable[str] = ()
    ) -> Distribution:
        """Make a distribution from the probabilities themselves, which must sum to one.

        Examples
        --------
        >>> Distribution.from_probabilities([Axis("goal", ["cup", "bowl"])], [0.25, 0.75]).mode()
        {'goal': 'bowl'}
        """
        checked = check_axes(axes)
        return cls(checked, checked_logs(checked, probabilities), given=given, batch=batch)

    @classmethod
    def from_xarray(
        cls, array: xr.DataArray, *, given: Iterable[str] | None = None, batch: Iterable[str] | None = None
    ) -> Distribution:
        """Make a distribution from log probabilities in an `xarray.DataArray`.

        Parameters
        ----------
        array : xarray.DataArray
            A dimension without labels is a range axis.
        given, batch : iterable of str, optional
            Kinds of axes; by default the array's attributes ``given`` and ``batch``, as `to_xarray` writes
            them.

        Examples
        --------
        >>> p = Distribution.uniform(Axis("goal", ["cup", "bowl"]), Axis("trial", 2), batch=["trial"])
        >>> Distribution.from_xarray(p.to_xarray()) == p
        True
        """
        stated = {kind: str(array.attrs.get(kind, "")).split() for kind in ("given", "batch")}
        return cls(
            faces.axes_of_xarray(array),
            array.values,
            given=stated["given"] if given is None else given,
            batch=stated["batch"] if batch is None else batch,
        )

    # the kinds of its axes

    @property
    def random(self) -> tuple[str, ...]:
        """The names of the axes over which it sums to one."""
        return self._named("random")

    @property
    def conditions(self) -> tuple[str, ...]:
        """The names of the axes that it is a conditional in (its *given* axes)."""
        return self._named("given")

    @property
    def batch(self) -> tuple[str, ...]:
        """The names of the axes that index independent copies."""
        return self._named("batch")

    def _named(self, kind: Kind) -> tuple[str, ...]:
        return tuple(axis.name for axis, own in zip(self._axes, self._kinds, strict=True) if own == kind)

    def _positions(self, names: Iterable[str], *, kind: Kind) -> tuple[int, ...]:
        positions = positions_of(self._axes, names)
        for position in positions:
            if self._kinds[position] != kind:
                raise AxisError(
                    f"axis {self.names[position]!r} is {self._kinds[position]} here, not {kind}: {self!r}"
                )
        return positions

    # the chain rule

    def __mul__(self, other: Factor) -> Factor:
        product = super().__mul__(other)
        if not isinstance(other, Distribution):
            return product
        kinds = chained(self, other)
        if kinds is None:
            return product
        return Distribution._sound(
            product._axes, product._log_values, tuple(kinds[axis.name] for axis in product._axes)
        )

    def update(self, likelihood: Factor) -> Distribution:
        """Return the posterior after evidence: multiply by its likelihood and normalise (Bayes' rule).

        Axes that only the likelihood has (samples, trials) become batch axes.

        Parameters
        ----------
        likelihood : Factor
            The probability (density) of the evidence, given the labels.

        Raises
        ------
        ImpossibleEvidenceError
            If the evidence leaves no support in a cell; the message names it.

        Examples
        --------
        >>> goal = Axis("goal", ["cup", "bowl"])
        >>> posterior = Distribution.uniform(goal).update(Factor([goal], [-1e6, -1e6 - 1]))
        >>> posterior.log_values.round(4)
        array([-0.3133, -1.3133])
        """
        axes, left, right = self._meet(likelihood)
        kinds = self._kinds
        if axes is not self._axes:
            kinds += _BATCH * (len(axes) - len(kinds))
        return Distribution._normalised(axes, left + right, kinds)

    def marginal(self, *keep: str) -> Distribution:
        """Sum the random axes out, except those to keep.

        Examples
        --------
        >>> joint = Distribution.uniform(Axis("goal", ["cup", "bowl"]), Axis("mood", 4))
        >>> joint.marginal("goal").values
        array([0.5, 0.5])
        """
        positions = self._positions(keep, kind="random")
        if not positions:
            raise AxisError(f"marginal must keep at least one random axis of {self!r}")
        over = tuple(i for i, kind in enumerate(self._kinds) if kind == "random" and i not in positions)
        rest = [i for i in range(len(self._axes)) if i not in over]
        return Distribution._sound(
            tuple(self._axes[i] for i in rest),
            np.asarray(log_sum_exp(self._log_values, over)),
            tuple(self._kinds[i] for i in rest),
        )

    def given(self, *names: str, **labels: Label | np.generic) -> Distribution:
        """Condition: on whole random axes by name, and on labels by keyword.

        Parameters
        ----------
        *names : str
            Random axes that the result is to be a conditional in.
        **labels : label
            ``given(y="a")`` conditions on a random axis, and picks a cell of a given or batch axis.

        Raises
        ------
        ImpossibleEvidenceError
            If a condition has probability zero, which leaves the conditional undefined; the message names it.

        Examples
        --------
        >>> x, y = Axis("x", ["a", "b"]), Axis("y", ["c", "d"])
        >>> joint = Distribution.from_probabilities([x, y], [[0.1, 0.3], [0.2, 0.4]])
        >>> joint.given("y")
        Distribution p(x | y): x 2, y 2
        >>> round(joint.given(y="c").prob(x="b"), 12)
        0.666666666667
        """
        self._positions(names, kind="random")
        for name, label in labels.items():
            if not isinstance(label, (str, int, float, bool, np.generic)):
                raise AxisError(f"given({name}=...) takes one label, not {label!r}; restrict takes several")
        kinds_by_name = {axis.name: kind for axis, kind in zip(self._axes, self._kinds, strict=True)}
        axes, values = self._restricted(dict(labels))
        kinds = tuple("given" if axis.name in names else kinds_by_name[axis.name] for axis in axes)
        if "random" not in kinds:
            raise AxisError(
                f"conditioning on every random axis of {self!r} leaves nothing to be uncertain about"
            )
        try:
            return Distribution._normalised(axes, values, kinds)
        except ImpossibleEvidenceError as error:
            fixed = ", ".join(f"{name}={label!r}" for name, label in labels.items())
            what = f" on {fixed}" if fixed else ""
            raise ImpossibleEvidenceError(
                f"the condition{what} has probability zero, so the conditional is undefined: {error}"
            ) from None

    def predict(self, transition: Distribution) -> Distribution:
        """Return the distribution one step later.

        Parameters
        ----------
        transition : Distribution
            Random in ``next_goal`` and given ``goal``, for each random axis ``goal`` that changes. Other axes
            that it is given may be random here (they stay as they are) or become given in the result.

        Returns
        -------
        Distribution
            Over the same names: ``next_goal`` is called ``goal`` again.

        Examples
        --------
        >>> goal = Axis("goal", ["cup", "bowl"])
        >>> stay = Distribution.from_probabilities(
        ...     [goal, goal.rename("next_goal")], [[0.9, 0.1], [0.1, 0.9]], given=["goal"]
        ... )
        >>> now = Distribution.from_probabilities([goal], [1.0, 0.0])
        >>> now.predict(stay).predict(stay).values.round(12)
        array([0.82, 0.18])
        """
        moved = moving_axes(transition, self)
        joint = self * transition
        if not isinstance(joint, Distribution):
            raise AxisError(f"{transition!r} is no transition of {self!r}: their conditions run in a circle")
        later = joint.sum(*moved)
        kinds = {axis.name: kind for axis, kind in zip(joint._axes, joint._kinds, strict=True)}
        axes = later._renamed({f"next_{name}": name for name in moved})
        result = Distribution._sound(axes, later._log_values, tuple(kinds[axis.name] for axis in later._axes))
        # the axes in the order they had, new ones last
        order = [axis.name for axis in self._axes]
        order += [axis.name for axis in axes if axis.name not in order]
        return result.align(*order)

    # staying a distribution

    def restrict(self, **labels: Label | np.generic | Iterable[Any]) -> Factor:
        """Keep some labels, as `Factor.restrict`; of given and batch axes only, it stays a `Distribution`."""
        axes, values = self._restricted(labels)
        kinds = {axis.name: kind for axis, kind in zip(self._axes, self._kinds, strict=True)}
        if any(kinds[name] == "random" for name in labels):
            return Factor._trusted(axes, values)
        return Distribution._sound(axes, values, tuple(kinds[axis.name] for axis in axes))

    def rename(self, **names: str) -> Distribution:
        """Rename axes, old name to new; their kinds stay."""
        return Distribution._sound(self._renamed(names), self._log_values, self._kinds)

    def align(self, *axes: Axis | str) -> Distribution:
        """Lay it out over these axes, in this order; an `Axis` that it lacks is added as a batch axis."""
        onto, values = self._aligned(axes)
        kinds = {axis.name: kind for axis, kind in zip(self._axes, self._kinds, strict=True)}
        return Distribution._sound(onto, values, tuple(kinds.get(axis.name, "batch") for axis in onto))

    # what it says

    def mode(self) -> dict[str, Any]:
        """Return the most probable labels, by axis (the first, where several tie).

        Returns
        -------
        dict
            For each random axis a label; or an array of labels over the given and batch axes, in order.

        Examples
        --------
        >>> Distribution.from_probabilities([Axis("goal", ["cup", "bowl"])], [0.25, 0.75]).mode()
        {'goal': 'bowl'}
        """
        return expectations.mode(*self._matrix(), random=self._random_axes())

    def prob(self, **labels: Label | np.generic | Iterable[Any]) -> Numbers:
        """Return the probability of labels, or of any of several labels of an axis.

        Parameters
        ----------
        **labels : label, or several
            Of random axes (those not named are summed out), and of given and batch axes (to pick cells).

        Examples
        --------
        >>> p = Distribution.from_probabilities([Axis("goal", ["cup", "bowl", "mug"])], [0.25, 0.5, 0.25])
        >>> p.prob(goal=["cup", "mug"])
        0.5
        """
        axes, values = self._restricted(dict(labels))
        random = set(self.random)
        over = tuple(position for position, axis in enumerate(axes) if axis.name in random)
        return plain(np.exp(log_sum_exp(values, over)))

    def expect(self, values: Any, *names: str) -> Numbers:
        """Return the expectation of a function of random labels; values of probability 0 do not count.

        Parameters
        ----------
        values : callable, mapping or array
            A callable is called with a label of each named axis; a mapping is from label to number (of one
            axis); an array has the named axes as leading dimensions, and may go on: positions, shape (goal,
            space).
        *names : str
            Random axes; by default the only one.

        Returns
        -------
        float or array
            Over the given and batch axes, in order, then the array's further dimensions.

        Raises
        ------
        FactorError
            If a value is NaN, is missing, or +inf and -inf are both possible.

        Examples
        --------
        >>> p = Distribution.from_probabilities([Axis("goal", ["cup", "bowl"])], [0.25, 0.75])
        >>> p.expect({"cup": 1.0, "bowl": 2.0})
        1.75
        >>> p.expect([[0.0, 4.0], [4.0, 0.0]])
        array([3., 1.])
        """
        named = names or self.random
        if not names and len(named) > 1:
            raise AxisError(f"say which of the random axes {', '.join(named)} the values are over")
        p = self.marginal(*named)
        over = p._positions(named, kind="random")
        axes = [p._axes[i] for i in over]
        rest = [i for i in range(len(p._axes)) if i not in over]
        probabilities = np.exp(p._log_values.transpose([*rest, *over]))
        return plain(expectations.expect(probabilities, expectations.value_grid(values, axes), axes))

    def entropy(self) -> Numbers:
        """Return the entropy over the random axes, in nats.

        Examples
        --------
        >>> round(Distribution.uniform(Axis("goal", 4)).entropy(), 6)
        1.386294
        """
        log_p, shape = self._matrix()
        return plain(expectations.entropy(log_p).reshape(shape))

    def divergence(self, other: Distribution) -> Numbers:
        """Return KL(self || other), the Kullback-Leibler divergence, in nats; inf where other lacks support.

        Parameters
        ----------
        other : Distribution
            Over the same random axes. Its given and batch axes align by name; those that it lacks are
            repeated.

        Examples
        --------
        >>> goal = Axis("goal", ["cup", "bowl"])
        >>> p = Distribution.from_probabilities([goal], [0.0, 1.0])
        >>> round(p.divergence(Distribution.uniform(goal)), 6)
        0.693147
        """
        if set(self.random) != set(other.random):
            raise AxisError(
                f"divergence needs the same random axes on both sides, not {self!r} and {other!r}"
            )
        axes, left, right = self._meet(other)
        shape = tuple(len(axis) for axis in axes)
        random = set(self.random)
        over = tuple(position for position, axis in enumerate(axes) if axis.name in random)
        return plain(
            expectations.divergence(np.broadcast_to(left, shape), np.broadcast_to(right, shape), over)
        )

    def sample(self, rng: np.random.Generator, size: int | tuple[int, ...] | None = None) -> dict[str, Any]:
        """Draw labels.

        Parameters
        ----------
        rng : numpy.random.Generator
            The source of randomness.
        size : int or tuple of int, optional
            How many draws from each cell; None for a single one.

        Returns
        -------
        dict
            For each random axis a label, or an array of labels, shape (*size, *given and batch axes).

        Examples
        --------
        >>> p = Distribution.from_probabilities([Axis("goal", ["cup", "bowl"])], [0.0, 1.0])
        >>> p.sample(np.random.default_rng(0))
        {'goal': 'bowl'}
        """
        leading = () if size is None else (size,) if isinstance(size, int) else tuple(size)
        log_p, shape = self._matrix()
        return expectations.sample(log_p, shape, leading, rng, random=self._random_axes())

    def _random_axes(self) -> list[Axis]:
        return [axis for axis, kind in zip(self._axes, self._kinds, strict=True) if kind == "random"]

    def _matrix(self) -> tuple[Float[np.ndarray, "cell outcome"], tuple[int, ...]]:
        """Return log probabilities with one row a cell of the other axes, and the shape of those axes."""
        over = [i for i, kind in enumerate(self._kinds) if kind == "random"]
        rest = [i for i, kind in enumerate(self._kinds) if kind != "random"]
        shape = tuple(len(self._axes[i]) for i in rest)
        return self._log_values.transpose(rest + over).reshape(math.prod(shape), -1), shape

    # comparing and showing

    def __eq__(self, other: object) -> bool:
        """Whether the other is the same distribution, exactly; the order of the axes does not matter."""
        same = super().__eq__(other)
        if same is not True or not isinstance(other, Distribution):
            return same
        return dict(zip(self.names, self._kinds, strict=True)) == dict(
            zip(other.names, other._kinds, strict=True)
        )

    __hash__ = None

    def to_xarray(self) -> xr.DataArray:
        """Return the log probabilities as an `xarray.DataArray` (a copy), named ``log_probability``.

        The kinds of the axes are in its attributes ``random``, ``given`` and ``batch`` (names between
        spaces).

        Examples
        --------
        >>> Distribution.uniform(Axis("goal", ["cup", "bowl"])).to_xarray().attrs["random"]
        'goal'
        """
        attrs = {"random": self.random, "given": self.conditions, "batch": self.batch}
        return faces.to_xarray(
            self._axes,
            self._log_values,
            name="log_probability",
            attrs={kind: " ".join(names) for kind, names in attrs.items()},
        )

    def __repr__(self) -> str:
        inside = ", ".join(self.random)
        inside += f" | {', '.join(self.conditions)}" if self.conditions else ""
        inside += f"; {', '.join(self.batch)}" if self.batch else ""
        return f"Distribution p({inside}): " + ", ".join(f"{axis.name} {len(axis)}" for axis in self._axes)

    def _repr_html_(self) -> str:
        return faces.html_table(repr(self), self._axes, self._log_values, "probability")

    def __reduce__(self) -> tuple[Any, ...]:
        return (Distribution._sound, (self._axes, self._log_values, self._kinds))


def plain(values: Any) -> Numbers:
    """Return a float for a scalar, and an array as it is."""
    array = np.asarray(values)
    return float(array) if array.ndim == 0 else array


def _summing_to_one(axes: Axes, log_values: Array, kinds: Kinds, over: tuple[int, ...] | None) -> Array:
    """Return the values scaled to sum to one to the last digits, or name the cell that is not near it."""
    total = log_sum_exp(log_values, over)
    off = ~(np.abs(np.expm1(total)) <= SUM_TOLERANCE)
    if off.any():
        cell = first_cell(axes_apart(axes, kinds), off) if total.ndim else "all labels together"
        raise FactorError(
            f"probabilities sum to {float(np.exp(total[off][0])):.12g}, not 1, at {cell}; "
            "use Factor(...).normalize(...) if they are only proportional to probabilities"
        )
    if (np.abs(total) <= 1e-13).all():
        return log_values
    values, _ = log_normalise(log_values, over)
    values.setflags(write=False)
    return values


__all__ = ["Distribution"]
