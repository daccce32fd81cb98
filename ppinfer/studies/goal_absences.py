"""Is a segment's true goal there throughout? Counted while the samples go by, block by block."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Int, Shaped


class GoalAbsences:
    """Running counts of each goal's absences, kept only where segments begin and end.

    Memory grows with the segments and a block, never with the samples.

    Parameters
    ----------
    first, last
        Each segment's first sample and one past its last, in the whole log. Bounds outside the log are counted as
        its nearest end.
    samples, goals
        How many the log has.

    Examples
    --------
    >>> absences = GoalAbsences(np.array([0, 1]), np.array([2, 3]), samples=3, goals=2)
    >>> absences.add(np.array([[1, 1], [1, 0]]))
    >>> absences.add(np.array([[1, 1]]))
    >>> absences.present_throughout(np.array([0, 1]), goal=np.array([0, 1]))
    array([ True, False])
    """

    def __init__(
        self,
        first: Int[np.ndarray, " segment"],
        last: Int[np.ndarray, " segment"],
        *,
        samples: int,
        goals: int,
    ) -> None:
        bounds = np.clip(np.stack([first, last]), 0, samples)
        self._cuts, where = np.unique(bounds, return_inverse=True)
        self._first, self._last = where.reshape(bounds.shape)
        self._absent = np.zeros((self._cuts.size, goals), np.int64)
        self._before = np.zeros(goals, np.int64)
        self._seen = 0

    def add(self, present: Shaped[np.ndarray, "sample goal"]) -> None:
        """Count the next block of samples."""
        stop = self._seen + len(present)
        # a cut counts the absences before it, so that it belongs to the block that it ends
        begin, end = np.searchsorted(self._cuts, [self._seen, stop], side="right")
        absent = np.cumsum(present != 1, axis=0, dtype=np.int64)
        self._absent[begin:end] = self._before + absent[self._cuts[begin:end] - self._seen - 1]
        self._before = self._before + (absent[-1] if len(absent) else 0)
        self._seen = stop

    def present_throughout(
        self, segment: Int[np.ndarray, " asked"], *, goal: Int[np.ndarray, " asked"]
    ) -> Bool[np.ndarray, " asked"]:
        """Return, for each segment asked about, whether the goal is present at all of its samples."""
        absences: Int[np.ndarray, "cut goal"] = self._absent
        present: Bool[np.ndarray, " asked"] = (
            absences[self._first[segment], goal] == absences[self._last[segment], goal]
        )
        return present
