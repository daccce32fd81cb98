"""Small study logs made by hand, and where the real ones are."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from ppinfer.studies import build_log


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
