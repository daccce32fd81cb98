"""What the axes of a distribution are: random, given or batch; and what the chain rule makes of them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ppinfer.distributions.layout import Axes, Kind, Kinds, positions_of
from ppinfer.errors import AxisError

if TYPE_CHECKING:
    from ppinfer.distributions.distribution import Distribution


def kinds_of(axes: Axes, given: Iterable[str], batch: Iterable[str]) -> Kinds:
    """Return the kind of each axis: those not named are random.

    Raises
    ------
    AxisError
        If an axis is unknown, named as two kinds, or none is random.
    """
    conditions = (given,) if isinstance(given, str) else tuple(given)
    copies = (batch,) if isinstance(batch, str) else tuple(batch)
    positions_of(axes, (*conditions, *copies))
    kinds: Kinds = tuple(
        "given" if axis.name in conditions else "batch" if axis.name in copies else "random" for axis in axes
    )
    if "random" not in kinds:
        raise AxisError("a distribution needs at least one random axis, over which it sums to one")
    return kinds


def axes_apart(axes: Axes, kinds: Kinds) -> Axes:
    """Return the axes that are not random."""
    return tuple(axis for axis, kind in zip(axes, kinds, strict=True) if kind != "random")


def random_positions(kinds: Kinds) -> tuple[int, ...] | None:
    """Return the dimensions that are random; None for all of them, which NumPy reduces over much faster."""
    over = tuple(position for position, kind in enumerate(kinds) if kind == "random")
    return None if len(over) == len(kinds) else over


def chained(left: Distribution, right: Distribution) -> dict[str, Kind] | None:
    """Return the kind of each axis of a product that the chain rule makes a distribution, else None."""
    mine, theirs = set(left.random), set(right.random)
    if mine & theirs:
        return None
    if mine & set(right.names) and theirs & set(left.names):
        return None  # each is conditioned on what the other draws
    # what one draws and the other is conditioned on is drawn jointly; a condition of either is one of both
    kinds: dict[str, Kind] = dict.fromkeys((*left.batch, *right.batch), "batch")
    kinds |= dict.fromkeys((*left.conditions, *right.conditions), "given")
    kinds |= dict.fromkeys((*left.random, *right.random), "random")
    return kinds


def moving_axes(transition: Distribution, state: Distribution) -> list[str]:
    """Return the axes ``a`` of a state for which a transition is random in ``next_a`` and given ``a``.

    Raises
    ------
    AxisError
        If the transition is of another shape; the message says which names are expected.
    """
    moved = []
    for name in transition.random:
        before = name.removeprefix("next_")
        if before == name or before not in transition.conditions or before not in state.random:
            raise AxisError(
                f"{transition!r} is no transition of {state!r}: it must be random in 'next_<axis>' and given "
                f"'<axis>', for random axes of the state ({', '.join(state.random)}), not {name!r}"
            )
        if transition.axis(name).rename(before) != transition.axis(before):
            raise AxisError(
                f"axes {name!r} and {before!r} of a transition must carry the same labels: {transition!r}"
            )
        moved.append(before)
    return moved
