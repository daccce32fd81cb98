"""The table of first contacts, against distances computed otherwise."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ppinfer.coordination.plans import PlanSet
from ppsim.arms.contacts import clearance_between, contact_tables
from ppsim.arms.geometry import ARMS, Arm
from ppsim.errors import SimulationError

from .situations import plans_of, scene_of

PAIR = [ARMS["robot"], ARMS["human"]]
POSE = arrays(np.float64, 2, elements=st.floats(-2.7, 2.7))


def bone_distance(one, two):
    """Return the distance between two chains of segments by minimising over where on each of them, exactly.

    The squared distance of points on two segments is a convex quadratic in their two shares, so its least value over
    the square is inside, where the gradient vanishes, or on one of the four edges.
    """
    least = np.inf
    for a, b in pairwise(one):
        for c, d in pairwise(two):
            u, v, w = b - a, d - c, a - c
            shares = []
            matrix = np.array([[u @ u, -(u @ v)], [-(u @ v), v @ v]])
            if np.linalg.det(matrix) > 1e-12:
                inside = np.linalg.solve(matrix, [-(u @ w), v @ w])
                if (inside >= 0).all() and (inside <= 1).all():
                    shares.append(inside)
            for end in (0.0, 1.0):
                shares.append([end, np.clip(v @ (w + end * u) / (v @ v), 0, 1)])
                shares.append([np.clip(u @ (end * v - w) / (u @ u), 0, 1), end])
            for s, t in shares:
                least = min(least, np.linalg.norm(w + s * u - t * v))
    return least


def literal_table(arms, plans, stride, margin):
    """Return the table by going through all profiles and instants."""
    table = np.full([len(own) for own in plans], np.inf)
    for profile in np.ndindex(table.shape):
        ends = [
            np.inf if number == own.static else own.duration[number]
            for own, number in zip(plans, profile, strict=True)
        ]
        if np.isinf(min(ends)):
            continue
        times = np.arange(1, int(np.floor(min(ends) / stride + 1e-9)) + 1) * stride
        along = [
            arm.points(own.restrict([number]).positions(times)[0])
            for arm, own, number in zip(arms, plans, profile, strict=True)
        ]
        for time, *points in zip(times, *along, strict=True):
            if bone_distance(*points) - sum(arm.radius for arm in arms) <= margin:
                table[profile] = time
                break
    return table


@given(POSE, POSE)
def test_clearance_is_the_least_distance_between_the_links_less_their_radii(one, two):
    arms = [Arm(base=(-0.3, 0.1)), Arm(base=(0.3, 0.0), heading=2.0, links=(0.4, 0.5), radius=0.07)]
    expected = bone_distance(arms[0].points(one), arms[1].points(two)) - 0.12
    assert np.isclose(clearance_between(arms, one, two), expected, atol=1e-9)
    assert np.isclose(clearance_between(arms[::-1], two, one), expected, atol=1e-9)


def test_clearances_come_in_batches():
    rng = np.random.default_rng(0)
    one, two = rng.uniform(-1.0, 1.0, (2, 3, 4, 2))
    together = clearance_between(PAIR, one, two)
    assert together.shape == (3, 4)
    assert together[1, 2] == clearance_between(PAIR, one[1, 2], two[1, 2])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("stride", [0.1, 0.8])
def test_tables_are_those_of_going_through_every_profile_and_instant(seed, stride):
    scene = scene_of(seed)
    arms = [scene.arms[agent] for agent in scene.agents]
    plans = [own.restrict([0, 3, 7]) for own in plans_of(scene, seed)]
    for table, margin in zip(
        contact_tables(arms, plans, stride=stride, clearance=0.02), (0.0, 0.02), strict=True
    ):
        expected = literal_table(arms, plans, stride, margin)
        assert np.array_equal(np.isinf(table), np.isinf(expected))
        assert np.allclose(table[np.isfinite(table)], expected[np.isfinite(table)])


@pytest.mark.parametrize("seed", range(10))
def test_laws_of_the_tables(seed):
    scene = scene_of(seed)
    arms = [scene.arms[agent] for agent in scene.agents]
    plans = plans_of(scene, seed)
    collision, contact = contact_tables(arms, plans)
    assert (contact <= collision).all()
    # whoever is called first
    other_way = contact_tables(arms[::-1], plans[::-1])
    assert np.array_equal(other_way[0].T, collision)
    assert np.array_equal(other_way[1].T, contact)
    # rarer looks find nothing earlier
    rarely, _ = contact_tables(arms, plans, stride=0.8)
    assert (rarely >= collision).all()
    # a table of some plans is that part of the table
    some = [own.restrict([4, 1, 7]) for own in plans]
    assert np.array_equal(contact_tables(arms, some)[0], collision[np.ix_([4, 1, 7], [4, 1, 7])])
    # nobody is looked at after the first has finished; those who both wait never meet
    ends = np.minimum.outer(*[np.where(np.arange(8) == own.static, np.inf, own.duration) for own in plans])
    assert (collision[np.isfinite(collision)] <= ends[np.isfinite(collision)] + 1e-9).all()
    assert np.isinf(contact[7, 7])
    without, same = contact_tables(arms, plans, clearance=0.0)
    assert np.array_equal(without, same)
    assert np.array_equal(without, collision)


def test_a_plan_that_ends_here_meets_nobody_but_one_that_waits_is_met():
    at = {"robot": [0.0, 0.0], "human": [1.0, 0.0]}
    ended = PlanSet("robot", [1], [0.0], [at["robot"]])
    waits = PlanSet("robot", [1], [0.0], [at["robot"]], static=0)
    comes = PlanSet("human", [2], [0.0, 4.0], [at["human"], [0.0, 0.0]])
    assert np.isinf(contact_tables(PAIR, [ended, comes])[0]).all()
    assert np.isfinite(contact_tables(PAIR, [waits, comes])[0]).all()


def test_what_makes_no_table_is_refused():
    plans = plans_of(scene_of(0), 0)
    with pytest.raises(SimulationError, match="two arms"):
        contact_tables(PAIR[:1], plans)
    with pytest.raises(SimulationError, match="stride"):
        contact_tables(PAIR, plans, stride=0.0)
    with pytest.raises(SimulationError, match="3 joints"):
        contact_tables(PAIR, [plans[0], PlanSet("human", [1], [0.0], [[0.0, 0.0, 0.0]])])
