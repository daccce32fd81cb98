"""Logs of every kind that a report is made of, small."""

import numpy as np

from ppinfer.studies import build_log


def reaches(
    *,
    agents=("walker",),
    space=("x", "y"),
    participants=("p1", "p2", "p3"),
    conditions=("a", "b"),
    rounds=2,
    samples=12,
    goals=("cup", "pan"),
    seed=0,
):
    """Return a log in which the first agent reaches for one of some goals and the others stroll about."""
    rng = np.random.default_rng(seed)
    cells = [
        (person, condition, turn)
        for person in participants
        for condition in conditions
        for turn in range(rounds)
    ]
    trials = len(cells)
    places = 4.0 * rng.normal(size=(trials, max(1, len(goals)), len(space)))
    aim = rng.integers(0, max(1, len(goals)), trials)
    share = np.linspace(0, 1, samples)[None, :, None]
    path = share * places[np.arange(trials), aim][:, None] + 0.02 * rng.normal(
        size=(trials, samples, len(space))
    )
    others = np.cumsum(0.2 * rng.normal(size=(trials, samples, len(agents) - 1, len(space))), axis=1)
    position = np.concatenate([path[:, :, None], others], axis=2)
    there = {}
    if goals:
        there = {
            "goals": list(goals),
            "goal_position": places,
            "segment_trial": np.arange(trials),
            "segment_agent": [agents[0]] * trials,
            "segment_start": np.zeros(trials, np.int64),
            "segment_stop": np.full(trials, samples),
            "true_goal": [goals[at] for at in aim],
        }
    return build_log(
        agents=list(agents),
        space=list(space),
        row_size=np.full(trials, samples),
        time=np.tile(0.1 * np.arange(samples), trials),
        position=position.reshape(-1, len(agents), len(space)),
        trial_id=[f"{person}-{condition}-{turn}" for person, condition, turn in cells],
        participant=[person for person, _, _ in cells],
        condition=[condition for _, condition, _ in cells],
        round=[turn for _, _, turn in cells],
        title="Reaches made by hand",
        **there,
    )
