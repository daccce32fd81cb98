"""A small log of two agents that plan, made by hand: for examples and tests."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float

from ppinfer.coordination import LiteralPersonality, Motion, Personality, PersonalityModel, PlanSet, Situation
from ppinfer.studies import Replan, Trial, log_of_trials
from ppinfer.studies.personality_models import personality_text

_DT = 0.1
_STEPS = 8
AGENTS = ("human", "robot")
THETA = ("human", "robot")
_BELIEFS: dict[str, PersonalityModel | None] = {
    "bayes": Personality(),
    "bayes-literal": LiteralPersonality(),
    "norm": None,
}


def example_planned_log(
    *, trials: int = 3, replans: int = 4, plans: int = 3, robots: Sequence[str] = ("bayes",), seed: int = 0
) -> xr.Dataset:
    """Return a study log of two arms that replan every 0.8 s: plans, games, decisions and where they led.

    Both agents look at the same plans. The games are random; each agent takes its plan of the profile, among those
    where nobody collides, that costs both together least. In some steps both are held.

    Parameters
    ----------
    trials, replans : int
        How many trials, and replans of each agent in a trial.
    plans : int
        How many plans each agent has, besides the one that does not move.
    robots : sequence of {"bayes", "bayes-literal", "norm"}
        Whose beliefs are logged, trial by trial, over and over: those of `Personality`, of `LiteralPersonality`, none.
    seed : int
        Of everything.

    Examples
    --------
    >>> log = example_planned_log(trials=2, replans=3)
    >>> log.sizes["replan"], log.sizes["plan"], log.sizes["profile"]
    (12, 96, 192)
    """
    drawn, options = planned_study(trials=trials, replans=replans, plans=plans, robots=robots, seed=seed)
    return log_of_trials(drawn, **options)


def planned_study(
    *, trials: int = 3, replans: int = 4, plans: int = 3, robots: Sequence[str] = ("bayes",), seed: int = 0
) -> tuple[list[Trial], dict[str, Any]]:
    """Return the trials of `example_planned_log`, and what else `log_of_trials` takes.

    Examples
    --------
    >>> trials, options = planned_study(trials=1, replans=2)
    >>> len(trials[0].replans), options["theta"]
    (4, ('human', 'robot'))
    """
    children = np.random.SeedSequence(seed).spawn(trials)
    drawn = [
        _trial(index, robots[index % len(robots)], np.random.default_rng(child), replans=replans, plans=plans)
        for index, child in enumerate(children)
    ]
    return drawn, {"agents": AGENTS, "space": ("shoulder", "elbow"), "theta": THETA, "position_units": "rad"}


def _trial(index: int, robot: str, rng: np.random.Generator, *, replans: int, plans: int) -> Trial:
    where = rng.uniform(-1.0, 1.0, (2, 2))
    goal = where + rng.uniform(1.0, 2.0, (2, 2))
    motion = Motion(where[None], np.zeros((1, 2, 2)), np.zeros(1, bool), _DT)
    moved = [motion]
    model = _BELIEFS[robot]
    state = None
    made: list[Replan] = []
    for number in range(replans):
        sets = [
            _plan_set(agent, where[column], goal[column], rng, plans) for column, agent in enumerate(AGENTS)
        ]
        situation = Situation.from_contacts(
            sets,
            _contacts(rng, plans),
            motion=motion if number else None,
            time=number * _STEPS * _DT,
            seed=int(rng.integers(1 << 31)),
        )
        state = None if model is None else model.observe(situation, "robot", state)
        costs = situation.game.costs
        chosen = np.unravel_index(int(costs.sum(axis=0).argmin()), costs.shape[1:])
        decision = tuple(int(plan) for plan in chosen)
        for agent in AGENTS:
            belief = state.log_belief if state is not None and agent == "robot" else None
            made.append(
                Replan(
                    time=situation.time,
                    sample=number * _STEPS,
                    agent=agent,
                    plans=sets,
                    cost=costs,
                    contact_time=np.asarray(situation.contact_time),
                    decision=decision,
                    live_log_posterior=belief,
                    seed=situation.seed,
                )
            )
        motion = _executed(sets, decision, motion, rng.random(_STEPS) < 0.1)
        moved.append(motion)
        where = motion.position[-1]
    samples = replans * _STEPS + 1
    placed = np.concatenate([moved[0].position, *(piece.position[1:] for piece in moved[1:])])
    held = np.concatenate([piece.held[1:] for piece in moved])
    held = np.concatenate([[False], held])
    stops = int(held.sum())
    return Trial(
        trial_id=f"scene-{index}",
        participant=f"scene-{index}",
        time=np.arange(samples) * _DT,
        position=placed,
        velocity=np.concatenate([moved[0].velocity, *(piece.velocity[1:] for piece in moved[1:])]),
        seed=index,
        outcome="completed",
        controller={"human": "norm", "robot": robot},
        variables={
            "held": (("sample",), held),
            "end_effector": (("sample", "agent", "table"), _hand(placed)),
            "finish_time": (("agent",), np.array([(samples - 1) * _DT, np.nan])),
            "stops": ((), stops),
            "stop_episodes": ((), min(stops, 1)),
            "scene": ((), index),
            "plan_sets": ((), "shared"),
            "live_model": ((), "" if model is None else personality_text(model)),
        },
        replans=made,
    )


def _plan_set(
    agent: str,
    start: Float[np.ndarray, " joint"],
    goal: Float[np.ndarray, " joint"],
    rng: np.random.Generator,
    plans: int,
) -> PlanSet:
    # by one point on the way each, at a quarter of a radian a second, and at last the plan that does not move
    times, places = [], []
    for _ in range(plans):
        way = np.array([start, 0.5 * (start + goal) + rng.normal(0.0, 0.4, 2), goal])
        legs = np.abs(np.diff(way, axis=0)).max(axis=1) / 0.25
        times.append(np.concatenate([[0.0], np.cumsum(legs)]))
        places.append(way)
    row_size = np.array([*[3] * plans, 1])
    return PlanSet(
        agent,
        row_size,
        np.concatenate([*times, [0.0]]),
        np.concatenate([*places, start[None]]),
        static=plans,
    )


def _contacts(rng: np.random.Generator, plans: int) -> Float[np.ndarray, "human_plan robot_plan"]:
    contacts = np.where(rng.random((plans + 1, plans + 1)) < 0.4, rng.uniform(0.5, 5.0), np.inf)
    # nobody is run into who stands still
    contacts[-1, :] = contacts[:, -1] = np.inf
    return contacts


def _executed(
    sets: list[PlanSet], decision: tuple[int, ...], before: Motion, held: Bool[np.ndarray, " step"]
) -> Motion:
    # a held step takes its time, but nobody gets anywhere
    times = _DT * np.cumsum(~held)
    moved, speed = (
        np.stack([at[chosen] for at, chosen in zip(some, decision, strict=True)], axis=1)
        for some in ([own.positions(times) for own in sets], [own.velocities(times) for own in sets])
    )
    speed[held] = 0.0
    return Motion(
        np.concatenate([before.position[-1:], moved]),
        np.concatenate([before.velocity[-1:], speed]),
        np.concatenate([[False], held]),
        _DT,
    )


def _hand(position: Float[np.ndarray, "sample agent joint"]) -> Float[np.ndarray, "sample agent table"]:
    angle = np.cumsum(position, axis=-1)
    return 0.5 * np.stack([np.cos(angle).sum(axis=-1), np.sin(angle).sum(axis=-1)], axis=-1)
