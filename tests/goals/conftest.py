"""Evidence of one and of two samples, about a goal at the origin and one to the east."""

import numpy as np
import pytest

from ppinfer.goals import GoalEvidence


def _evidence(position, goal):
    position = np.atleast_2d(np.asarray(position, dtype=float))
    return GoalEvidence(
        time=np.arange(len(position)) * 0.1,
        position=position,
        goals=np.asarray(goal, dtype=float).reshape(1, 1, 2),
        row_size=np.array([len(position)]),
        goal_labels=("cup",),
        time_step=0.1,
    )


@pytest.fixture
def one_sample():
    """From a position to evidence about a goal at the origin."""
    return lambda position: _evidence(position, [0.0, 0.0])


@pytest.fixture
def two_samples():
    """From an angle to a step at that angle to the direction of the goal."""
    return lambda angle: _evidence([[0.0, 0.0], [np.cos(angle), np.sin(angle)]], [5.0, 0.0])
