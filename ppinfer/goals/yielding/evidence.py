"""What is seen of a human and a robot among goals: the motion of both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from ppinfer.errors import ModelError
from ppinfer.goals.evidence import GoalEvidence


@dataclass(frozen=True, eq=False)
class EncounterEvidence:
    """The motion of both agents among the same goals, row by row; a row has one set of goals.

    Parameters
    ----------
    human, robot : GoalEvidence
        Of each agent, sample by sample at the same times, with the same rows and goals.
    encounter : (row,) int64
        Which human it is: consecutive rows with the same number are of one human, whose personality stays the same
        while goals come and go.

    Raises
    ------
    ModelError
        Where times, rows or goals of the two differ, or a row continues another's goals.

    Examples
    --------
    >>> human = GoalEvidence(
    ...     time=np.arange(2.0), position=np.zeros((2, 2)), goals=np.ones((1, 1, 2)), row_size=np.array([2]),
    ...     goal_labels=("cup",),
    ... )
    >>> EncounterEvidence(human, human, np.array([0])).first
    array([ True])
    """

    human: GoalEvidence
    robot: GoalEvidence
    encounter: Int[np.ndarray, " row"]

    def __post_init__(self) -> None:
        one, other = self.human, self.robot
        object.__setattr__(self, "encounter", np.asarray(self.encounter, np.int64))
        if self.encounter.shape != (one.rows,):
            raise ModelError(
                f"encounter must number the {one.rows} rows; it has shape {self.encounter.shape}"
            )
        same = (
            one.goal_labels == other.goal_labels
            and np.array_equal(one.row_size, other.row_size)
            and np.array_equal(one.time, other.time)
            and np.array_equal(one.goal_present, other.goal_present)
            and np.array_equal(one.goals, other.goals, equal_nan=True)
        )
        if not same:
            raise ModelError("the two agents' evidence must have the same times, rows and goals")
        for evidence in (one, other):
            if evidence.continues is not None and evidence.continues.any():
                row = int(np.argmax(evidence.continues))
                raise ModelError(
                    f"{evidence.row_name(row)} carries beliefs over goals from the row before it; here the goals "
                    "of a row begin from their prior, and only the personality is carried"
                )

    @property
    def first(self) -> np.ndarray:
        """Which rows are the first of a human, (row,) bool."""
        return np.concatenate([[True], np.diff(self.encounter) != 0])
