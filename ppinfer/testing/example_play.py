"""Made-up parallel play whose every detail is at hand: situations of many trials, without a world or files."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from ppinfer.coordination import Motion, PlanSet, Situation

DT = 0.1


def example_plans(
    agent: str,
    start: Float[np.ndarray, " joint"],
    rng: np.random.Generator,
    *,
    plans: int = 8,
    durations: Sequence[float] = (),
) -> PlanSet:
    """Return some plans that wander off from a start, and a last one that stays there.

    Parameters
    ----------
    agent : str
        Whose they are.
    start : (joint,) float64
        Where it is, rad.
    rng : numpy.random.Generator
        The source of randomness.
    plans : int
        How many, the static one included.
    durations : sequence of float, optional
        Seconds, to draw every plan's duration from: so that plans tie. By default, they rarely do.

    Examples
    --------
    >>> example_plans("robot", np.zeros(2), np.random.default_rng(0), plans=3).duration.round(1)
    array([6.1, 4.7, 0. ])
    """
    row_size, time, position = [], [], []
    for _ in range(plans - 1):
        legs = int(rng.integers(1, 4))
        ends = np.cumsum(rng.integers(4, 40, legs)) * DT
        if durations:
            ends *= float(rng.choice(durations)) / ends[-1]
        time.append(np.concatenate([[0.0], ends]))
        steps = rng.normal(scale=0.3, size=(legs, len(start)))
        position.append(start + np.concatenate([np.zeros((1, len(start))), np.cumsum(steps, axis=0)]))
        row_size.append(legs + 1)
    return PlanSet(
        agent,
        np.array([*row_size, 1], np.int64),
        np.concatenate([*time, np.zeros(1)]),
        np.concatenate([*position, start[None]]),
        static=plans - 1,
    )


def example_situation(
    rng: np.random.Generator,
    *,
    agents: Sequence[str] = ("robot", "human"),
    plans: Sequence[int] = (8, 8),
    starts: Float[np.ndarray, "agent joint"] | None = None,
    colliding: float = 0.3,
    durations: Sequence[float] = (),
    motion: Motion | None = None,
    time: float = 0.0,
) -> Situation:
    """Return a situation of wandering plans of which a share of the profiles collides, but not that of all static ones.

    Parameters
    ----------
    rng : numpy.random.Generator
        The source of randomness.
    agents, plans : sequence
        Who takes part, and how many plans each has.
    starts : (agent, joint) float64, optional
        Where everybody is, rad.
    colliding : float
        Share of the profiles; at 1 all of them collide.
    durations : sequence of float, optional
        As `example_plans` takes them.
    motion, time
        As a `Situation` has them.

    Examples
    --------
    >>> example_situation(np.random.default_rng(0)).game
    Game of robot, human: robot_plan 8, human_plan 8
    """
    if starts is None:
        starts = rng.normal(size=(len(agents), 2))
    sets = [
        example_plans(agent, start, rng, plans=count, durations=durations)
        for agent, start, count in zip(agents, starts, plans, strict=True)
    ]
    collision = np.where(rng.random(tuple(plans)) < colliding, rng.uniform(0.1, 5.0, tuple(plans)), np.inf)
    if colliding < 1.0:
        collision[(-1,) * len(sets)] = np.inf
    return Situation.from_contacts(
        sets,
        collision,
        contact_time=collision * 0.9,
        motion=motion,
        time=time,
        seed=int(rng.integers(1 << 31)),
    )


def example_trial(
    rng: np.random.Generator,
    *,
    replans: int = 5,
    agents: Sequence[str] = ("robot", "human"),
    plans: Sequence[int] = (8, 8),
    colliding: float = 0.3,
    held: float = 0.1,
    leaves: bool = False,
    durations: Sequence[float] = (),
) -> list[Situation]:
    """Return the situations of one trial: everybody follows some plan, roughly, and looks again after at most 2 s.

    Parameters
    ----------
    rng : numpy.random.Generator
        The source of randomness.
    replans : int
        How many situations.
    agents, plans, colliding, durations
        As `example_situation` takes them.
    held : float
        Probability that a safety stop holds a step; the agents look again at once.
    leaves : bool
        Whether the last agent has left at the last replan: it has one plan then, and no position.

    Examples
    --------
    >>> trial = example_trial(np.random.default_rng(0), replans=3)
    >>> [round(situation.time, 1) for situation in trial]
    [0.0, 0.1, 0.9]
    """
    where = rng.normal(size=(len(agents), 2))
    situation = example_situation(
        rng, agents=agents, plans=plans, starts=where, colliding=colliding, durations=durations
    )
    trial, time = [situation], 0.0
    speed = np.zeros_like(where)
    for turn in range(1, replans):
        steps = int(rng.choice([8, 8, 8, 3, 17]))
        stopped = rng.random(steps) < held
        if stopped.any():
            steps = int(stopped.argmax()) + 1
        flags = np.zeros(steps + 1, np.bool_)
        flags[steps] = stopped[steps - 1]
        clock = np.cumsum(~flags)[:] - 1
        position, velocity = np.empty((steps + 1, len(agents), 2)), np.empty((steps + 1, len(agents), 2))
        for agent, own in enumerate(situation.plans):
            followed = int(rng.integers(len(own)))
            position[:, agent] = own.positions(clock * DT)[followed]
            velocity[:, agent] = own.velocities(clock * DT)[followed]
        velocity[0], speed = speed, velocity[-1].copy()
        position[1:] += rng.normal(scale=0.05, size=position[1:].shape)
        time += steps * DT
        sizes = list(plans)
        if leaves and turn == replans - 1:
            position[-1, -1] = np.nan
            sizes[-1] = 1
        where = np.where(np.isnan(position[-1]), 0.0, position[-1])
        situation = example_situation(
            rng,
            agents=agents,
            plans=sizes,
            starts=where,
            colliding=colliding,
            durations=durations,
            motion=Motion(position, velocity, flags, DT),
            time=time,
        )
        trial.append(situation)
    return trial
