"""Choosing the goal to go for: what the robot knows then, its choice, and who makes it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Distribution
from ppinfer.errors import ModelError


@dataclass(frozen=True, eq=False)
class GoalSituation:
    """All that a robot knows when it chooses a goal.

    Parameters
    ----------
    goals : (goal, space) float64
        Where the goals are (m).
    human, robot : (n,) float64
        States of the two agents: positions, and velocities where the dynamics have them.
    human_position, robot_position : (space,) float64
        The positions among them (m).
    belief : Distribution
        b_R(theta_prior): over ``goal``, the human's goal before it reacts.
    mental_model : Distribution
        b_H(theta_R): over ``robot_goal``, the robot's model of what the human takes to be the robot's goal.
    rationality_belief : Distribution or None
        Over ``goal`` and ``rationality`` jointly, where the human's rationality is inferred.
    previous : int or None
        The robot's goal until now; None where the goals are new.
    present : (goal,) bool or None
        Goals that exist; None for all. An absent one has probability zero in both beliefs, and may lie anywhere.
    human_history, robot_history : (step, n) float64 or None
        States of the last steps, the present one included and last; for predictions that look back.

    Raises
    ------
    ModelError
        Where shapes or the beliefs' axes do not fit the goals, or no goal exists.
    """

    goals: Float[np.ndarray, "goal space"]
    human: Float[np.ndarray, " n"]
    robot: Float[np.ndarray, " n"]
    human_position: Float[np.ndarray, " space"]
    robot_position: Float[np.ndarray, " space"]
    belief: Distribution
    mental_model: Distribution
    rationality_belief: Distribution | None = None
    previous: int | None = None
    present: Bool[np.ndarray, " goal"] | None = None
    human_history: Float[np.ndarray, "_ n"] | None = None
    robot_history: Float[np.ndarray, "_ n"] | None = None

    def __post_init__(self) -> None:
        if self.present is not None and (self.present.shape != (len(self.goals),) or not self.present.any()):
            raise ModelError(
                f"present must tell of each of {len(self.goals)} goals, and one at least must be; got {self.present}"
            )
        if self.previous is not None and not 0 <= self.previous < len(self.goals):
            raise ModelError(
                f"previous must be None or the number of one of {len(self.goals)} goals; got {self.previous}"
            )
        for name, belief, axis in (
            ("belief", self.belief, "goal"),
            ("mental_model", self.mental_model, "robot_goal"),
        ):
            if belief.random != (axis,) or belief.log_values.shape != (len(self.goals),):
                raise ModelError(
                    f"{name} must be a distribution over {axis!r} alone, with {len(self.goals)} labels; it is over "
                    f"{[each.name for each in belief.axes]}"
                )

    @property
    def labels(self) -> tuple[object, ...]:
        """Names of the goals."""
        return tuple(self.belief.axes[0].labels)


@dataclass(frozen=True, eq=False)
class GoalDecision:
    """A goal, or none for now, with the scores and distributions that it was chosen by.

    Parameters
    ----------
    goal : int or None
        Index of the robot's goal; None to wait: stay where it is, for now.
    score : (goal,) float64
        What was minimised, for every goal of the robot; inf where a goal was ruled out.
    post : Distribution
        b_post(post_goal | robot_goal): where the human will go, given each goal of the robot. A robot that expects no
        reaction has the same one for each.
    """

    goal: int | None
    score: Float[np.ndarray, " goal"]
    post: Distribution

    @classmethod
    def minimising(cls, score: Float[np.ndarray, " goal"], post: Distribution) -> GoalDecision:
        """Return the decision for the least score, the first of equal ones; where every score is inf, to wait.

        Examples
        --------
        >>> from ppinfer import Axis
        >>> post = Distribution.uniform(Axis("robot_goal", 2), Axis("post_goal", 2), given=["robot_goal"])
        >>> GoalDecision.minimising(np.array([np.inf, 3.0]), post).goal
        1
        """
        best = int(score.argmin())
        return cls(None if score[best] == np.inf else best, score, post)


class GoalChooser(ABC):
    """Chooses the robot's goal; subclasses are small frozen dataclasses of parameters with one method.

    `needs_rationality` says whether situations must carry a belief over the human's rationality.
    `ppinfer.testing.check_goal_chooser` holds a subclass to the laws.
    """

    name: ClassVar[str] = "custom"
    needs_rationality: ClassVar[bool] = False

    @abstractmethod
    def choose(self, situation: GoalSituation) -> GoalDecision:
        """Return the goal for now, with the distributions behind it."""

    def with_generator(self, rng: np.random.Generator) -> GoalChooser:
        """Return the chooser that draws one decision after another from a generator; itself, where nothing is drawn."""
        return self
