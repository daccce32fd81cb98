"""What worlds and seats say to one another; policies, simulated humans and people all speak this."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Generic, Protocol, TypeVar, runtime_checkable

import numpy as np
from jaxtyping import Float

Seen = TypeVar("Seen", covariant=True)
Happened = TypeVar("Happened", covariant=True)
Given = TypeVar("Given", contravariant=True)

Action = Float[np.ndarray, " control"]


@runtime_checkable
class World(Protocol, Generic[Seen, Happened]):
    """A world of named agents that moves one step at a time.

    It keeps no clock of its own end: whoever plays in it decides when a trial is over.
    """

    @property
    def agents(self) -> tuple[str, ...]:
        """Names of the agents, in the order of the log."""
        ...

    def reset(self, seed: int) -> Mapping[str, Seen]:
        """Begin anew, as a function of the seed alone; return what each agent sees."""
        ...

    def step(self, actions: Mapping[str, Action]) -> tuple[Mapping[str, Seen], tuple[Happened, ...]]:
        """Let every agent act for one time step; return what each sees then, and what happened."""
        ...


@runtime_checkable
class Seat(Protocol, Generic[Given]):
    """Whoever moves one agent."""

    @property
    def controller(self) -> str:
        """What the log calls it."""
        ...

    def reset(self, rng: np.random.Generator) -> None:
        """Begin a trial; all chance comes from this generator."""
        ...

    def act(self, observation: Given) -> Action:
        """Return the action to take now."""
        ...
