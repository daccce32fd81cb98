"""A small log of a robot and a human that has every variable that a metric is made of."""

from __future__ import annotations

import numpy as np
import xarray as xr


def example_team_log(
    *, participants: int = 3, rounds: int = 2, conditions: int = 2, samples: int = 12, seed: int = 0
) -> xr.Dataset:
    """Return a log of a robot and a human with tasks, goals, picks, scores, collisions, stops and waiting flags.

    It is made up, and means nothing: each metric of `ppinfer.studies.metrics` finds what it needs, and dropouts and
    irregular samples besides. Times and positions are multiples of 1/64, so that sums of them are exact.

    Parameters
    ----------
    participants, rounds, conditions : int
        Every participant has every round of every condition.
    samples : int
        Most samples of a trial; trials have at least half of them.
    seed : int
        Of all that is random.

    Examples
    --------
    >>> log = example_team_log(participants=2)
    >>> log.sizes["trial"], "team_score" in log
    (8, True)
    """
    from ppinfer.studies import build_log

    rng = np.random.default_rng(seed)
    trials = participants * rounds * conditions
    row_size = rng.integers(max(1, samples // 2), samples + 1, trials)
    total = int(row_size.sum())
    start = np.cumsum(row_size) - row_size
    step = rng.integers(4, 16, total) / 64
    step[start] = 0.0
    time = np.concatenate([np.cumsum(part) for part in np.split(step, start[1:])])
    moves = rng.integers(-8, 9, (total, 2, 2)) / 64 * (rng.random((total, 2, 1)) < 0.6)
    position = np.cumsum(moves, axis=0)
    position[rng.random((total, 2)) < 0.1] = np.nan
    length = time[start + row_size - 1]
    # tasks end at a sample; a task in six never does
    ends = time[start[:, None] + rng.integers(0, row_size[:, None], (trials, 2))]
    finish = np.where(rng.random((trials, 2)) < 1 / 6, np.nan, ends)
    draw = np.repeat(rng.integers(-9, 9, (total // 4 + 1, 3, 2)).astype(np.float64), 4, axis=0)[:total]
    marks = (rng.random((5, total)) < 0.25).astype(np.int8)
    picks = np.where(rng.random((2, total)) < 0.1, rng.integers(0, 3, (2, total)), -1).astype(np.int8)
    first = np.where(rng.random(trials) < 0.2, np.nan, length / 2)
    episodes = rng.integers(0, 3, trials)
    segment = np.repeat(np.arange(trials), 2)
    return build_log(
        agents=["human", "robot"],
        goals=["a", "b", "c"],
        row_size=row_size,
        time=time,
        position=position,
        goal_position=draw,
        participant=[f"p{trial // (rounds * conditions)}" for trial in range(trials)],
        condition=[f"c{trial // rounds % conditions}" for trial in range(trials)],
        round=[trial % rounds for trial in range(trials)],
        controller={"human": "person", "robot": "example"},
        segment_trial=segment,
        segment_agent=["human", "robot"] * trials,
        segment_start=np.zeros(segment.size, np.int64),
        segment_stop=row_size[segment],
        true_goal=[""] * segment.size,
        title="made up by ppinfer.testing.example_team_log",
        variables={
            "finish_time": (("trial", "agent"), finish),
            "stops": (("trial",), episodes * rng.integers(1, 4, trials)),
            "stop_episodes": (("trial",), episodes),
            "team_score": (("trial",), rng.integers(0, 9, trials)),
            "first_score_s": (("trial",), first),
            "collision": (("sample",), marks[0]),
            "scored": (("sample",), marks[1]),
            "is_human_waiting": (("sample",), marks[2]),
            "is_robot_waiting": (("sample",), marks[3]),
            "human_pick": (("sample",), picks[0]),
            "robot_pick": (("sample",), picks[1]),
            "pursued": (("sample", "agent"), rng.integers(-1, 3, (total, 2)).astype(np.int8)),
            "end_effector": (("sample", "agent", "table"), position / 2),
        },
    )
