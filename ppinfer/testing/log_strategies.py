"""Hypothesis strategies for whole study logs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppinfer.studies import Segment, Trial, log_of_trials

_FINITE = st.floats(-1e6, 1e6, allow_nan=False)
_WORDS = st.text(st.characters(exclude_categories=("Cs", "Cc")), max_size=6)


@st.composite
def logs(draw: st.DrawFn, *, max_trials: int = 4, max_samples: int = 4) -> xr.Dataset:
    """Draw a sound study log: one agent or two, goals or none, still or moving, dropouts, velocities or none.

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
    moving, has_velocity = draw(st.booleans()), draw(st.booleans())
    drawn = [
        draw(
            _trials(
                index,
                agents=agents,
                goals=goals,
                moving=moving,
                has_velocity=has_velocity,
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
    return Trial(
        trial_id=f"{index}-{draw(_WORDS)}",
        participant=draw(_WORDS),
        time=np.cumsum(step),
        position=position,
        observed=seen,
        velocity=velocity,
        goal_position=placed,
        condition=draw(_WORDS),
        round=draw(st.none() | st.integers(0, 9)),
        seed=draw(st.none() | st.integers(0, 2**40)),
        controller={agent: draw(_WORDS) for agent in agents},
        segments=segments,
        variables={
            "event": (("sample",), draw(hnp.arrays(np.int64, n, elements=st.integers(-3, 3)))),
            "score": ((), np.float64(draw(_FINITE)), {"long_name": "points"}),
        },
    )
