"""States and controls come from earlier samples only, and say how."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ppinfer.errors import LogError, ModelError
from ppinfer.goals import Dynamics, GoalEvidence, causal_motion
from ppinfer.goals.motion import previous_seen


def evidence_of(position, *, time=None, row_size=None, **more):
    position = np.asarray(position, dtype=float)
    return GoalEvidence(
        time=np.arange(len(position)) * 0.5 if time is None else np.asarray(time, dtype=float),
        position=position,
        goals=np.zeros((1 if row_size is None else len(row_size), 1, 2)),
        row_size=np.array([len(position)] if row_size is None else row_size),
        goal_labels=("cup",),
        **more,
    )


SQUARES = [[0.0, 0.0], [1.0, 0.0], [4.0, 0.0], [9.0, 0.0]]


def test_a_single_integrator_acts_from_the_position_before():
    motion = causal_motion(evidence_of(SQUARES), Dynamics.single_integrator(0.5))
    assert motion.informative.tolist() == [False, True, True, True]
    assert_allclose(motion.control[:, 0], [0, 2, 6, 10])
    assert_allclose(motion.state[1:, 0], [0, 1, 4])
    assert motion.control_source == "backward differences of positions"


def test_a_double_integrator_needs_three_samples():
    motion = causal_motion(evidence_of(SQUARES), Dynamics.double_integrator(0.5))
    assert motion.informative.tolist() == [False, False, True, True]
    assert_allclose(motion.state[2], [1, 2, 0, 0])
    assert_allclose(motion.control[2:, 0], [(6 - 2) / 0.5, (10 - 6) / 0.5])


def test_logged_velocities_shorten_the_wait_and_are_named():
    logged = evidence_of(SQUARES, velocity=np.array([[1.0, 0], [3, 0], [5, 0], [7, 0]]))
    motion = causal_motion(logged, Dynamics.double_integrator(0.5))
    assert motion.informative.tolist() == [False, True, True, True]
    assert_allclose(motion.control[1:, 0], 4.0)
    assert (motion.velocity_source, motion.control_source) == ("logged", "differences of logged velocities")


def test_a_logged_control_belongs_to_its_own_sample_and_kind():
    logged = evidence_of(SQUARES, control=np.ones((4, 2)), control_order=1)
    motion = causal_motion(logged, Dynamics.single_integrator(0.5))
    assert motion.informative.all()
    assert_allclose(motion.state, logged.position)
    assert motion.control_source == "logged"
    acceleration = causal_motion(replace(logged, control_order=2), Dynamics.single_integrator(0.5))
    assert acceleration.control_source == "backward differences of positions"


def test_a_dropout_is_as_good_as_a_sample_that_is_not_there():
    whole = evidence_of(SQUARES)
    holed = replace(
        whole,
        position=np.where([[1], [1], [0], [1]], whole.position, np.nan),
        observed=np.array([True, True, False, True]),
    )
    without = evidence_of(np.delete(SQUARES, 2, axis=0), time=[0, 0.5, 1.5])
    for name in ("single-integrator", "double-integrator"):
        dynamics = Dynamics.named(name, 0.5)
        ours, theirs = causal_motion(holed, dynamics), causal_motion(without, dynamics)
        assert not ours.informative[2]
        assert_allclose(np.delete(ours.control, 2, axis=0), theirs.control)
        assert_allclose(np.delete(ours.state, 2, axis=0), theirs.state)


def test_nothing_crosses_from_one_row_into_the_next():
    motion = causal_motion(
        evidence_of(SQUARES, row_size=[2, 2], time=[0, 0.5, 0, 0.5]), Dynamics.single_integrator(0.5)
    )
    assert motion.informative.tolist() == [False, True, False, True]
    assert_allclose(motion.control[3, 0], 10)


def test_dynamics_of_ones_own_are_inverted_by_least_squares():
    A = np.array([[1.0, 0.0, 0.4, 0.0], [0.0, 1.0, 0.0, 0.4], [0.0, 0.0, 0.9, 0.0], [0.0, 0.0, 0.0, 0.9]])
    B = np.vstack([np.zeros((2, 2)), np.eye(2)])
    dynamics = Dynamics(A, B, (0, 1), (2, 3), dt=0.5)
    rng = np.random.default_rng(0)
    control, state = rng.normal(size=(5, 2)), np.zeros((6, 4))
    for t in range(5):
        state[t + 1] = dynamics.step(state[t], control[t])
    motion = causal_motion(evidence_of(state[:, :2], velocity=state[:, 2:]), dynamics)
    assert_allclose(motion.control[1:], control, atol=1e-12)
    late = evidence_of(state[:, :2], velocity=state[:, 2:], time=[0, 0.5, 1.0, 2.0, 2.5, 3.0])
    assert causal_motion(late, dynamics).informative.tolist() == [False, True, True, False, True, True]


def test_what_does_not_fit_is_refused():
    with pytest.raises(ModelError, match="move in 3 dimensions, the log in 2"):
        causal_motion(evidence_of(SQUARES), Dynamics.single_integrator(0.5, dimensions=3))
    with pytest.raises(ModelError, match="a log tells no more"):
        causal_motion(evidence_of(SQUARES), Dynamics(np.eye(3), np.ones((3, 1)), (0, 1)))
    broken = evidence_of(SQUARES, velocity=np.array([[0.0, 0], [np.nan, 0], [0, 0], [0, 0]]))
    with pytest.raises(LogError, match="sample 1: velocity is logged but not finite"):
        causal_motion(broken, Dynamics.double_integrator(0.5))
    with pytest.raises(ModelError, match="control has 1 entries"):
        causal_motion(
            evidence_of(SQUARES, control=np.ones((4, 1)), control_order=1), Dynamics.single_integrator(0.5)
        )


def test_previous_seen_skips_dropouts_and_stops_at_the_row():
    evidence = evidence_of(
        np.where([[1], [0], [1], [1]], SQUARES, np.nan),
        row_size=[3, 1],
        time=[0, 1, 2, 0],
        observed=np.array([True, False, True, True]),
    )
    assert previous_seen(evidence).tolist() == [-1, 0, 0, -1]


@pytest.mark.parametrize("logged", [False, True], ids=["positions only", "velocities logged"])
@pytest.mark.parametrize("name", ["single-integrator", "double-integrator"])
def test_one_pass_over_an_integrator_tells_what_the_general_way_does(name, logged, monkeypatch):
    rng = np.random.default_rng(3)
    row_size = np.array([1, 2, 3, 40, 1, 60])
    samples = int(row_size.sum())
    position = rng.normal(size=(samples, 2))
    for observed in (None, rng.random(samples) > 0.4):
        seen = np.where(np.ones(samples, bool) if observed is None else observed, 1.0, np.nan)[:, None]
        evidence = evidence_of(
            position * seen,
            time=np.cumsum(rng.uniform(0.05, 0.2, samples)),
            row_size=row_size,
            observed=observed,
            velocity=rng.normal(size=(samples, 2)) * seen if logged else None,
        )
        dynamics = Dynamics.named(name, 0.1)
        fast = causal_motion(evidence, dynamics)
        with monkeypatch.context() as patch:
            patch.setattr("ppinfer.goals.motion._difference_motion", lambda evidence, dynamics: None)
            general = causal_motion(evidence, dynamics)
        told = general.informative
        assert fast.informative.tolist() == told.tolist()
        assert_allclose(fast.state[told], general.state[told], rtol=1e-15)
        assert_allclose(fast.control[told], general.control[told], rtol=1e-12)
        assert not fast.state[~told].any()
        assert not fast.control[~told].any()
        assert (fast.velocity_source, fast.control_source) == (
            general.velocity_source,
            general.control_source,
        )
