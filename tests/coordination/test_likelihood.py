"""Likelihoods of motion under profiles (6), with each of the distances."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from ppinfer.coordination import (
    Distance,
    Euclidean,
    Motion,
    RootMeanSquare,
    TimeWarping,
    TrajectoryLikelihood,
)
from ppinfer.errors import ModelError
from ppinfer.testing import example_trial


@pytest.fixture(scope="module")
def trial():
    return example_trial(np.random.default_rng(0), replans=2, plans=(4, 3), held=0.0)


def warped(one, other):
    """Return the dynamic time warping distance, by the recursion."""
    best = np.full((len(one) + 1, len(other) + 1), math.inf)
    best[0, 0] = 0.0
    for i in range(len(one)):
        for j in range(len(other)):
            step = min(best[i, j], best[i, j + 1], best[i + 1, j])
            best[i + 1, j + 1] = step + float(((one[i] - other[j]) ** 2).sum())
    return math.sqrt(best[-1, -1])


ORACLES = [
    (Euclidean(), lambda one, other: math.sqrt(float(((one - other) ** 2).sum()))),
    (RootMeanSquare(), lambda one, other: math.sqrt(float(((one - other) ** 2).sum()) / len(one))),
    (TimeWarping(), warped),
]


@pytest.mark.parametrize(("distance", "oracle"), ORACLES, ids=["euclidean", "rms", "dtw"])
def test_a_distance_is_its_formula(distance, oracle):
    rng = np.random.default_rng(0)
    plans, motion = rng.normal(size=(3, 9, 4)), rng.normal(size=(9, 4))
    expected = [oracle(plan, motion) for plan in plans]
    np.testing.assert_allclose(distance.between(plans, motion), expected, rtol=1e-9)


@pytest.mark.parametrize("distance", [Euclidean(), RootMeanSquare(), TimeWarping()], ids=lambda one: one.name)
@pytest.mark.parametrize("velocities", [True, False])
def test_the_likelihood_of_a_profile_is_that_of_everybodys_states(trial, distance, velocities):
    first, second = trial
    motion = second.motion
    found = TrajectoryLikelihood(2.0, distance, velocities).log_likelihood(first.plans, motion)
    assert found.axes == first.game.plans
    times = np.arange(len(motion.held)) * motion.dt

    def states(where, speed):
        return np.concatenate([where, speed] if velocities else [where], axis=1)

    for cell in ((0, 0), (2, 1), (3, 2)):
        planned = np.concatenate(
            [
                states(own.positions(times)[plan], own.velocities(times)[plan])
                for own, plan in zip(first.plans, cell, strict=True)
            ],
            axis=1,
        )
        moved = np.concatenate([states(motion.position[:, i], motion.velocity[:, i]) for i in (0, 1)], axis=1)
        expected = -2.0 * distance.between(planned[None], moved)[0]
        assert found.log_values[cell] == pytest.approx(expected, rel=1e-12)


def test_agents_who_do_not_count_leave_it_constant_and_missing_samples_tell_nothing(trial):
    first, second = trial
    found = TrajectoryLikelihood().log_likelihood(first.plans, second.motion, "human").log_values
    assert (found == found[:1]).all()
    gone = second.motion.position.copy()
    gone[:, 1] = np.nan
    silent = TrajectoryLikelihood().log_likelihood(
        first.plans, Motion(gone, second.motion.velocity, second.motion.held), "human"
    )
    assert (silent.log_values == 0.0).all()
    with pytest.raises(ModelError, match="guest"):
        TrajectoryLikelihood().log_likelihood(first.plans, second.motion, "guest")


def test_who_is_merely_late_is_close_by_time_warping_only():
    late = np.array([[0.0]] * 4 + [[float(k)] for k in range(1, 6)])
    plan = np.array([[float(min(k, 5))] for k in range(9)])[None]
    assert TimeWarping().between(plan, late)[0] == 0.0
    assert TimeWarping(window=1).between(plan, late)[0] > 0.0
    assert Euclidean().between(plan, late)[0] > 5.0


def test_a_users_own_distance_is_one_class(trial):
    @dataclass(frozen=True)
    class Last(Distance):
        def between(self, plans, motion):
            return np.abs(plans[:, -1] - motion[-1]).max(axis=-1)

    first, second = trial
    p = TrajectoryLikelihood(distance=Last()).log_likelihood(first.plans, second.motion)
    assert p.normalize("robot_plan", "human_plan").values.sum() == pytest.approx(1.0)
