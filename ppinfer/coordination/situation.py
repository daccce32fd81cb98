"""What an agent sees when it decides: everybody's candidate plans, the game they make, and the motion since."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.coordination.plans import PlanSet
from ppinfer.errors import ModelError
from ppinfer.games import Game


@dataclass(frozen=True, eq=False)
class Motion:
    """How everybody has moved since the last replan.

    Parameters
    ----------
    position, velocity : (sample, agent, joint) float64
        Joint angles, rad, and their rates, rad/s; the first sample is that of the last replan, the last one is now.
        NaN where an agent has left.
    held : (sample,) bool
        Whether a safety stop held everybody in the step that led to the sample; false for the first.
    dt : float
        Seconds between samples.
    """

    position: Float[np.ndarray, "sample agent joint"]
    velocity: Float[np.ndarray, "sample agent joint"]
    held: Bool[np.ndarray, " sample"]
    dt: float = 0.1


@dataclass(frozen=True, eq=False)
class Situation:
    """One replan as one agent sees it.

    Parameters
    ----------
    plans : sequence of PlanSet
        Of every agent, in the order of the game's players.
    game : Game
        Costs in seconds of every profile of these plans; inf where agents collide.
    contact_time : (plan, ...) float64, optional
        Seconds until two agents first come closer than the clearance, for every profile; inf where they never do.
        Policies that weigh risk need it.
    motion : Motion, optional
        Since the last replan of the trial; None at the first.
    time : float
        Seconds since the trial began.
    seed : int
        From which a policy draws any chance that it needs.

    Examples
    --------
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [2, 1], [0.0, 4.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> situation = Situation.from_contacts([robot, human], [[1.5, np.inf], [np.inf, np.inf]])
    >>> situation.game.costs[0]
    array([[inf,  2.],
           [ 3.,  3.]])
    """

    plans: tuple[PlanSet, ...]
    game: Game
    contact_time: Float[np.ndarray, "..."] | None = None
    motion: Motion | None = None
    time: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "plans", tuple(self.plans))
        if tuple(plans.axis for plans in self.plans) != self.game.plans:
            raise ModelError(
                f"the game's plan axes are {self.game.plans}; the plans given are "
                f"{tuple(plans.axis for plans in self.plans)}"
            )

    @classmethod
    def from_contacts(
        cls,
        plans: Sequence[PlanSet],
        collision_time: Any,
        *,
        contact_time: Any = None,
        motion: Motion | None = None,
        time: float = 0.0,
        seed: int = 0,
    ) -> Situation:
        """Make the situation whose costs are the plans' own, and inf where agents collide.

        Parameters
        ----------
        plans : sequence of PlanSet
            Of every agent.
        collision_time : (plan, ...) float64
            Seconds until the profile's agents collide; inf where they never do.
        contact_time : (plan, ...) float64, optional
            The same with a clearance; by default `collision_time`.
        """
        shape = tuple(len(one) for one in plans)
        collision = np.broadcast_to(np.asarray(collision_time, np.float64), shape)
        contact = (
            collision
            if contact_time is None
            else np.broadcast_to(np.asarray(contact_time, np.float64), shape)
        )
        costs = np.empty((len(shape), *shape))
        for player, own in enumerate(plans):
            along = [1] * len(shape)
            along[player] = len(own)
            costs[player] = own.cost.reshape(along)
        costs[:, np.isfinite(collision)] = np.inf
        game = Game(costs, [one.agent for one in plans], [one.axis for one in plans])
        return cls(tuple(plans), game, contact, motion, time, seed)

    @property
    def agents(self) -> tuple[str, ...]:
        """Names of the agents, in the order of the game's players."""
        return tuple(one.agent for one in self.plans)

    def player(self, agent: str) -> int:
        """Return which of the players an agent is; a ModelError says who there is."""
        try:
            return self.agents.index(agent)
        except ValueError:
            raise ModelError(f"there is no agent {agent!r}; there are {', '.join(self.agents)}") from None

    def restrict(self, chosen: Mapping[str, Any]) -> Situation:
        """Return the same situation with only some of each named agent's plans, in the order given.

        What waiting costs is counted anew among the plans that are left; contacts stay what they are.
        """
        for agent in chosen:
            self.player(agent)
        index = [
            np.asarray(chosen[agent], np.int64) if agent in chosen else np.arange(len(own))
            for agent, own in zip(self.agents, self.plans, strict=True)
        ]
        plans = tuple(own.restrict(some) for own, some in zip(self.plans, index, strict=True))
        grid = np.ix_(*index)
        collides = np.isinf(self.game.costs[(0, *grid)])
        for player in range(1, len(plans)):
            collides = collides | np.isinf(self.game.costs[(player, *grid)])
        contact = None if self.contact_time is None else self.contact_time[grid]
        left = Situation.from_contacts(
            plans, np.where(collides, 0.0, np.inf), motion=self.motion, time=self.time, seed=self.seed
        )
        return Situation(plans, left.game, contact, self.motion, self.time, self.seed)
