"""Hypothesis strategies for axes, factors and distributions, awkward ones first.

Log weights reach from -1e6 to differences of 1e-12, zeros included, because that is where algebra breaks.
Install the extra ``ppinfer[test]`` for Hypothesis.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ppinfer.distributions import Axis, Distribution, Factor
from ppinfer.distributions.axis import Label

try:
    from hypothesis import strategies as st
    from hypothesis.extra.numpy import arrays
except ImportError as error:  # pragma: no cover
    raise ImportError(
        "ppinfer.testing.strategies needs Hypothesis: install the extra with `pip install 'ppinfer[test]'`"
    ) from error

NAMES = ("goal", "plan", "mood", "trial", "sample", "agent")
"""Names that generated axes take."""


def log_weights(*, zeros: bool = True) -> st.SearchStrategy[float]:
    """Return log weights: round ones, tiny differences, huge ones, and (if asked) -inf.

    Parameters
    ----------
    zeros : bool
        Whether -inf is among them.

    Examples
    --------
    >>> from ppinfer.testing.strategies import log_weights
    >>> log_weights(zeros=False)  # doctest: +ELLIPSIS
    one_of(...)
    """
    kinds = [
        st.sampled_from([0.0, -1.0, -1e-12, -1e6, -1e6 - 1.0, 1e-12]),
        st.floats(-30.0, 5.0, allow_subnormal=False),
        st.floats(-1e6, 0.0, allow_subnormal=False),
    ]
    if zeros:
        kinds.append(st.just(-math.inf))
    return st.one_of(kinds)


@st.composite
def axes(draw: st.DrawFn, name: str | None = None, *, min_size: int = 1, max_size: int = 4) -> Axis:
    """Draw an axis labelled with strings, ints, floats or bools, or a range axis.

    Parameters
    ----------
    name : str, optional
        Its name; by default one of `NAMES`.
    min_size, max_size : int
        How many labels.

    Examples
    --------
    >>> from hypothesis import given
    >>> from ppinfer.testing.strategies import axes
    >>> @given(axes("goal", max_size=3))
    ... def holds(axis):
    ...     assert axis.name == "goal" and len(axis) <= 3
    >>> holds()
    """
    chosen = draw(st.sampled_from(NAMES)) if name is None else name
    size = draw(st.integers(min_size, max_size))
    some: list[st.SearchStrategy[Any]] = [
        st.just(size),
        st.lists(st.text(max_size=5), min_size=size, max_size=size, unique=True),
        st.lists(st.integers(-5, 99), min_size=size, max_size=size, unique=True),
        st.lists(st.floats(allow_nan=False), min_size=size, max_size=size, unique=True),
    ]
    if size <= 2:
        some.append(st.permutations([True, False]).map(lambda labels: labels[:size]))
    return Axis(chosen, draw(st.one_of(some)))


@st.composite
def axis_sets(
    draw: st.DrawFn, *, min_axes: int = 1, max_axes: int = 4, max_size: int = 3
) -> tuple[Axis, ...]:
    """Draw axes of different names.

    Parameters
    ----------
    min_axes, max_axes : int
        How many.
    max_size : int
        The most labels of one.

    Examples
    --------
    >>> from hypothesis import given
    >>> from ppinfer.testing.strategies import axis_sets
    >>> @given(axis_sets(max_axes=2))
    ... def holds(some):
    ...     assert 1 <= len({axis.name for axis in some}) <= 2
    >>> holds()
    """
    names = draw(st.permutations(NAMES))[: draw(st.integers(min_axes, max_axes))]
    return tuple(draw(axes(name, max_size=max_size)) for name in names)


@st.composite
def factors(draw: st.DrawFn, over: Sequence[Axis] | None = None, *, zeros: bool = True) -> Factor:
    """Draw a factor with awkward log weights.

    Parameters
    ----------
    over : sequence of Axis, optional
        Its axes; by default from `axis_sets`.
    zeros : bool
        Whether cells may be zero. A factor may then be zero throughout.

    Examples
    --------
    >>> from hypothesis import given
    >>> from ppinfer.testing.strategies import factors
    >>> @given(factors([Axis("goal", 3)]))
    ... def holds(factor):
    ...     assert (factor * factor).allclose(factor**2, rtol=1e-12)
    >>> holds()
    """
    grid = tuple(draw(axis_sets()) if over is None else over)
    return Factor(grid, draw(_grids(grid, zeros=zeros)))


@st.composite
def distributions(
    draw: st.DrawFn,
    over: Sequence[Axis] | None = None,
    *,
    given: Iterable[str] | None = None,
    batch: Iterable[str] | None = None,
    zeros: bool = True,
) -> Distribution:
    """Draw a distribution, with conditional and batch axes among its axes.

    Parameters
    ----------
    over : sequence of Axis, optional
        Its axes; by default from `axis_sets`. The first is random.
    given, batch : iterable of str, optional
        The kinds of the axes; where neither is stated they are drawn.
    zeros : bool
        Whether labels may have probability zero.

    Examples
    --------
    >>> from hypothesis import given
    >>> from ppinfer.testing import check_normalisation
    >>> from ppinfer.testing.strategies import distributions
    >>> @given(distributions())
    ... def holds(distribution):
    ...     check_normalisation(distribution)
    >>> holds()
    """
    grid = tuple(draw(axis_sets()) if over is None else over)
    if given is None and batch is None:
        kinds = [draw(st.sampled_from(["random", "given", "batch"])) for _ in grid[1:]]
        given = [axis.name for axis, kind in zip(grid[1:], kinds, strict=True) if kind == "given"]
        batch = [axis.name for axis, kind in zip(grid[1:], kinds, strict=True) if kind == "batch"]
    apart = {*(given or ()), *(batch or ())}
    random = [axis.name for axis in grid if axis.name not in apart]
    log_values = draw(_grids(grid, zeros=zeros))
    # every cell of the other axes keeps some support
    over_random = tuple(i for i, axis in enumerate(grid) if axis.name in random)
    dead = log_values.max(axis=over_random, keepdims=True) == -math.inf
    return Factor(grid, np.where(dead, 0.0, log_values)).normalize(*random, batch=batch or ())


@st.composite
def relabellings(draw: st.DrawFn, axis: Axis) -> list[Label]:
    """Draw the labels of an axis in some order.

    Examples
    --------
    >>> from hypothesis import given
    >>> from ppinfer.testing.strategies import relabellings
    >>> @given(relabellings(Axis("goal", ["cup", "bowl"])))
    ... def holds(labels):
    ...     assert sorted(labels) == ["bowl", "cup"]
    >>> holds()
    """
    return draw(st.permutations(list(axis.labels)))


@st.composite
def transitions(draw: st.DrawFn, axis: Axis, *, zeros: bool = True) -> Distribution:
    """Draw a transition of an axis: random in ``next_<axis>``, given the axis.

    Parameters
    ----------
    axis : Axis
        What moves.
    zeros : bool
        Whether moves may be impossible.

    Examples
    --------
    >>> from hypothesis import given
    >>> from ppinfer.testing.strategies import transitions
    >>> @given(transitions(Axis("goal", 2)))
    ... def holds(transition):
    ...     assert transition.random == ("next_goal",)
    >>> holds()
    """
    arrow = (axis, axis.rename(f"next_{axis.name}"))
    return draw(distributions(arrow, given=[axis.name], batch=[], zeros=zeros))


def _grids(grid: Sequence[Axis], *, zeros: bool) -> st.SearchStrategy[np.ndarray]:
    return arrays(np.float64, tuple(len(axis) for axis in grid), elements=log_weights(zeros=zeros))
