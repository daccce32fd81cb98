"""What learned prediction learns from: motion so far, the robot's plan, and how often the human reached each goal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.errors import ModelError


@dataclass(frozen=True, eq=False)
class PredictionExamples:
    """Some examples: at each, both agents were at an instant, and the robot was about to follow a plan.

    Parameters
    ----------
    human, robot : (example, past, n) float32
        States of the last steps, oldest first, the present one included and last: [px, vx, py, vy] (m, m/s). Where
        there was less motion so far, the oldest state is repeated.
    plan : (example, horizon, n) float32
        The robot's states in the steps to come.
    goals : (example, goal, space) float32
        Where the goals are (m); 0 where there is none.
    present : (example, goal) bool
        Which goals there are, one at least.
    frequency : (example, goal) float32
        How often the human then reached each goal first; sums to one over the goals present.
    robot_goal : (example,) int
        The goal that the plan leads to.

    Raises
    ------
    ModelError
        Where shapes disagree, a value is not finite, or frequencies are not those of goals that are present.

    Examples
    --------
    >>> examples = PredictionExamples(
    ...     human=np.zeros((1, 4, 4), np.float32), robot=np.ones((1, 4, 4), np.float32),
    ...     plan=np.ones((1, 8, 4), np.float32), goals=np.array([[[3.0, 0.0], [0.0, 3.0]]], np.float32),
    ...     present=np.ones((1, 2), bool), frequency=np.array([[0.25, 0.75]], np.float32), robot_goal=np.array([0]),
    ... )
    >>> len(examples), examples.read(0, 1).goals.shape
    (1, (1, 2, 2))
    """

    human: Float[np.ndarray, "example past n"]
    robot: Float[np.ndarray, "example past n"]
    plan: Float[np.ndarray, "example horizon n"]
    goals: Float[np.ndarray, "example goal space"]
    present: Bool[np.ndarray, "example goal"]
    frequency: Float[np.ndarray, "example goal"]
    robot_goal: Int[np.ndarray, " example"]

    def __post_init__(self) -> None:
        for name in ("human", "robot", "plan", "goals", "frequency"):
            if not np.isfinite(getattr(self, name)).all():
                raise ModelError(f"examples: {name} holds values that are not finite")
        if not self.present.any(axis=1).all():
            example = int(np.argmin(self.present.any(axis=1)))
            raise ModelError(f"examples: example {example} has no goal")
        if not ((self.robot_goal >= 0) & (self.robot_goal < self.goals.shape[1])).all():
            raise ModelError("examples: robot_goal names goals that are not there")
        off = np.abs(self.frequency.sum(axis=1) - 1.0) > 1e-4
        wrong = off | (self.frequency < 0).any(axis=1) | (self.frequency > 0)[~self.present].any()
        if wrong.any():
            example = int(np.argmax(wrong))
            raise ModelError(
                f"examples: the frequencies of example {example} must be those of goals that are present, and sum to "
                f"one; got {self.frequency[example].tolist()}"
            )

    def __len__(self) -> int:
        return len(self.goals)

    def read(self, start: int, stop: int) -> PredictionExamples:
        """Return the examples from `start` to `stop`."""
        return self.take(slice(start, stop))

    def take(self, which: slice | Int[np.ndarray, " taken"]) -> PredictionExamples:
        """Return some of the examples."""
        # what was checked whole is not checked in parts
        part = object.__new__(PredictionExamples)
        for field in fields(self):
            object.__setattr__(part, field.name, getattr(self, field.name)[which])
        return part

    def relabelled(self, order: Sequence[int]) -> PredictionExamples:
        """Return the same examples with their goals in another order."""
        taken = list(order)
        return replace(
            self,
            goals=self.goals[:, taken],
            present=self.present[:, taken],
            frequency=self.frequency[:, taken],
            robot_goal=np.argsort(taken)[self.robot_goal],
        )

    @classmethod
    def concatenate(cls, parts: Sequence[PredictionExamples]) -> PredictionExamples:
        """Return the examples of several parts, one after another.

        Raises
        ------
        ModelError
            Where there are no parts.
        """
        if not parts:
            raise ModelError("examples: nothing to put together")
        joined = object.__new__(cls)
        for field in fields(cls):
            object.__setattr__(
                joined, field.name, np.concatenate([getattr(each, field.name) for each in parts])
            )
        return joined


@runtime_checkable
class ExampleSource(Protocol):
    """Examples of any number, read in parts: `PredictionExamples` itself, or a store on disk."""

    def __len__(self) -> int:
        """Return how many there are."""
        ...

    def read(self, start: int, stop: int) -> PredictionExamples:
        """Return the examples from `start` to `stop`."""
        ...


@dataclass(frozen=True, eq=False)
class ExampleRange:
    """The examples of another source from `start` to `stop`.

    Examples
    --------
    >>> from ppinfer.testing.prediction_examples import example_predictions
    >>> len(ExampleRange(example_predictions(10), 2, 6))
    4
    """

    source: ExampleSource
    start: int
    stop: int

    def __post_init__(self) -> None:
        if not 0 <= self.start <= self.stop <= len(self.source):
            raise ModelError(f"examples {self.start} to {self.stop} are not within {len(self.source)}")

    def __len__(self) -> int:
        return self.stop - self.start

    def read(self, start: int, stop: int) -> PredictionExamples:
        """Return the examples from `start` to `stop` of this range."""
        return self.source.read(self.start + start, min(self.start + stop, self.stop))
