"""Where the links are, and which joint angles reach a point."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ppsim.arms.geometry import ARMS, Arm
from ppsim.errors import SimulationError

ANGLE = st.floats(-2.6, 2.6)


@given(arrays(np.float64, 2, elements=ANGLE), st.floats(-4.0, 4.0))
def test_one_of_the_configurations_that_reach_the_end_effector_is_the_arms_own(joints, heading):
    arm = Arm(base=(0.3, -0.2), heading=heading, links=(0.5, 0.4))
    ways = arm.configurations(arm.end_effector(joints))
    there = np.isfinite(ways).all(axis=-1)
    # at a straight elbow both ways are one, and the cosine is flat
    assert np.abs(ways[there] - joints).max(axis=-1).min() < 1e-6
    assert np.allclose(arm.end_effector(ways[there]), arm.end_effector(joints), atol=1e-9)


def test_the_two_ways_bend_the_elbow_to_either_side():
    ways = ARMS["robot"].configurations([0.1, 0.2])
    assert ways[0, 1] > 0 > ways[1, 1]
    assert np.isclose(ways[0, 1], -ways[1, 1])


def test_points_out_of_reach_and_angles_beyond_the_limits_are_nan():
    arm = Arm(base=(0.0, 0.0), limits=(np.pi, 1.0), home=(0.0, 0.0))
    assert np.isnan(arm.configurations([1.1, 0.0])).all()
    # the elbow would have to bend by 2.5 rad
    assert np.isnan(arm.configurations([0.3, 0.0])).all()
    assert np.isfinite(arm.configurations([1.0, 0.0])).all()


def test_links_keep_their_lengths_and_poses_come_in_batches():
    rng = np.random.default_rng(0)
    joints = rng.uniform(-2.0, 2.0, (4, 5, 2))
    points = ARMS["human"].points(joints)
    assert points.shape == (4, 5, 3, 2)
    assert np.allclose(np.linalg.norm(np.diff(points, axis=-2), axis=-1), 0.5)
    assert np.allclose(points[2, 3], ARMS["human"].points(joints[2, 3]))


def test_the_two_arms_face_each_other():
    robot, human = (ARMS[agent].points(ARMS[agent].home) for agent in ("robot", "human"))
    assert np.allclose(human, -robot)
    assert ARMS["robot"].points([0.0, 0.0])[2, 0] > -0.6


@pytest.mark.parametrize(
    "wrong", [{"links": (0.5, 0.0)}, {"radius": -1.0}, {"home": (0.0, 3.0)}, {"joint_speed": float("inf")}]
)
def test_an_arm_that_cannot_be_is_refused(wrong):
    with pytest.raises(SimulationError):
        Arm(base=(0.0, 0.0), **wrong)
