"""Logs of parallel play made by hand, of any robots, humans and outcomes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ppinfer.studies import log_of_trials
from ppinfer.testing.example_plays import planned_study

ROBOTS = ("defensive", "norm", "bayes")
HUMANS = ("defensive", "selfish", "norm")
# of a human who favours itself: what robots with a belief come to, in the end
_BELIEF = {"defensive": 0.3, "selfish": 0.92, "norm": 0.5}


def make_plays(
    *,
    robots=ROBOTS,
    humans=HUMANS,
    plan_sets=("shared",),
    scenes=2,
    replans=5,
    believers=("bayes", "bayes-literal", "bayes-risk"),
    unfinished=(),
    seed=0,
):
    """Return a log of every robot with every human in every scene.

    `unfinished` are indices of trials that the robot does not finish; robots not among `believers` hold no belief.
    """
    rng = np.random.default_rng(seed)
    drawn, options = planned_study(trials=1, replans=replans, plans=1, seed=seed)
    cells = [
        (scene, sets, robot, human)
        for scene in range(scenes)
        for sets in plan_sets
        for human in humans
        for robot in robots
    ]
    trials = []
    for index, (scene, sets, robot, human) in enumerate(cells):
        end = drawn[0].time[-1]
        finish = np.round(end * rng.uniform(0.5, 0.95, 2), 1)
        if index in unfinished:
            finish[1] = np.nan
        held = np.zeros(len(drawn[0].time), np.int8)
        start = rng.integers(1, len(held) - 4)
        held[start : start + rng.integers(0, 4)] = robot != "defensive"
        made, odds = [], 0.0
        for replan in drawn[0].replans:
            if replan.agent != "robot":
                made.append(replan)
                continue
            aim = np.log(_BELIEF[human] / (1 - _BELIEF[human])) if human in _BELIEF else 0.0
            belief = 1 / (1 + np.exp(-odds))
            log = np.log([belief, 1 - belief]) if robot in believers else None
            made.append(replace(replan, live_log_posterior=log))
            odds += 0.5 * (aim - odds) + rng.normal(0, 0.4)
        trials.append(
            replace(
                drawn[0],
                trial_id=f"scene-{scene}/{sets}/{robot}/{human}",
                participant=f"simulated {human}",
                controller={"human": human, "robot": robot},
                outcome="timeout" if index in unfinished else "completed",
                replans=made,
                variables={
                    **drawn[0].variables,
                    "held": (("sample",), held),
                    "finish_time": (("agent",), finish),
                    "stops": ((), int(held.sum())),
                    "stop_episodes": ((), int(held.any())),
                    "scene": ((), scene),
                    "plan_sets": ((), sets),
                    "live_model": ((), '{"model": "personality"}' if robot in believers else ""),
                },
            )
        )
    return log_of_trials(trials, title="Plays made by hand", source="a test", **options)
