"""Evidence about two or three agents, drawn at random."""

from __future__ import annotations

import numpy as np

from ppinfer.goals import GoalEvidence, PartnerMotion


def scene(rng, *, rows=4, samples=30, goals=3, partners=1, velocities=False, dropouts=False):
    """Return evidence of an agent and its partners, who all wander about among the goals."""
    total = rows * samples

    def wander():
        steps = rng.normal(0.0, 0.4, (rows, samples, 2)) + rng.normal(0.0, 0.3, (rows, 1, 2))
        return (rng.uniform(-5, 5, (rows, 1, 2)) + steps.cumsum(axis=1)).reshape(total, 2)

    def seen():
        return rng.random(total) < 0.7 if dropouts else np.ones(total, dtype=bool)

    observed = seen()
    return GoalEvidence(
        time=np.tile(np.arange(samples) * 0.1, rows),
        position=np.where(observed[:, None], wander(), np.nan),
        goals=rng.uniform(-8, 8, (rows, goals, 2)),
        row_size=np.full(rows, samples),
        goal_labels=tuple(str(goal) for goal in range(goals)),
        observed=observed,
        time_step=0.1,
        partners=tuple(
            PartnerMotion(
                f"robot {index}",
                wander(),
                seen(),
                rng.normal(0.0, 2.0, (total, 2)) if velocities else None,
            )
            for index in range(partners)
        ),
        agent="human",
    )
