"""Trials sorted into cells: which participant each is of, which group it is in, and which round it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, Shaped

from ppinfer.errors import LogError
from ppinfer.studies.metrics.grouping import UNKNOWN_ROUND, column_of
from ppinfer.studies.metrics.over_participants import cell_means

ALL = "all trials"
MAX_GROUPS = 1000


@dataclass(frozen=True, eq=False)
class Cells:
    """The participant and the group of every trial; both in the order of their names, whatever the order of trials.

    Parameters
    ----------
    people : tuple of str
        All participants.
    person : (trial,) int64
        The place of each trial's participant among them.
    labels : tuple of str
        All groups.
    group : (trial,) int64
        The place of each trial's group among them.

    Examples
    --------
    >>> cells = Cells.of({"participant": np.array(["bob", "ann"]), "condition": np.array(["b", "a"])}, "condition")
    >>> cells.people, cells.person.tolist(), cells.labels
    (('ann', 'bob'), [1, 0], ('a', 'b'))
    """

    people: tuple[str, ...]
    person: Int[np.ndarray, " trial"]
    labels: tuple[str, ...]
    group: Int[np.ndarray, " trial"]

    @classmethod
    def of(cls, columns: Mapping[str, Shaped[np.ndarray, " trial"]], column: str | None) -> Cells:
        """Sort trials by participant and by a column; without one, all are one group.

        Raises
        ------
        LogError
            If there is no such column, or it has too many values.
        """
        people, person = np.unique(columns["participant"].astype(str), return_inverse=True)
        labels, group = np.array([ALL]), np.zeros(person.size, np.int64)
        if column is not None:
            labels, group = np.unique(column_of(columns, column), return_inverse=True)
        refuse_many(labels.size, f"{column!r} has")
        return cls(
            tuple(people.tolist()),
            person.reshape(-1),
            tuple(str(label) for label in labels),
            group.reshape(-1),
        )

    @property
    def size(self) -> int:
        """How many cells there are: participants times groups."""
        return len(self.people) * len(self.labels)

    @property
    def cell(self) -> Int[np.ndarray, " trial"]:
        """The cell of each trial."""
        return np.asarray(self.person * len(self.labels) + self.group)

    def means(
        self, values: Float[np.ndarray, " trial"]
    ) -> tuple[Float[np.ndarray, "participant group"], Int[np.ndarray, "participant group"]]:
        """Return the mean of each participant in each group over the trials with a value, and how many these are."""
        means, count = cell_means(values, self.cell, self.size)
        shape = len(self.people), len(self.labels)
        return means.reshape(shape), count.reshape(shape)

    def order(self) -> Int[np.ndarray, " trial"]:
        """Return the place of each trial among those of its cell, from 0.

        Examples
        --------
        >>> Cells.of({"participant": np.array(["a", "b", "a"])}, None).order().tolist()
        [0, 0, 1]
        """
        sorted_by_cell = np.argsort(self.cell, kind="stable")
        count = np.bincount(self.cell)
        place = np.empty(self.cell.size, np.int64)
        place[sorted_by_cell] = np.arange(self.cell.size) - np.repeat(np.cumsum(count) - count, count)
        return place

    def rounds_are(self, rounds: Int[np.ndarray, " trial"] | None) -> str:
        """Return ``"round"`` where some participant has several rounds in a group, else ``"order"``."""
        if rounds is None:
            return "order"
        known = rounds != UNKNOWN_ROUND
        cells = np.unique(np.stack([self.cell, rounds])[:, known], axis=1)
        # one round for each condition: what is learned within it shows in the order of trials
        return "round" if cells.shape[1] > np.unique(cells[0]).size else "order"


def refuse_many(count: int, told: str) -> None:
    """Raise `LogError` where there are more groups than can be compared."""
    if count > MAX_GROUPS:
        raise LogError(
            f"{told} {count:,} values, and at most {MAX_GROUPS:,} groups are compared; take a column with fewer"
        )
