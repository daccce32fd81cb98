"""Playing one trial, and cutting what was played into segments."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.studies import Segment
from ppsim.protocol import Action
from ppsim.reaching.world import Collided, Observation, ReachingWorld, Scored
from ppsim.seeds import streams


class GoalSeat(Protocol):
    """Whoever moves one agent towards goals, and says which."""

    @property
    def controller(self) -> str:
        """What the log calls it."""
        ...

    @property
    def goal(self) -> int:
        """The goal that the latest action was for; -1 for none."""
        ...

    def reset(self, rng: np.random.Generator) -> None:
        """Begin a trial; all chance comes from this generator."""
        ...

    def act(self, observation: Observation) -> Action:
        """Return the action to take now."""
        ...


@dataclass(frozen=True, eq=False)
class Played:
    """A trial as it truly went: states, actions and goals at every sample.

    Parameters
    ----------
    time : (sample,) float64
        Seconds.
    position, velocity, control : (sample, agent, 2) float64
        The state acted from, and the action taken from there.
    goals : (sample, goal, 2) float64
        Where the goals are.
    drawn : (sample,) int64
        How often the goals have been drawn anew.
    pursued : (sample, agent) int64
        The goal that each action was for; -1 where the agent waited.
    scored, collided : (sample,) bool
        Where the team scored, and where agents collided. At a sample where the team scored the goals are new.
    score : int
        Of the team, at the end.
    """

    time: Float[np.ndarray, " sample"]
    position: Float[np.ndarray, "sample agent 2"]
    velocity: Float[np.ndarray, "sample agent 2"]
    control: Float[np.ndarray, "sample agent 2"]
    goals: Float[np.ndarray, "sample goal 2"]
    drawn: Int[np.ndarray, " sample"]
    pursued: Int[np.ndarray, "sample agent"]
    scored: Bool[np.ndarray, " sample"]
    collided: Bool[np.ndarray, " sample"]
    score: int


def play(world: ReachingWorld, seats: Mapping[str, GoalSeat], *, seed: int, samples: int) -> Played:
    """Play one trial: a function of the world, the seats and the seed alone.

    Examples
    --------
    >>> from ppsim.reaching import ReachingStudy
    >>> study = ReachingStudy()
    >>> play(study.world(), study.seats(0), seed=1, samples=5).position.shape
    (5, 2, 2)
    """
    agents = world.agents
    for agent, rng in zip(agents, streams(seed, len(agents)), strict=True):
        seats[agent].reset(rng)
    seen = world.reset(seed)
    shape = (samples, len(agents), 2)
    position, velocity, control = np.empty(shape), np.empty(shape), np.empty(shape)
    goals = np.empty((samples, world.rules.goals, 2))
    drawn, pursued = np.empty(samples, dtype=np.int64), np.empty(shape[:2], dtype=np.int64)
    scored, collided = np.zeros((2, samples), dtype=bool)
    score = 0
    for t in range(samples):
        actions = {agent: seats[agent].act(seen[agent]) for agent in agents}
        for index, agent in enumerate(agents):
            position[t, index], velocity[t, index] = seen[agent].position[agent], seen[agent].velocity[agent]
            control[t, index], pursued[t, index] = actions[agent], seats[agent].goal
        goals[t], drawn[t], score = seen[agents[0]].goals, seen[agents[0]].drawn, seen[agents[0]].score
        if t + 1 == samples:
            break
        seen, events = world.step(actions)
        scored[t + 1] = any(isinstance(event, Scored) for event in events)
        collided[t + 1] = any(isinstance(event, Collided) for event in events)
    time = np.arange(samples) * (world.dynamics.dt or 0.0)
    return Played(time, position, velocity, control, goals, drawn, pursued, scored, collided, score)


def segments_of(played: Played, index: int, agent: str, radius: float) -> list[Segment]:
    """Return the stretches of one agent's motion towards one goal.

    A segment begins where the agent turns to a goal: at the start, where the goals are new, or where it changes its
    mind. It ends where the agent arrives within `radius` of that goal (waiting there for the other is no motion
    towards it), or where it gives the goal up, if only to wait. The stretch that the end of the trial cuts off is none,
    since a share of it is not known.

    Parameters
    ----------
    played : Played
        The trial.
    index, agent : int, str
        Which agent, and its label.
    radius : float
        The pick radius (m).

    Examples
    --------
    >>> x = np.linspace(0.0, 1.0, 5)
    >>> position = np.stack([x, np.zeros(5)], axis=1)[:, None]
    >>> played = Played(
    ...     time=x, position=position, velocity=position, control=position, goals=np.tile([[[1.0, 0.0]]], (5, 1, 1)),
    ...     drawn=np.zeros(5, np.int64), pursued=np.zeros((5, 1), np.int64), scored=np.zeros(5, bool),
    ...     collided=np.zeros(5, bool), score=0,
    ... )
    >>> segments_of(played, 0, "human", radius=0.3)
    [Segment(agent='human', start=0, stop=3, true_goal='0')]
    """
    pursued, drawn = played.pursued[:, index], played.drawn
    turns = np.flatnonzero((np.diff(pursued) != 0) | (np.diff(drawn) != 0)) + 1
    bounds = [0, *turns.tolist(), len(pursued)]
    found = []
    for start, end in pairwise(bounds):
        if pursued[start] < 0:
            continue
        goal = played.goals[start, pursued[start]]
        # the pick itself is seen at the first sample of the new goals
        last = end + 1 if end < len(pursued) else end
        near = np.linalg.norm(played.position[start:last, index] - goal, axis=1) <= radius
        if near.any():
            stop = start + int(np.argmax(near))
        elif end < len(pursued):
            stop = end
        else:
            continue
        if stop > start:
            found.append(Segment(agent, start, stop, str(pursued[start])))
    return found
