"""Rows of different lengths, laid end to end: the samples of many trials without padding."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from jaxtyping import Int, Shaped

from ppinfer.errors import FactorError


class Ragged:
    """Rows of values, end to end, with scans that restart at each row.

    This is the CF *contiguous ragged array*: one flat array and the number of samples of each row. A row of
    length zero is allowed. Frozen: the arrays are read-only.

    Parameters
    ----------
    values : array, shape (sample, ...)
        All samples, row after row.
    row_size : array of int, shape (row,)
        How many samples each row has; they must add up to the length of `values`.

    Raises
    ------
    FactorError
        If the row sizes are negative, not integers, or do not add up.

    Examples
    --------
    >>> steps = Ragged([1.0, 2.0, 3.0, 10.0, 20.0], [3, 2])
    >>> steps.cumsum().values
    array([ 1.,  3.,  6., 10., 30.])
    >>> [row.tolist() for row in steps]
    [[1.0, 2.0, 3.0], [10.0, 20.0]]
    """

    __slots__ = ("_row_size", "_row_start", "_values")

    def __init__(self, values: Any, row_size: Any) -> None:
        array, sizes = np.array(values), checked_row_size(row_size)
        if array.ndim == 0:
            raise FactorError("ragged values must have a leading sample dimension, got a scalar")
        if int(sizes.sum()) != len(array):
            raise FactorError(
                f"row sizes add up to {int(sizes.sum())} samples over {len(sizes)} rows, "
                f"but the values hold {len(array)} samples"
            )
        array.setflags(write=False)
        self._set(array, sizes)

    def _set(self, values: np.ndarray, row_size: np.ndarray) -> None:
        self._values, self._row_size = values, row_size
        starts = row_starts(row_size)
        starts.setflags(write=False)
        self._row_start = starts

    def _like(self, values: np.ndarray) -> Ragged:
        """Wrap fresh values that share these rows."""
        values.setflags(write=False)
        new = object.__new__(Ragged)
        new._values, new._row_size, new._row_start = values, self._row_size, self._row_start
        return new

    @classmethod
    def concat(cls, rows: Sequence[Any]) -> Ragged:
        """Lay arrays end to end, one row each.

        Parameters
        ----------
        rows : sequence of array, shape (sample, ...) each
            At least one.

        Examples
        --------
        >>> Ragged.concat([[1, 2], [3]]).row_size
        array([2, 1])
        """
        arrays = [np.asarray(row) for row in rows]
        if not arrays:
            raise FactorError("no rows to lay end to end; at least one is needed to know their type")
        shapes = {array.shape[1:] for array in arrays}
        if len(shapes) > 1 or any(array.ndim == 0 for array in arrays):
            raise FactorError(f"rows must agree in all dimensions but the first, got shapes {sorted(shapes)}")
        return cls(np.concatenate(arrays), [len(array) for array in arrays])

    @property
    def values(self) -> Shaped[np.ndarray, "sample ..."]:
        """All samples, row after row (read-only)."""
        return self._values

    @property
    def row_size(self) -> Int[np.ndarray, "row"]:
        """The number of samples of each row."""
        return self._row_size

    @property
    def row_start(self) -> Int[np.ndarray, "row"]:
        """The position of each row's first sample."""
        return self._row_start

    @property
    def row_of_sample(self) -> Int[np.ndarray, "sample"]:
        """The row that each sample belongs to."""
        return np.repeat(np.arange(len(self._row_size)), self._row_size)

    @property
    def sample_in_row(self) -> Int[np.ndarray, "sample"]:
        """The position of each sample within its row."""
        return np.asarray(np.arange(len(self._values)) - np.repeat(self._row_start, self._row_size))

    def __len__(self) -> int:
        return len(self._row_size)

    def __getitem__(self, row: int) -> Shaped[np.ndarray, "sample ..."]:
        start = self._row_start[row]
        return self._values[start : start + self._row_size[row]]

    def __iter__(self) -> Iterator[np.ndarray]:
        return (self[row] for row in range(len(self)))

    def __repr__(self) -> str:
        return f"Ragged({len(self)} rows, {len(self._values)} samples of shape {self._values.shape[1:]})"

    def __reduce__(self) -> tuple[Any, ...]:
        return (Ragged, (self._values, self._row_size))

    def split(self) -> list[np.ndarray]:
        """Return the rows as a list of (read-only) views."""
        return list(self)

    def cumsum(self) -> Ragged:
        """Return running sums that start anew at each row.

        Each row gets exactly what `numpy.cumsum` of that row alone gives. (A global running sum minus its
        value at the row's start would lose digits to all the rows before.)

        Examples
        --------
        >>> Ragged([1e16, 1.0, 1.0], [1, 2]).cumsum().values.tolist()
        [1e+16, 1.0, 2.0]
        """
        from ppinfer.distributions.scans import restarting_cumsum

        kind = np.float64 if self._values.dtype.kind == "f" else np.int64
        if self._values.dtype.kind not in "fiub":
            raise FactorError(f"values of type {self._values.dtype} have no running sum; numbers are needed")
        flat = np.ascontiguousarray(self._values, dtype=kind).reshape(
            len(self._values), math.prod(self._values.shape[1:])
        )
        return self._like(restarting_cumsum(flat, self._row_size).reshape(self._values.shape))

    def diff(self, *, first: float = float("nan")) -> Ragged:
        """Return each sample minus the one before it in its row.

        Parameters
        ----------
        first : float
            What the first sample of a row gets, which has nothing before it.

        Examples
        --------
        >>> Ragged([1.0, 4.0, 2.0, 3.0], [2, 2]).diff().values
        array([nan,  3., nan,  1.])
        """
        values = np.asarray(self._values, dtype=np.float64)
        result = np.empty_like(values)
        np.subtract(values[1:], values[:-1], out=result[1:])
        result[self._row_start[self._row_size > 0]] = first
        return self._like(result)

    def first(self) -> Shaped[np.ndarray, "row ..."]:
        """Return the first sample of each row.

        Raises
        ------
        FactorError
            If a row is empty.
        """
        self._refuse_empty("first")
        return np.asarray(self._values[self._row_start])

    def last(self) -> Shaped[np.ndarray, "row ..."]:
        """Return the last sample of each row.

        Raises
        ------
        FactorError
            If a row is empty.

        Examples
        --------
        >>> Ragged([1, 2, 3], [2, 1]).last()
        array([2, 3])
        """
        self._refuse_empty("last")
        return np.asarray(self._values[self._row_start + self._row_size - 1])

    def _refuse_empty(self, which: str) -> None:
        if not self._row_size.all():
            row = int(np.argmin(self._row_size))
            raise FactorError(f"row {row} is empty and has no {which} sample")


