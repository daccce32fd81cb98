"""Small study logs, made by hand or drawn by Hypothesis."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppinfer.studies import Segment, Trial, build_log


def study_data(folder):
    """Return a folder of real data, or skip where there is none."""
    root = os.environ.get("PPINFER_DATA")
    if not root or not (Path(root) / folder).is_dir():
        pytest.skip(f"needs the folder {folder} under the environment variable PPINFER_DATA")
    return Path(root) / folder


def small_log(**changed):
    """Return a log of two trials, two agents, two goals and two segments; arguments replace its parts."""
    rng = np.random.default_rng(5)
    parts = {
        "agents": ["human", "robot"],
        "row_size": [4, 3],
        "trial_id": ["a", "b"],
        "participant": ["p1", "p2"],
        "time": [0.0, 0.1, 0.2, 0.3, 0.0, 0.1, 0.3],
        "position": rng.normal(size=(7, 2, 2)),
        "goals": ["cup", "pan"],
        "goal_position": np.array([[0.0, 1.0], [2.0, 3.0]]),
        "condition": ["near", ""],
        "segment_trial": [0, 1],
        "segment_agent": ["human", "robot"],
        "segment_start": [1, 0],
        "segment_stop": [4, 3],
        "true_goal": ["cup", "pan"],
    }
    return build_log(**(parts | changed))


def plain(log):
    """Return the log without the attributes that storing adds."""
    return log.assign_attrs(content_sha256="").drop_attrs(deep=False)


finite = st.floats(-1e6, 1e6, allow_nan=False)
words = st.text(st.characters(exclude_categories=("Cs", "Cc")), max_size=6)


@st.composite
def trials(draw, index, *, agents, goals, moving, has_velocity):
    """Draw one trial."""
    n = draw(st.integers(1, 4))
    step = draw(hnp.arrays(np.float64, n, elements=st.floats(1e-3, 10)))
    position = draw(hnp.arrays(np.float64, (n, len(agents), 2), elements=finite))
    seen = draw(hnp.arrays(np.int8, (n, len(agents)), elements=st.integers(0, 1)))
    position[seen == 0] = np.nan
    velocity = None
    if has_velocity:
        velocity = draw(hnp.arrays(np.float64, (n, len(agents), 2), elements=finite))
        velocity[seen == 0] = np.nan
        velocity[:, 1:] = np.nan
    leading = (n,) if moving else ()
    placed = draw(hnp.arrays(np.float64, (*leading, len(goals), 2), elements=finite)) if goals else None
    segments = ()
    if goals:
        stop = draw(st.integers(1, n))
        start = draw(st.integers(0, stop - 1))
        segments = (Segment(agents[0], start, stop, draw(st.sampled_from([*goals, ""]))),)
    return Trial(
        trial_id=f"{index}-{draw(words)}",
        participant=draw(words),
        time=np.cumsum(step),
        position=position,
        observed=seen,
        velocity=velocity,
        goal_position=placed,
        condition=draw(words),
        round=draw(st.none() | st.integers(0, 9)),
        seed=draw(st.none() | st.integers(0, 2**40)),
        controller={agent: draw(words) for agent in agents},
        segments=segments,
        variables={
            "event": (("sample",), draw(hnp.arrays(np.int64, n, elements=st.integers(-3, 3)))),
            "score": ((), np.float64(draw(finite)), {"long_name": "points"}),
        },
    )


@st.composite
def studies(draw):
    """Draw (trials, what else `log_of_trials` takes)."""
    agents = ("human", "robot")[: draw(st.integers(1, 2))]
    goals = ("cup", "pan", "π")[: draw(st.sampled_from([0, 2, 3]))]
    options = {"agents": agents, "goals": goals}
    moving, has_velocity = draw(st.booleans()), draw(st.booleans())
    count = draw(st.integers(1, 4))
    drawn = [
        draw(trials(index, agents=agents, goals=goals, moving=moving, has_velocity=has_velocity))
        for index in range(count)
    ]
    if has_velocity:
        options["has_velocity"] = tuple(index == 0 for index in range(len(agents)))
    return drawn, options
