"""Hypothesis strategies for whole study logs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppinfer.coordination.plans import PlanSet
from ppinfer.studies import Replan, Segment, Trial, log_of_trials

_FINITE = st.floats(-1e6, 1e6, allow_nan=False)
_WORDS = st.text(st.characters(exclude_categories=("Cs", "Cc")), max_size=6)


@st.composite
def logs(draw: st.DrawFn, *, max_trials: int = 4, max_samples: int = 4) -> xr.Dataset:
    """Draw a sound study log: one agent or two, goals or none, still or moving, dropouts, velocities or none, replans.

    Parameters
    ----------
    max_trials, max_samples : int
        At most so many trials, and samples a trial.

    Examples
    --------
    >>> from hypothesis import given
    >>> from ppinfer.studies import validate_log
    >>> @given(logs(max_trials=2))
    ... def test(log):
    ...     assert validate_log(log).ok
    >>> test()
    """
    drawn, options = draw(studies(max_trials=max_trials, max_samples=max_samples))
    return log_of_trials(drawn, **options)


@st.composite
def studies(
    draw: st.DrawFn, *, max_trials: int = 4, max_samples: int = 4
) -> tuple[list[Trial], dict[str, Any]]:
    """Draw trials that belong together, and what else `log_of_trials` takes.

    Parameters
    ----------
    max_trials, max_samples : int
        At most so many trials, and samples a trial.
    """
    agents = ("human", "robot")[: draw(st.integers(1, 2))]
    goals = ("cup", "pan", "π")[: draw(st.sampled_from([0, 2, 3]))]
    options: dict[str, Any] = {"agents": agents, "goals": goals}
    moving, has_velocity, planned = draw(st.booleans()), draw(st.booleans()), draw(st.booleans())
    if planned:
        options["theta"] = agents
    drawn = [
        draw(
            _trials(
                index,
                agents=agents,
                goals=goals,
                moving=moving,
                has_velocity=has_velocity,
                planned=planned,
                max_samples=max_samples,
            )
        )
        for index in range(draw(st.integers(1, max_trials)))
    ]
    if has_velocity:
        options["has_velocity"] = tuple(index == 0 for index in range(len(agents)))
    return drawn, options


@st.composite
def _trials(
    draw: st.DrawFn,
    index: int,
    *,
    agents: Sequence[str],
    goals: Sequence[str],
    moving: bool,
    has_velocity: bool,
    planned: bool,
    max_samples: int,
) -> Trial:
    n = draw(st.integers(1, max_samples))
    step = draw(hnp.arrays(np.float64, n, elements=st.floats(1e-3, 10)))
    position = draw(hnp.arrays(np.float64, (n, len(agents), 2), elements=_FINITE))
    seen = draw(hnp.arrays(np.int8, (n, len(agents)), elements=st.integers(0, 1)))
    position[seen == 0] = np.nan
    velocity = None
    if has_velocity:
        velocity = draw(hnp.arrays(np.float64, (n, len(agents), 2), elements=_FINITE))
        velocity[seen == 0] = np.nan
        velocity[:, 1:] = np.nan
    leading: tuple[int, ...] = (n,) if moving else ()
    placed = draw(hnp.arrays(np.float64, (*leading, len(goals), 2), elements=_FINITE)) if goals else None
    segments: tuple[Segment, ...] = ()
    if goals:
        stop = draw(st.integers(1, n))
        start = draw(st.integers(0, stop - 1))
        segments = (Segment(agents[0], start, stop, draw(st.sampled_from([*goals, ""]))),)
    time = np.cumsum(step)
    variables: dict[str, tuple[Any, ...]] = {
        "event": (("sample",), draw(hnp.arrays(np.int64, n, elements=st.integers(-3, 3)))),
        "score": ((), np.float64(draw(_FINITE)), {"long_name": "points"}),
        "margin": (("agent",), draw(hnp.arrays(np.float64, len(agents), elements=st.floats()))),
    }
    replans: list[Replan] = []
    if planned:
        variables |= {
            "held": (("sample",), draw(hnp.arrays(np.int8, n, elements=st.integers(0, 1)))),
            "end_effector": (("sample", "agent", "table"), position),
            "finish_time": (("agent",), np.full(len(agents), draw(st.floats(0, 9) | st.just(np.nan)))),
            "plan_sets": ((), draw(st.sampled_from(["shared", "independent", ""]))),
            "live_model": ((), draw(st.sampled_from(["", '{"model": "personality"}']))),
        }
        chosen = draw(st.lists(st.integers(0, n - 1), max_size=3, unique=True))
        rng = np.random.default_rng(draw(st.integers(0, 2**32)))
        replans = [_replan(at, float(time[at]), agents, rng) for at in sorted(chosen)]
    return Trial(
        trial_id=f"{index}-{draw(_WORDS)}",
        participant=draw(_WORDS),
        time=time,
        position=position,
        observed=seen,
        velocity=velocity,
        goal_position=placed,
        condition=draw(_WORDS),
        round=draw(st.none() | st.integers(0, 9)),
        seed=draw(st.none() | st.integers(0, 2**40)),
        controller={agent: draw(_WORDS) for agent in agents},
        segments=segments,
        variables=variables,
        replans=replans,
    )


def _replan(sample: int, time: float, agents: Sequence[str], rng: np.random.Generator) -> Replan:
    # whoever is not among these has left
    there = [agents[index] for index in rng.permutation(len(agents))[: rng.integers(1, len(agents) + 1)]]
    plans = [_plans(agent, rng) for agent in there]
    shape = tuple(len(one) for one in plans)
    cost = rng.uniform(0.0, 9.0, (len(shape), *shape))
    cost[:, rng.random(shape) < 0.4] = np.inf
    return Replan(
        time=time,
        sample=sample,
        agent=there[0],
        plans=plans,
        cost=cost,
        contact_time=np.where(rng.random(shape) < 0.4, np.inf, rng.uniform(0.0, 9.0, shape)),
        decision=[int(rng.integers(shape[0])), *(int(rng.integers(-1, size)) for size in shape[1:])],
        live_log_posterior=np.log(rng.dirichlet(np.ones(len(agents)))) if rng.random() < 0.5 else None,
        seed=int(rng.integers(2**62)),
    )


def _plans(agent: str, rng: np.random.Generator) -> PlanSet:
    row_size = rng.integers(1, 4, rng.integers(1, 4))
    starts = np.cumsum(row_size) - row_size
    time = np.cumsum(rng.uniform(0.1, 1.0, row_size.sum()))
    marked = [None if index < 0 else int(index) for index in rng.integers(-1, len(row_size), 2)]
    return PlanSet(
        agent,
        row_size,
        time - np.repeat(time[starts], row_size),
        rng.normal(size=(row_size.sum(), 2)),
        static=marked[0],
        committed=marked[1],
    )