def row_starts(row_size: Int[np.ndarray, "row"]) -> Int[np.ndarray, "row"]:
    """Return the position of each row's first sample, for rows laid end to end.

    Examples
    --------
    >>> row_starts(np.array([3, 0, 2]))
    array([0, 3, 3])
    """
    return np.asarray(np.cumsum(row_size) - row_size)


def expand(start: Int[np.ndarray, "piece"], size: Int[np.ndarray, "piece"]) -> Int[np.ndarray, "index"]:
    """Return the indices ``start, start + 1, ...``, `size` of them, of one piece after another.

    Examples
    --------
    >>> expand(np.array([10, 4]), np.array([3, 2]))
    array([10, 11, 12,  4,  5])
    """
    return np.repeat(start - row_starts(size), size) + np.arange(int(size.sum()))


def checked_row_size(row_size: Any) -> Int[np.ndarray, "row"]:
    """Return row sizes as a read-only int64 array, or say which of them is no size."""
    sizes = np.asarray(row_size)
    if sizes.ndim != 1 or (sizes.size and sizes.dtype.kind not in "iu"):
        raise FactorError(
            f"row sizes must be a one-dimensional array of integers, got shape {sizes.shape} of {sizes.dtype}"
        )
    if (sizes < 0).any():
        row = int(np.argmax(sizes < 0))
        raise FactorError(f"row {row} has a negative size, {sizes[row]}")
    sizes = sizes.astype(np.int64)
    sizes.setflags(write=False)
    return sizes
