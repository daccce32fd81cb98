"""Histories of play: there and back, several views, and what does not fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from jaxtyping import TypeCheckError

from ppinfer.coordination import BayesNash, Personality, PlayHistory, infer_personality
from ppinfer.errors import ModelError
from ppinfer.testing import example_trial, play_trials


def same(one, other):
    """Whether two situations are alike in every number."""
    assert one.game == other.game
    assert (one.time, one.seed, one.agents) == (other.time, other.seed, other.agents)
    np.testing.assert_array_equal(one.contact_time, other.contact_time)
    for plans, again in zip(one.plans, other.plans, strict=True):
        assert (plans.static, plans.committed) == (again.static, again.committed)
        for name in ("row_size", "time", "position"):
            np.testing.assert_array_equal(getattr(plans, name), getattr(again, name))
    assert (one.motion is None) == (other.motion is None)
    if one.motion is not None:
        for name in ("position", "velocity", "held"):
            np.testing.assert_array_equal(getattr(one.motion, name), getattr(other.motion, name))


@settings(max_examples=25)
@given(play_trials())
def test_a_situation_comes_back_as_it_was_seen(trial):
    history = PlayHistory.from_situations([trial, trial[:1], trial], "human")
    for row, replans in enumerate((trial, trial[:1], trial)):
        for place, situation in enumerate(replans):
            same(history.situation(row, place), situation)


def test_a_live_policy_can_be_run_again_from_a_history():
    trial = example_trial(np.random.default_rng(0), replans=5)
    history = PlayHistory.from_situations([trial], "robot")
    policy, live, again = BayesNash(), None, None
    for place, situation in enumerate(trial):
        live = policy.decide(situation, "robot", None if live is None else live.memory)
        again = policy.decide(history.situation(0, place), "robot", None if again is None else again.memory)
        assert live.profile == again.profile
        assert live.distribution == again.distribution


def interleaved(robot, human):
    """Return one history of two views of the same motion, replan by replan."""
    parts = [
        PlayHistory.from_situations([[first, second]], ego)
        for ego, (first, second) in (("robot", robot), ("human", human))
    ]
    one, two = parts
    order = np.array([0, 2, 1, 3])
    plan_of = np.repeat(np.arange(4), np.concatenate([p.plan_row_size.sum(axis=1) for p in parts]))
    sizes = np.concatenate([p.waypoint_row_size for p in parts])
    way_of = np.repeat(plan_of, sizes)
    profile_of = np.repeat(np.arange(4), np.concatenate([p.plan_row_size.prod(axis=1) for p in parts]))

    def arranged(values, of):
        return np.concatenate([values[of == replan] for replan in order])

    def joined(name):
        return np.concatenate([getattr(p, name) for p in parts])

    return replace(
        one,
        replan_row_size=np.array([4]),
        **{
            name: joined(name)[order]
            for name in (
                "replan_sample", "replan_time", "replan_agent", "replan_seed", "plan_row_size", "static_plan",
                "committed_plan",
            )
        },
        waypoint_row_size=arranged(joined("waypoint_row_size"), plan_of),
        waypoint_time=arranged(joined("waypoint_time"), way_of),
        waypoint_position=arranged(joined("waypoint_position"), way_of),
        cost=arranged(joined("cost"), profile_of),
        contact_time=arranged(joined("contact_time"), profile_of),
    ), two  # fmt: skip


def test_each_agent_infers_from_its_own_view_of_the_same_motion():
    robot = example_trial(np.random.default_rng(0), replans=2, plans=(5, 4), colliding=0.6, held=0.0)
    human = example_trial(np.random.default_rng(1), replans=2, plans=(3, 5), colliding=0.6, held=0.0)
    human[1] = replace(human[1], motion=robot[1].motion, time=robot[1].time)
    both, _ = interleaved(robot, human)
    for ego, alone, places in (("robot", robot, [0, 2]), ("human", human, [1, 3])):
        found = infer_personality(Personality(), both, ego)
        expected = infer_personality(Personality(), PlayHistory.from_situations([alone], ego), ego)
        np.testing.assert_allclose(found.values, expected.values, rtol=1e-12)
        assert [int(label) for label in found.axis("replan").labels] == places
    same(both.situation(0, 3), human[1])


def test_trials_without_a_replan_of_the_ego_are_left_out():
    trial = example_trial(np.random.default_rng(0), replans=3)
    history = PlayHistory.from_situations([trial, trial], "robot")
    theirs = history.replan_agent.copy()
    theirs[:3] = "human"
    mixed = replace(history, replan_agent=theirs)
    assert infer_personality(Personality(), mixed, "robot").axis("replan").labels == range(3, 6)
    with pytest.raises(ModelError, match="there is no agent 'guest'"):
        infer_personality(Personality(), mixed, "guest")
    with pytest.raises(ModelError, match="no replan in this history is 'human'"):
        infer_personality(Personality(), history, "human")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"row_size": np.array([3])}, "row_size sums to 3"),
        ({"replan_time": np.zeros(1)}, "replan_time has shape"),
        ({"cost": np.zeros((3, 2))}, "product of plan_row_size"),
        ({"replan_sample": np.array([0, 99])}, "outside its trial"),
    ],
)
def test_arrays_that_do_not_fit_are_refused_by_name(change, says):
    trial = example_trial(np.random.default_rng(0), replans=2, plans=(2, 2))
    with pytest.raises((ModelError, TypeCheckError), match=rf"{says}|Type-check"):
        replace(PlayHistory.from_situations([trial], "robot"), **change)


def test_there_is_no_replan_beyond_the_last():
    history = PlayHistory.from_situations([example_trial(np.random.default_rng(0), replans=2)], "robot")
    for place in ((0, 2), (1, 0), (-1, 0)):
        with pytest.raises(ModelError, match="there is no replan"):
            history.situation(*place)
