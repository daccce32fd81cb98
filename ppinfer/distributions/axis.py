"""A named, labelled, finite axis: what a hypothesis, a plan, a trial or a sample is one of."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

import numpy as np
from jaxtyping import Int

from ppinfer.errors import AxisError

Label: TypeAlias = str | int | float | bool
"""What an axis may be labelled with."""


class Axis:
    """A named axis with unique labels of one type; frozen and hashable.

    Two axes are equal when their names and their labels are, order included. Labels that count up evenly (an
    int `n`, a `range`, or the same ints written out) are held as a `range` and compared in constant time, so
    that a million of them are never walked.

    Parameters
    ----------
    name : str
        A Python identifier, because labels are picked by keyword: ``factor.restrict(goal="cup")``.
    labels : sequence of str, int, float or bool; or int
        At least one label, all different and of one type. An int `n` stands for ``range(n)``.

    Raises
    ------
    AxisError
        If the name is no identifier, or the labels are empty, repeated, mixed or not finite.

    Examples
    --------
    >>> goal = Axis("goal", ["cup", "bowl"])
    >>> len(goal), goal.index("bowl")
    (2, 1)
    >>> sample = Axis("sample", 1_000_000)
    >>> sample.is_range, sample == Axis("sample", range(1_000_000))
    (True, True)
    """

    __slots__ = ("_kind", "_labels", "_name", "_positions")

    def __init__(self, name: str, labels: Sequence[Any] | np.ndarray | int) -> None:
        if not isinstance(name, str) or not name.isidentifier():
            raise AxisError(
                f"axis name {name!r} is not a Python identifier; labels are picked by keyword, "
                "as in restrict(goal='cup'), so choose a name such as 'goal' or 'post_goal'"
            )
        self._name = name
        self._labels, self._kind = _checked_labels(name, labels)
        self._positions: dict[Label, int] | None = None

    @property
    def name(self) -> str:
        """The axis's name."""
        return self._name

    @property
    def labels(self) -> tuple[Label, ...] | range:
        """The labels in order: a tuple, or a `range` for labels that count up evenly."""
        return self._labels

    @property
    def is_range(self) -> bool:
        """Whether the labels count up (or down) evenly and are held as a `range`."""
        return isinstance(self._labels, range)

    def __len__(self) -> int:
        return len(self._labels)

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if not isinstance(other, Axis):
            return NotImplemented
        # True == 1 == 1.0 in Python, so the type of the labels has to agree as well
        return self._name == other._name and self._kind is other._kind and self._labels == other._labels

    def __hash__(self) -> int:
        return hash((self._name, self._kind, self._labels))

    def __repr__(self) -> str:
        return f"Axis({self._name!r}, {abbreviated(self)})"

    def __reduce__(self) -> tuple[Any, ...]:
        return (Axis, (self._name, self._labels))

    def index(self, label: Label | np.generic) -> int:
        """Return the position of a label.

        Parameters
        ----------
        label : str, int, float or bool
            One of the labels, of their type (an int is accepted on an axis of floats).

        Raises
        ------
        AxisError
            If the axis has no such label.

        Examples
        --------
        >>> Axis("goal", ["cup", "bowl"]).index("bowl")
        1
        """
        wanted: Any = label.item() if isinstance(label, np.generic) else label
        kind = type(wanted)
        if kind is self._kind or (kind is int and self._kind is float):
            if isinstance(self._labels, range):
                if wanted in self._labels:
                    return self._labels.index(wanted)
            else:
                if self._positions is None:
                    self._positions = {known: position for position, known in enumerate(self._labels)}
                position = self._positions.get(wanted)
                if position is not None:
                    return position
        raise AxisError(f"axis {self._name!r} has no label {wanted!r}; its labels are {abbreviated(self)}")

    def rename(self, name: str) -> Axis:
        """Return the same labels under another name.

        Examples
        --------
        >>> Axis("goal", ["cup", "bowl"]).rename("post_goal")
        Axis('post_goal', ['cup', 'bowl'])
        """
        renamed = Axis(name, 1)
        renamed._labels, renamed._kind, renamed._positions = self._labels, self._kind, self._positions
        return renamed

    def restrict(self, labels: Iterable[Label | np.generic]) -> tuple[Axis, Int[np.ndarray, "chosen"]]:
        """Return the axis of the chosen labels, in the order chosen, and their positions here.

        Parameters
        ----------
        labels : iterable of labels
            Each of them once.

        Raises
        ------
        AxisError
            If a label is unknown, chosen twice, or none is chosen.

        Examples
        --------
        >>> Axis("goal", ["cup", "bowl", "mug"]).restrict(["mug", "cup"])
        (Axis('goal', ['mug', 'cup']), array([2, 0]))
        """
        chosen = labels if isinstance(labels, range) else list(labels)
        if isinstance(chosen, range) and isinstance(self._labels, range) and len(chosen):
            # the ends of an arithmetic progression (and its second term) place all of it
            first, last = self.index(chosen[0]), self.index(chosen[-1])
            if len(chosen) > 1:
                self.index(chosen[1])
            positions = np.linspace(first, last, len(chosen)).round().astype(np.intp)
        else:
            positions = np.array([self.index(label) for label in chosen], dtype=np.intp)
        axis = Axis(self._name, chosen)
        if axis._kind is not self._kind:  # ints chosen from an axis of floats
            axis = Axis(self._name, [float(label) for label in chosen])
        return axis, positions

    def label_array(self) -> np.ndarray:
        """Return the labels as a NumPy array; str as objects, so that they are stored at variable length.

        Examples
        --------
        >>> Axis("sample", 3).label_array()
        array([0, 1, 2])
        """
        if isinstance(self._labels, range):
            return np.arange(self._labels.start, self._labels.stop, self._labels.step)
        return np.array(self._labels, dtype=object if self._kind is str else None)


