"""Scenes and plans that the tests of the arms share."""

from __future__ import annotations

import numpy as np

from ppsim.arms.plans import sample_plans
from ppsim.arms.scene import Scene


def scene_of(seed):
    """Return the scene of a seed."""
    return Scene.random(np.random.default_rng(seed))


def plans_of(scene, seed, count=7):
    """Return the plans of both arms from home."""
    return [
        sample_plans(
            scene.arms[agent],
            agent,
            scene.arms[agent].home,
            scene.tasks[agent].goals(),
            seed=2 * seed + number,
            count=count,
        )
        for number, agent in enumerate(scene.agents)
    ]
