"""The world of the reaching game: point agents among goals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float, Int

from ppinfer.goals import Dynamics
from ppsim.errors import SimulationError
from ppsim.protocol import Action
from ppsim.reaching.rules import Rules

AGENTS = ("human", "robot")
Redraw = Literal["all", "picked"]
REDRAWS: tuple[str, ...] = get_args(Redraw)
# a spawn key that keeps the draws of a trial apart from what else its seed makes
_DRAWS = 100


@dataclass(frozen=True, eq=False)
class Observation:
    """What one agent sees: everything but what the others want.

    Parameters
    ----------
    agent : str
        Who sees it.
    time : float
        Seconds since the start.
    position, velocity : mapping from agent to (2,) float64
        Of all agents (m, m/s). Velocities are zero for agents that control their velocity: they have none between
        actions.
    state : (n,) float64
        The agent's own state, in the order of the world's dynamics.
    goals : (goal, 2) float64
        Where the goals are.
    drawn : int
        How often the goals have been drawn anew; a choice of goal holds for one draw.
    score : int
        The team's.
    """

    agent: str
    time: float
    position: Mapping[str, Float[np.ndarray, " 2"]]
    velocity: Mapping[str, Float[np.ndarray, " 2"]]
    state: Float[np.ndarray, " n"]
    goals: Float[np.ndarray, "goal 2"]
    drawn: int
    score: int


@dataclass(frozen=True)
class Scored:
    """The agents were at distinct goals: the team scores, and the goals are drawn anew."""

    time: float
    goal: Mapping[str, int]
    points: int


@dataclass(frozen=True)
class Collided:
    """Two agents came nearer than the collision distance; told once until they are apart again."""

    time: float
    agents: tuple[str, str]


Event = Scored | Collided


class ReachingWorld:
    """Point agents among goals; it follows `ppsim.protocol.World`.

    1. Every agent's state moves by x' = A x + B u with its action u: an acceleration (m/s^2), or a velocity (m/s)
       for single integrators, held over the time step.
    2. Two agents nearer than the collision distance collide, which is told once per approach; they pass through.
    3. When each agent is within the pick radius of a goal and these goals are distinct, the team scores, and goals are
       drawn anew, away from the agents: all of them, or those that were picked. Until then an agent at its goal waits
       for the others.

    Parameters
    ----------
    rules : Rules
        The game.
    dynamics : Dynamics
        Of every agent; two space dimensions, with the time step known.
    agents : tuple of str
        Their names.
    redraw : {"all", "picked"}
        Which goals are drawn anew when the team scores. Where it is those that were picked, the others stay, as in the
        study with people, and every draw has a generator of its own: the k-th draws of two trials of one seed are
        alike as far as the agents and the goals that stay allow.

    Raises
    ------
    SimulationError
        Where there are fewer goals than agents, dynamics without a time step or of other than two dimensions, or
        goals that are drawn anew in another way.

    Examples
    --------
    >>> world = ReachingWorld(Rules(goals=3), Dynamics.double_integrator(0.1))
    >>> seen = world.reset(5)
    >>> seen, events = world.step({"human": np.array([1.0, 0.0]), "robot": np.zeros(2)})
    >>> seen["human"].velocity["human"], events
    (array([0.1, 0. ]), ())
    """

    def __init__(
        self, rules: Rules, dynamics: Dynamics, agents: tuple[str, ...] = AGENTS, *, redraw: Redraw = "all"
    ) -> None:
        if rules.goals < len(agents):
            raise SimulationError(
                f"{rules.goals} goals are too few for {len(agents)} agents, who pick distinct ones"
            )
        if dynamics.dt is None or len(dynamics.position_index) != 2:
            raise SimulationError(
                "the reaching world needs dynamics in two dimensions with their time step dt"
            )
        if redraw not in REDRAWS:
            raise SimulationError(f"redraw must be one of {', '.join(REDRAWS)}; got {redraw!r}")
        self.rules = rules
        self.dynamics = dynamics
        self.redraw = redraw
        self._agents = agents
        self._dt = dynamics.dt
        self._rng: np.random.Generator | None = None

    @property
    def agents(self) -> tuple[str, ...]:
        """Names of the agents, in the order of the log."""
        return self._agents

    def reset(self, seed: int) -> dict[str, Observation]:
        """Begin anew: agents at rest at random starts, goals drawn."""
        self._seed = seed
        self._rng = np.random.default_rng(np.random.SeedSequence(seed))
        starts = self.rules.draw_starts(self._rng, len(self._agents))
        self._state = self.dynamics.goal_states(starts)
        self._goals = self.rules.draw_goals(self._rng, starts)
        self._steps = self._drawn = self._score = 0
        self._near = {pair for pair in combinations(range(len(self._agents)), 2) if self._collide(*pair)}
        return self._observations()

    def step(self, actions: Mapping[str, Action]) -> tuple[dict[str, Observation], tuple[Event, ...]]:
        """Move every agent for one time step.

        Raises
        ------
        SimulationError
            Where the world was not reset, or an agent's action is missing, unknown, of the wrong shape or not finite.
        """
        if self._rng is None:
            raise SimulationError("reset the world before stepping it")
        control = self._controls(actions)
        self._state = self.dynamics.step(self._state, control)
        self._steps += 1
        events = [*self._collisions(), *self._picks(self._rng)]
        return self._observations(), tuple(events)

    def _controls(self, actions: Mapping[str, Action]) -> Float[np.ndarray, "agent m"]:
        if set(actions) != set(self._agents):
            raise SimulationError(
                f"expected an action for each of {', '.join(self._agents)}; got {', '.join(actions) or 'none'}"
            )
        control = np.empty((len(self._agents), self.dynamics.controls))
        for row, agent in zip(control, self._agents, strict=True):
            action = np.asarray(actions[agent], dtype=np.float64)
            if action.shape != row.shape or not np.isfinite(action).all():
                raise SimulationError(
                    f"the action of {agent!r} must be {len(row)} finite numbers; got {actions[agent]!r}"
                )
            row[:] = action
        return control

    @property
    def _position(self) -> Float[np.ndarray, "agent 2"]:
        position: np.ndarray = self._state[:, list(self.dynamics.position_index)]
        return position

    def _collide(self, one: int, other: int) -> bool:
        apart = np.linalg.norm(self._position[one] - self._position[other])
        return bool(apart < self.rules.collision_distance)

    def _collisions(self) -> list[Event]:
        near = {pair for pair in combinations(range(len(self._agents)), 2) if self._collide(*pair)}
        new, self._near = near - self._near, near
        return [
            Collided(self._steps * self._dt, (self._agents[one], self._agents[other]))
            for one, other in sorted(new)
        ]

    def _picks(self, rng: np.random.Generator) -> list[Event]:
        at = goals_reached(self._position, self._goals, self.rules.pick_radius)
        if (at < 0).any() or len(np.unique(at)) < len(at):
            return []
        self._score += self.rules.points
        self._drawn += 1
        if self.redraw == "all":
            self._goals = self.rules.draw_goals(rng, self._position)
        else:
            draw = np.random.default_rng(np.random.SeedSequence(self._seed, spawn_key=(_DRAWS, self._drawn)))
            self._goals = self.rules.draw_picked(draw, self._goals, at, self._position)
        goal = dict(zip(self._agents, at.tolist(), strict=True))
        return [Scored(self._steps * self._dt, goal, self.rules.points)]

    def _observations(self) -> dict[str, Observation]:
        position, velocity = self._position.copy(), np.zeros_like(self._position)
        if self.dynamics.velocity_index:
            velocity = self._state[:, list(self.dynamics.velocity_index)]
        goals = self._goals.copy()
        for shared in (position, velocity, goals):
            shared.setflags(write=False)
        return {
            agent: Observation(
                agent=agent,
                time=self._steps * self._dt,
                position=dict(zip(self._agents, position, strict=True)),
                velocity=dict(zip(self._agents, velocity, strict=True)),
                state=self._state[index].copy(),
                goals=goals,
                drawn=self._drawn,
                score=self._score,
            )
            for index, agent in enumerate(self._agents)
        }


def goals_reached(
    position: Float[np.ndarray, "agent 2"], goals: Float[np.ndarray, "goal 2"], radius: float
) -> Int[np.ndarray, " agent"]:
    """Return the goal that each agent is at, -1 where it is at none.

    Examples
    --------
    >>> goals_reached(np.array([[0.0, 0.4], [3.0, 3.0]]), np.array([[5.0, 5.0], [0.0, 0.0]]), 0.5)
    array([ 1, -1])
    """
    distance = np.linalg.norm(position[:, None] - goals, axis=-1)
    return np.where(distance.min(axis=1) <= radius, distance.argmin(axis=1), -1)
