"""What a human does about the robot's goal, if it yields and if it does not."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.goals.conditional import SoftmaxConditional, conditional_log_weights


@runtime_checkable
class GoalReaction(Protocol):
    """The human's next goal where it thinks again, for each personality theta."""

    def log_reaction(
        self,
        goals: Float[np.ndarray, "*batch goal space"],
        human_position: Float[np.ndarray, "*batch space"],
        robot_position: Float[np.ndarray, "*batch space"],
        present: Bool[np.ndarray, "*batch goal"] | None = None,
    ) -> Float[np.ndarray, "*batch 2 goal goal goal"]:
        """Return log p(post goal | theta, prior goal, robot's goal), with axes in that order, post goal last.

        theta is 0 where the human favours the robot (it yields), 1 where it favours itself. Positions in m.
        """
        ...


@dataclass(frozen=True)
class SoftmaxReaction:
    """Who yields reacts as `SoftmaxConditional` has it (Algorithm 1); who does not keeps its goal.

    Parameters
    ----------
    conditional : SoftmaxConditional
        p(post_goal | goal, robot_goal) of a human who yields.

    Examples
    --------
    The human is near goal 0 and wants it, and so does the robot:

    >>> reaction = SoftmaxReaction().log_reaction(np.array([[1.0, 0.0], [0.0, 2.0]]), np.zeros(2), np.ones(2))
    >>> np.exp(reaction[:, 0, 0]).round(2)
    array([[0.23, 0.77],
           [1.  , 0.  ]])
    """

    conditional: SoftmaxConditional = field(default_factory=SoftmaxConditional)

    def log_reaction(
        self,
        goals: Float[np.ndarray, "*batch goal space"],
        human_position: Float[np.ndarray, "*batch space"],
        robot_position: Float[np.ndarray, "*batch space"],
        present: Bool[np.ndarray, "*batch goal"] | None = None,
    ) -> Float[np.ndarray, "*batch 2 goal goal goal"]:
        """Return log p(post goal | theta, prior goal, robot's goal); where the robot is does not matter here."""
        weights = self.conditional
        yielding = conditional_log_weights(
            goals,
            human_position,
            human_weight=weights.human_weight,
            robot_weight=weights.robot_weight,
            stay_weight=weights.stay_weight,
            rationality=weights.rationality,
            present=present,
        )
        count = goals.shape[-2]
        # a goal that is gone cannot be kept: the yielding human's row stands in, and no belief ever rests on it
        keeping = np.broadcast_to(
            np.where(np.eye(count, dtype=bool), 0.0, -np.inf)[:, None, :], yielding.shape
        )
        if present is not None and not present.all():
            keeping = np.where(present[..., :, None, None], keeping, yielding)
        return np.stack([yielding, keeping], axis=-4)
