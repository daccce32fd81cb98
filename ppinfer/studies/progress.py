"""How long-running functions tell how far they are."""

from __future__ import annotations

from typing import Protocol, runtime_checkable


@runtime_checkable
class ProgressCallback(Protocol):
    """What long-running functions call with how much is done and how much there is."""

    def __call__(self, done: int, total: int, /) -> None:
        """Take note that `done` of `total` is done."""


def silent(done: int, total: int, /) -> None:
    """Say nothing.

    Examples
    --------
    >>> silent(1, 2)
    """
