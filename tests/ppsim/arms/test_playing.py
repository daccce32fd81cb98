from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from ppinfer.coordination import BayesRisk, CommittedNormNash, Decision, NormNash, Policy, Selfish
from ppinfer.distributions import Axis, Distribution
from ppsim.arms import playing
from ppsim.arms.execution import Execution
from ppsim.arms.playing import play
from ppsim.arms.scene import Scene
from ppsim.arms.world import STEP, ArmsWorld
from ppsim.errors import SimulationError

# a scene in which the two are in each other's way
SEED = 7


@dataclass(frozen=True)
class Shortest(Policy):
    """Takes its shortest plan, whatever is in the way."""

    samples: int = 3

    def decide(self, situation, ego, memory=None):
        own = situation.plans[situation.player(ego)]
        plan = int(np.argmin(own.cost))
        point = np.zeros(len(own))
        point[plan] = 1.0
        return Decision(plan, Distribution.from_probabilities([own.axis], point), memory=(memory or 0) + 1)


def decision_on(plan):
    """Return a decision that nobody has checked: types are checked while tests run, and not for users."""
    decision = Decision(0, Distribution.uniform(Axis("human_plan", 8)))
    object.__setattr__(decision, "plan", plan)
    return decision


def scene(number=0):
    return Scene.random(np.random.default_rng(number))


def played(robot=None, human=None, *, number=0, **options):
    policies = {"robot": robot or NormNash(), "human": human or Selfish()}
    return play(scene(number), policies, seed=SEED + number, **options)


def assert_same(one, other):
    for name in ("position", "velocity", "held", "finish_time"):
        assert_array_equal(getattr(one, name), getattr(other, name))
    for first, second in zip(one.replans, other.replans, strict=True):
        assert first.sample == second.sample
        assert first.decision.plan == second.decision.plan
        assert_array_equal(first.situation.game.costs, second.situation.game.costs)


@pytest.mark.parametrize("plan_sets", ["shared", "independent"])
def test_the_same_seed_gives_the_same_trial(plan_sets):
    robot = BayesRisk() if plan_sets == "independent" else NormNash()
    assert_same(played(robot, plan_sets=plan_sets), played(robot, plan_sets=plan_sets))


def test_arms_graze_at_most(monkeypatch):
    least = []

    class Watched(ArmsWorld):
        def step(self, actions):
            seen = super().step(actions)
            least.append(self.clearance())
            return seen

    monkeypatch.setattr(playing, "ArmsWorld", Watched)
    for number in range(8):
        played(Selfish(), number=number)
    assert min(least) > -1e-3


def test_both_finish_and_leave():
    for number in range(6):
        one = played(Selfish(), number=number)
        assert np.isfinite(one.finish_time).all()
        for agent, when in enumerate(one.finish_time):
            last = round(when / STEP)
            # it leaves when it has finished
            assert np.isfinite(one.position[:last, agent]).all()
            assert np.isnan(one.position[last + 1 :, agent]).all()
        assert len(one.held) - 1 == round(one.finish_time.max() / STEP)


def test_an_arm_is_at_its_pick_before_it_finishes_at_its_place():
    one, where = played(number=2), scene(2)
    for at, agent in enumerate(where.agents):
        task, arm = where.tasks[agent], where.arms[agent]
        last = round(one.finish_time[at] / STEP)
        tip = arm.end_effector(one.position[:last, at])
        assert np.linalg.norm(tip - task.pick, axis=1).min() < 0.011
        assert np.linalg.norm(tip[-1] - task.place) < 0.06


def test_joints_keep_to_their_speed():
    one = played(number=1)
    speed = np.abs(np.diff(one.position, axis=0)) / STEP
    assert np.nanmax(speed) < 0.25 * 1.01


def test_every_robot_begins_with_the_same_plans():
    norm, selfish = played(NormNash()).replans[0], played(Selfish()).replans[0]
    assert_array_equal(norm.situation.game.costs, selfish.situation.game.costs)
    for one, other in zip(norm.situation.plans, selfish.situation.plans, strict=True):
        assert_array_equal(one.position, other.position)


def test_a_robot_that_looks_at_more_plans_sees_those_that_the_others_see_first():
    few, many = played(NormNash()).replans[0].situation, played(BayesRisk()).replans[0].situation
    assert [len(one) for one in many.plans] == [25, 25]
    for one, other in zip(few.plans, many.plans, strict=True):
        assert_array_equal(one.duration[:7], other.duration[:7])


def test_replans_come_every_eight_steps_and_after_every_safety_stop():
    one = played(Shortest(), Shortest(), number=4)
    assert one.stops > 0
    samples = [replan.sample for replan in one.replans]
    active = round(one.finish_time[0] / STEP)
    for first, second in pairwise(samples):
        assert second - first <= 8 or one.held[first + 1 : second].any()
        if second - first < 8:
            assert one.held[second]
    assert samples[-1] < active


