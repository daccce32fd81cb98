"""Whether an arm's plan stays clear: against the table of contacts, and in the policy that asks first."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from ppinfer import Axis, Distribution
from ppinfer.coordination import BayesNash, BayesRisk, NormNash, PlanSet, Situation
from ppinfer.errors import ModelError
from ppinfer.safety.clearance import PlanBodies
from ppsim.arms import ARMS, ArmsStudy, contact_tables, play
from ppsim.arms.careful import Careful
from ppsim.arms.clearance import arm_bodies, believed_plans, plan_clearance
from ppsim.arms.robots import make_human, make_robot
from ppsim.errors import SimulationError

from .situations import plans_of, scene_of


def situation_of(seed, count=7, clearance=0.01):
    """Return the first replan of a random scene."""
    scene = scene_of(seed)
    plans = plans_of(scene, seed, count)
    collision, contact = contact_tables(
        [scene.arms[agent] for agent in scene.agents], plans, clearance=clearance
    )
    return Situation.from_contacts(plans, collision, contact_time=contact, seed=seed), collision, contact


@pytest.mark.parametrize("ego", ["robot", "human"])
@pytest.mark.parametrize("seed", range(12))
def test_it_is_the_belief_in_plans_that_the_table_of_contacts_lets_pass(seed, ego):
    situation, collision, contact = situation_of(seed, clearance=0.03)
    player = situation.player(ego)
    rng = np.random.default_rng(seed)
    belief = rng.dirichlet(np.full(collision.shape[1 - player], 0.3))
    for margin, table in ((0.0, collision), (0.03, contact)):
        free = np.moveaxis(np.isinf(table), player, 0) @ belief
        assert_allclose(plan_clearance(situation, ego, belief, margin=margin).clear, free, atol=1e-9)
        # and up to a horizon, the contacts before it
        soon = np.moveaxis(table > 2.4 + 1e-9, player, 0) @ belief
        found = plan_clearance(situation, ego, belief, margin=margin, horizon=2.4, plans=[0, 7])
        assert_allclose(found.clear, soon[[0, 7]], atol=1e-9)


def test_bodies_follow_the_arms_links_and_leave_with_their_plans():
    plans = plans_of(scene_of(3), 3)[0]
    bodies = arm_bodies(ARMS["robot"], plans)
    assert_allclose(
        bodies.ends[2, 9, :, 1], ARMS["robot"].points(plans.positions([1.0])[2, 0])[1:], atol=1e-12
    )
    assert bodies.steps[plans.static] == bodies.ends.shape[1]
    assert_allclose(bodies.steps[: plans.static] * 0.1, plans.duration[: plans.static], atol=1e-9)


def test_who_has_finished_is_in_nobodys_way():
    situation, _, _ = situation_of(0)
    gone = PlanSet.holding("human", situation.plans[0].position[0])
    alone = Situation.from_contacts([situation.plans[0], gone], np.full((8, 1), np.inf))
    assert_array_equal(plan_clearance(alone, "robot", [1.0]).clear, np.ones(8))


def test_obstacles_and_noise_make_plans_less_clear():
    situation, _, _ = situation_of(1)
    belief = np.full(8, 1 / 8)
    clear = plan_clearance(situation, "robot", belief, horizon=2.0).clear
    wall = PlanBodies.still([[[-0.2, -1.0], [-0.2, 1.0]]], 0.01, steps=20)
    walled = plan_clearance(situation, "robot", belief, horizon=2.0, obstacles=wall).clear
    assert (walled <= clear).all()
    assert walled.min() == 0.0
    one, two = (
        plan_clearance(situation, "robot", belief, horizon=2.0, noise=0.5, rollouts=200).clear
        for _ in range(2)
    )
    assert_array_equal(one, two)
    assert one.max() < 1.0


def test_a_belief_over_theta_becomes_one_over_plans():
    situation, _, _ = situation_of(2)
    belief = Distribution.from_probabilities([Axis("theta", situation.agents)], [0.3, 0.7])
    expected = believed_plans(situation, "robot", belief)
    assert expected.random == ("human_plan",)
    with pytest.raises(ModelError, match="theta"):
        believed_plans(situation, "robot", expected)
    with pytest.raises(SimulationError, match="two agents"):
        plan_clearance(situation, "robot", expected, arms={"robot": ARMS["robot"]})
    with pytest.raises(SimulationError, match="stride"):
        arm_bodies(ARMS["robot"], situation.plans[0], stride=0.0)


@pytest.mark.parametrize("policy", [BayesNash(), BayesRisk()], ids=["bayes", "bayes-risk"])
def test_a_careful_policy_does_what_the_policy_wants_where_that_is_clear_enough_and_else_what_is(policy):
    grounds = set()
    for seed in range(25):
        situation, _, _ = situation_of(seed)
        careful = Careful(policy, eps=0.02, margin=0.1, horizon=30.0)
        wanted, decision = policy.decide(situation, "robot"), careful.decide(situation, "robot")
        clear = plan_clearance(situation, "robot", decision.predictive, margin=0.1, horizon=30.0).clear
        enough = clear >= 0.98 - 1e-9
        grounds.add(decision.ground)
        assert decision.wanted == wanted.plan
        assert_allclose(decision.clear[decision.plan], clear[decision.plan], atol=1e-12)
        if enough[wanted.plan]:
            assert (decision.plan, decision.profile, decision.ground) == (
                wanted.plan,
                wanted.profile,
                "clear",
            )
        elif enough.any():
            assert enough[decision.plan]
            assert (decision.profile, decision.ground) == (None, "clear instead")
        else:
            assert clear[decision.plan] == pytest.approx(clear.max())
            assert decision.ground == "clearest"
        assert_array_equal(decision.belief.values, wanted.belief.values)
    assert {"clear", "clear instead"} <= grounds


def test_careful_robots_are_played_and_logged_by_name():
    study = ArmsStudy(scenes=1, robots=("bayes-clear", "bayes-risk-clear"), humans=("selfish",), seed=4)
    trial = study.trial(1)
    assert trial.controller["robot"] == "bayes-risk-clear"
    assert trial.outcome == "completed"
    human = make_human("selfish")
    robot = make_robot("bayes-clear", human, cost_unit=1.0)
    assert robot.policy.norm.cost_unit == 1.0
    assert robot.belief_model() == robot.policy.belief_model()
    played = play(scene_of(5), {"robot": robot, "human": human}, seed=5)
    assert {replan.decision.ground for replan in played.replans} <= {"clear", "clear instead", "clearest"}


def test_a_policy_without_a_belief_and_parameters_out_of_range_are_refused():
    situation, _, _ = situation_of(0)
    with pytest.raises(SimulationError, match="holds no belief"):
        Careful(NormNash()).decide(situation, "robot")
    for wrong in ({"eps": 1.0}, {"eps": -0.1}, {"margin": np.inf}, {"horizon": 0.0}):
        with pytest.raises(SimulationError, match="horizon"):
            Careful(BayesNash(), **wrong)
