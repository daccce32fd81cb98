"""How far motion is from a plan, the sequence of states of one against that of the other."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float


class Distance(ABC):
    """A distance between sequences of states; subclasses are small frozen dataclasses.

    Examples
    --------
    One of one's own: how far apart they end.

    >>> from dataclasses import dataclass
    >>> from ppinfer.coordination import Distance
    >>> @dataclass(frozen=True)
    ... class EndDistance(Distance):
    ...     def between(self, plans, motion):
    ...         return np.linalg.norm(plans[:, -1] - motion[-1], axis=-1)
    >>> EndDistance().between(np.zeros((1, 2, 1)), np.array([[0.0], [3.0]]))
    array([3.])
    """

    name: ClassVar[str] = "custom"

    @abstractmethod
    def between(
        self, plans: Float[np.ndarray, "plan time state"], motion: Float[np.ndarray, "time state"]
    ) -> Float[np.ndarray, " plan"]:
        """Return how far the motion is from each of several sequences at the same times."""


@dataclass(frozen=True)
class Euclidean(Distance):
    """The paper's: the root of the sum of squared differences over all times. It grows with the length.

    Examples
    --------
    >>> from ppinfer.coordination import Euclidean
    >>> Euclidean().between(np.zeros((1, 2, 1)), np.array([[3.0], [4.0]]))
    array([5.])
    """

    name: ClassVar[str] = "euclidean"

    def between(
        self, plans: Float[np.ndarray, "plan time state"], motion: Float[np.ndarray, "time state"]
    ) -> Float[np.ndarray, " plan"]:
        """Return the norm of the difference."""
        distance: np.ndarray = np.sqrt(np.square(plans - motion).sum(axis=(1, 2)))
        return distance


@dataclass(frozen=True)
class RootMeanSquare(Distance):
    """The Euclidean distance of a typical sample: it does not grow with the length.

    Examples
    --------
    >>> from ppinfer.coordination import RootMeanSquare
    >>> RootMeanSquare().between(np.zeros((1, 2, 1)), np.array([[3.0], [4.0]])).round(4)
    array([3.5355])
    """

    name: ClassVar[str] = "rms"

    def between(
        self, plans: Float[np.ndarray, "plan time state"], motion: Float[np.ndarray, "time state"]
    ) -> Float[np.ndarray, " plan"]:
        """Return the root of the mean over times of the squared distance."""
        distance: np.ndarray = np.sqrt(np.square(plans - motion).sum(axis=2).mean(axis=1))
        return distance


@dataclass(frozen=True)
class TimeWarping(Distance):
    """Dynamic time warping, by `dtaidistance`: who is merely slower is no further away.

    Parameters
    ----------
    window : int, optional
        Samples by which times may be shifted; None: any.

    Examples
    --------
    >>> from ppinfer.coordination import TimeWarping
    >>> late = np.array([[0.0], [0.0], [1.0], [2.0]])
    >>> float(TimeWarping().between(np.array([[[0.0], [1.0], [2.0], [2.0]]]), late)[0])
    0.0
    """

    name: ClassVar[str] = "dtw"
    window: int | None = None

    def between(
        self, plans: Float[np.ndarray, "plan time state"], motion: Float[np.ndarray, "time state"]
    ) -> Float[np.ndarray, " plan"]:
        """Return the least Euclidean distance over all ways to warp time."""
        from dtaidistance import dtw_ndim

        seen = np.ascontiguousarray(motion)
        # the library takes one pair at a time; its inner loop is compiled
        return np.array(
            [dtw_ndim.distance_fast(np.ascontiguousarray(plan), seen, window=self.window) for plan in plans]
        )
