"""Made-up posteriors of any shape, for tests: what is scored and drawn needs no model behind it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import xarray as xr


def make_posterior(
    *,
    row_sizes: tuple[int, ...] = (30, 25, 40, 20),
    participants: tuple[str, ...] = ("p1", "p1", "p2", "p3"),
    goals: tuple[str, ...] = ("0", "1", "2"),
    segments_per_trial: int = 2,
    moving_goals: bool = False,
    outliers: bool = False,
    sharpness: float = 0.15,
    seed: int = 0,
) -> xr.Dataset:
    """Return a posterior whose belief in a random true goal grows along each segment, with noise."""
    rng = np.random.default_rng(seed)
    trials, samples = len(row_sizes), sum(row_sizes)
    labels = np.array(goals, dtype=object)
    goal_position = 5 * rng.normal(size=(trials, len(goals), 2))
    logits = rng.normal(scale=0.8, size=(samples, len(goals)))
    position = np.zeros((samples, 2))
    spans, true = [], []
    first = 0
    for trial, size in enumerate(row_sizes):
        here = rng.normal(size=2)
        edges = np.linspace(0, size, segments_per_trial + 1).astype(int)
        for start, stop in pairwise(edges):
            goal = int(rng.integers(len(goals)))
            steps = np.arange(stop - start)
            logits[first + start : first + stop, goal] += sharpness * steps
            share = (steps / max(1, len(steps) - 1))[:, None]
            there = goal_position[trial, goal]
            noise = 0.1 * rng.normal(size=(len(steps), 2))
            position[first + start : first + stop] = (1 - share) * here + share * there + noise
            here = there
            spans.append((trial, start, stop))
            true.append(labels[goal])
        first += size
    log_posterior = logits - np.log(np.exp(logits).sum(axis=1, keepdims=True))
    observed = (rng.random(samples) > 0.05).astype(np.int8)
    position[observed == 0] = np.nan
    span = np.array(spans, dtype=np.int64).reshape(-1, 3)
    where = "sample" if moving_goals else "trial"
    if moving_goals:
        goal_position = np.repeat(goal_position, row_sizes, axis=0)
    variables = {
        "trial_id": ("trial", np.array([f"t{i}" for i in range(trials)], dtype=object)),
        "row_size": ("trial", np.array(row_sizes, dtype=np.int64)),
        "participant": ("trial", np.array(participants, dtype=object)),
        "time": ("sample", np.concatenate([0.1 * np.arange(size) for size in row_sizes])),
        "position": (("sample", "space"), position, {"units": "m"}),
        "observed": ("sample", observed),
        "log_posterior": (("sample", "goal"), log_posterior),
        "goal_position": ((where, "goal", "space"), goal_position, {"units": "m"}),
        "goal_present": ((where, "goal"), np.ones(goal_position.shape[:2], dtype=np.int8)),
        "segment_trial": ("segment", span[:, 0]),
        "segment_start": ("segment", span[:, 1]),
        "segment_stop": ("segment", span[:, 2]),
        "true_goal": ("segment", np.array(true, dtype=object)),
    }
    if outliers:
        variables["outlier"] = ("sample", (rng.random(samples) < 0.05).astype(np.int8))
    return xr.Dataset(
        variables,
        coords={"goal": labels, "space": np.array(["x", "y"], dtype=object)},
        attrs={
            "ppinfer_format": "posterior",
            "ppinfer_format_version": 1,
            "hypothesis": "goal",
            "agent": "human",
            "mode": "filter",
            "model": "goal-lqr",
            "configuration": '{"parameters": {"rationality": 0.005}}',
            "seed": 0,
            "ppinfer_version": "0.1.0",
            "input": "log.nc",
            "input_sha256": "ab" * 32,
            "state_source": "finite differences of past positions",
            "outliers_gated": 0,
            "samples_missing": int((observed == 0).sum()),
        },
    )