def _checked_labels(name: str, labels: Any) -> tuple[tuple[Label, ...] | range, type]:
    """Return the labels in their canonical form, and their type."""
    if isinstance(labels, (bool, str, bytes)) or not isinstance(labels, (int, np.integer, Iterable)):
        raise AxisError(
            f"axis {name!r}: labels must be a sequence of str, int, float or bool, or a length, "
            f"not {labels!r}"
        )
    if isinstance(labels, (int, np.integer)):
        if labels < 1:
            raise AxisError(
                f"axis {name!r}: a length of {labels} leaves it without labels; at least 1 is needed"
            )
        return range(int(labels)), int
    if isinstance(labels, range):
        if not len(labels):
            raise AxisError(f"axis {name!r}: {labels} is empty; at least one label is needed")
        return labels, int
    if isinstance(labels, np.ndarray) and labels.ndim != 1:
        raise AxisError(f"axis {name!r}: labels must be one-dimensional, not of shape {labels.shape}")
    listed = [label.item() if isinstance(label, np.generic) else label for label in labels]
    if not listed:
        raise AxisError(f"axis {name!r} has no labels; at least one is needed")
    kind = type(listed[0])
    for position, label in enumerate(listed):
        if type(label) not in (str, int, float, bool):
            raise AxisError(
                f"axis {name!r}: label {label!r} at position {position} is a {type(label).__name__}; "
                "labels are str, int, float or bool"
            )
        if type(label) is not kind:
            raise AxisError(
                f"axis {name!r}: labels of one axis have one type, but {listed[0]!r} is a {kind.__name__} "
                f"and {label!r} at position {position} is a {type(label).__name__}"
            )
        if kind is float and label != label:
            raise AxisError(f"axis {name!r}: label at position {position} is NaN, which equals nothing")
    seen: dict[Label, int] = {}
    for position, label in enumerate(listed):
        first = seen.setdefault(label, position)
        if first != position:
            raise AxisError(
                f"axis {name!r}: label {label!r} is repeated, at positions {first} and {position}"
            )
    if kind is int:
        step = listed[1] - listed[0] if len(listed) > 1 else 1
        progression = range(listed[0], listed[0] + step * len(listed), step)
        if all(label == expected for label, expected in zip(listed, progression, strict=True)):
            return progression, int
    return tuple(listed), kind


def abbreviated(axis: Axis, most: int = 6) -> str:
    """Return the labels as short text for a message: all of a few, the ends of many."""
    labels = axis.labels
    if isinstance(labels, range) and len(labels) > 3:
        return f"{len(labels)}" if labels == range(len(labels)) else f"{labels}"
    if len(labels) <= most:
        return "[" + ", ".join(repr(label) for label in labels) + "]"
    head = ", ".join(repr(label) for label in labels[: most - 2])
    return f"[{head}, ... {len(labels) - most + 1} more ..., {labels[-1]!r}]"


def check_same(left: Axis, right: Axis) -> None:
    """Refuse two axes of one name whose labels differ, saying how (axes never silently intersect).

    Raises
    ------
    AxisError
        If the labels, or their order, differ.
    """
    if left == right:
        return
    name = left.name
    sides = (
        f"left has {len(left)} labels {abbreviated(left)}, right has {len(right)} labels {abbreviated(right)}"
    )
    advice = f"Axes align by name and must carry equal labels: rename one, or restrict({name}=[...]) first."
    if left.is_range and right.is_range:
        raise AxisError(f"axis {name!r} differs between the two sides: {sides}. {advice}")
    if left._kind is not right._kind:
        kinds = f"labels on the left are {left._kind.__name__}, on the right {right._kind.__name__}"
        raise AxisError(f"axis {name!r} differs between the two sides: {kinds}; {sides}. {advice}")
    known_left, known_right = set(left.labels), set(right.labels)
    if known_left == known_right:
        where = next(i for i, (a, b) in enumerate(zip(left.labels, right.labels, strict=True)) if a != b)
        raise AxisError(
            f"axis {name!r} has the same labels on both sides but in another order: at position {where} left "
            f"has {left.labels[where]!r}, right has {right.labels[where]!r}. "
            f"Bring one into the other's order with restrict({name}=[...])."
        )
    only_left = [label for label in left.labels if label not in known_right]
    only_right = [label for label in right.labels if label not in known_left]
    raise AxisError(
        f"axis {name!r} differs between the two sides: only on the left {_some(only_left)}, "
        f"only on the right {_some(only_right)}; {sides}. {advice}"
    )


def _some(labels: list[Label], most: int = 5) -> str:
    if not labels:
        return "nothing"
    text = ", ".join(repr(label) for label in labels[:most])
    return text if len(labels) <= most else f"{text} and {len(labels) - most} more"


def cell_name(axes: Sequence[Axis], index: Sequence[int]) -> str:
    """Return the labels of one cell of a grid as text, for messages.

    Examples
    --------
    >>> cell_name([Axis("goal", ["cup", "bowl"]), Axis("trial", 4)], (1, 2))
    "goal='bowl', trial=2"
    """
    if not axes:
        return "the only cell"
    return ", ".join(f"{axis.name}={axis.labels[int(i)]!r}" for axis, i in zip(axes, index, strict=True))


def first_cell(axes: Sequence[Axis], mask: np.ndarray) -> str:
    """Return the name of the first cell where the mask is true, and how many others there are."""
    count = int(np.count_nonzero(mask))
    index = np.unravel_index(int(np.argmax(mask)), mask.shape) if mask.ndim else ()
    others = "" if count == 1 else f" (and {count - 1} other cell{'s' if count > 2 else ''})"
    return cell_name(axes, [int(i) for i in index]) + others