def test_held_steps_move_nobody_and_are_counted_once_each():
    one = played(Shortest(), Shortest(), number=4)
    assert one.stops == one.held.sum() > 0
    moved = np.nanmax(np.abs(np.diff(one.position, axis=0)), axis=(1, 2))
    assert moved[one.held[1:]].max() < 1e-3
    when = np.flatnonzero(one.held)
    assert one.stop_episodes == 1 + (np.diff(when) > 8).sum()


def test_a_standoff_ends_with_somebody_going_home():
    one = played(Shortest(), Shortest(), number=4)
    run = longest = 0
    for held in one.held:
        run = run + 1 if held else 0
        longest = max(longest, run)
    assert longest >= 5
    assert np.isfinite(one.finish_time).all()


def test_the_motion_that_a_policy_is_told_is_that_since_its_last_replan():
    one = played(number=3)
    assert one.replans[0].situation.motion is None
    for before, after in pairwise(one.replans):
        motion = after.situation.motion
        assert_array_equal(motion.position, one.position[before.sample : after.sample + 1])
        assert not motion.held[0]
        assert_array_equal(motion.held[1:], one.held[before.sample + 1 : after.sample + 1])


def test_a_committed_robot_sees_the_rest_of_its_plan_where_it_would_be_by_now():
    one = played(CommittedNormNash(), number=5)
    assert one.replans[0].situation.plans[0].committed is None
    for before, after in pairwise(one.replans):
        own = after.situation.plans[0]
        if before.decision.plan == before.situation.plans[0].static or own.committed is None:
            continue
        if after.sample - before.sample != 8 or one.held[before.sample + 1 : after.sample + 1].any():
            continue
        left = before.situation.plans[0].duration[before.decision.plan] - 0.8
        assert_allclose(own.duration[own.committed], left, atol=1e-9)


def test_memory_travels_from_decision_to_decision():
    one = played(Shortest(), number=1)
    assert [replan.decision.memory for replan in one.replans] == list(range(1, len(one.replans) + 1))


def test_who_does_not_finish_in_time_has_no_time_of_finishing():
    one = played(execution=Execution(timeout=1.0))
    assert np.isnan(one.finish_time).all()
    assert len(one.held) == 11


def test_the_stride_changes_which_profiles_collide():
    fine, coarse = (
        played(number=4, execution=Execution(collision_stride=stride)).replans[0].situation
        for stride in (0.1, 0.8)
    )
    assert np.isinf(coarse.game.costs).sum() <= np.isinf(fine.game.costs).sum()
    # contacts are told at the same instants as collisions are looked for
    finite = coarse.contact_time[np.isfinite(coarse.contact_time)]
    assert_allclose(finite / 0.8, np.round(finite / 0.8), atol=1e-9)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"plan_sets": "both"}, "plan sets are shared or independent; got 'both'"),
    ],
)
def test_what_cannot_be_played_is_refused(options, told):
    with pytest.raises(SimulationError, match=told):
        played(**options)


def test_a_plan_that_is_not_there_is_refused():
    @dataclass(frozen=True)
    class Beyond(Shortest):
        def decide(self, situation, ego, memory=None):
            return replace(super().decide(situation, ego, memory), plan=99)

    with pytest.raises(SimulationError, match=r"'custom' of robot.*decided on plan 99; there are 4"):
        played(Beyond(), Shortest())


@pytest.mark.parametrize(
    ("made", "told"),
    [
        (lambda: 3, "policy 'odd' of human, 0.0 s into the trial: returned a int; expected a Decision"),
        (
            lambda: decision_on("static"),
            "policy 'odd' of human, 0.0 s into the trial: decided on plan 'static'; there are 8",
        ),
        (lambda: {}["plan"], "policy 'odd' of human, 0.0 s into the trial: raised KeyError: 'plan'"),
    ],
)
def test_a_policy_that_fails_is_named(made, told):
    class Odd(Policy):
        name = "odd"

        def decide(self, situation, ego, memory=None):
            return made()

    with pytest.raises(SimulationError, match=told):
        played(Shortest(), Odd())


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"collision_stride": 0.05}, "collision_stride must be a positive multiple of 0.1 s"),
        ({"replan_every": 0.0}, "replan_every must be a positive multiple"),
        ({"clearance": -1.0}, "clearance must lie in"),
        ({"stops_in_a_row": 0}, "stops_in_a_row must be at least 1"),
        ({"planner": "RRTX"}, "there is no planner 'RRTX'"),
    ],
)
def test_an_execution_out_of_range_is_refused(values, told):
    with pytest.raises(SimulationError, match=told):
        Execution(**values)
