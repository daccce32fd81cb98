"""The belief half of Algorithm 1 at control rate: beliefs as offline, states as seen, histories as asked for."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ppinfer.errors import LogError, ModelError
from ppinfer.goals import (
    BehaviourPredictor,
    Dynamics,
    GoalAndRationality,
    GoalCoupled,
    GoalDesign,
    GoalLQR,
    Heading,
    NearestGoal,
    PartnerMotion,
    SoftmaxConditional,
    infer_goals,
    infer_mental_model,
    overall_post,
    paper_agent,
)
from ppinfer.goals.choice import CHOOSERS

LABELS = ("cup", "bowl", "plate")
STILL = np.zeros(2)


def two_agents(samples=20):
    """Return motion of the human and of the robot among the same goals."""
    rng = np.random.default_rng(3)
    design = GoalDesign.random(rng, rows=1, samples=samples)
    return [paper_agent(beta).simulate(design, rng) for beta in (1e-3, 1e-2)]


def steps(predictor, human, robot, *, controls=True):
    predictor.restart(human.goals[0])
    for sample in range(human.samples):
        yield predictor.observe(
            float(human.time[sample]),
            human.position[sample],
            human.velocity[sample],
            robot.position[sample],
            robot.velocity[sample],
            sample % 3,
            human.control[sample] if controls else None,
            robot.control[sample] if controls else None,
        )


@pytest.mark.parametrize("model", [None, GoalLQR(rationality=0.1), NearestGoal(), Heading()])
def test_beliefs_equal_those_of_the_log_at_every_step(model):
    human, robot = two_agents()
    believed = infer_goals(model or paper_agent(), human).log_posterior
    mind = infer_mental_model(robot, paper_agent(1e-3)).log_values
    predictor = BehaviourPredictor(model, paper_agent(1e-3), dt=0.1, labels=LABELS)
    for sample, situation in enumerate(steps(predictor, human, robot)):
        assert_allclose(situation.belief.log_values, believed[sample], atol=1e-9)
        assert_allclose(situation.mental_model.log_values, mind[sample], atol=1e-9)
        assert situation.previous == sample % 3
        assert situation.labels == LABELS
        assert situation.rationality_belief is None


@pytest.mark.parametrize("given", ["rationalities", "model"])
def test_with_rationalities_the_belief_is_the_marginal_of_the_joint_one(given):
    human, robot = two_agents()
    joint = GoalAndRationality(rationalities=(1e-4, 1e-3))
    offline = joint.infer(human)
    predictor = (
        BehaviourPredictor(joint, dt=0.1, labels=LABELS)
        if given == "model"
        else BehaviourPredictor(dt=0.1, labels=LABELS, rationalities=(1e-4, 1e-3))
    )
    for sample, situation in enumerate(steps(predictor, human, robot)):
        assert_allclose(np.exp(situation.rationality_belief.log_values), offline.values[sample], atol=1e-9)
        assert_allclose(situation.belief.values, offline.marginal("goal").values[sample], atol=1e-9)


def test_every_chooser_chooses_from_what_is_predicted():
    human, robot = two_agents(samples=6)
    predictor = BehaviourPredictor(dt=0.1, labels=LABELS, rationalities=(5e-6, 5e-5, 5e-3))
    for situation in steps(predictor, human, robot, controls=False):
        for chooser in CHOOSERS.values():
            decision = chooser().choose(situation)
            assert decision.goal in (None, 0, 1, 2)
        overall = overall_post(SoftmaxConditional().post(situation), situation.mental_model)
        assert_allclose(overall.values.sum(), 1.0)


def test_states_hold_positions_and_velocities_where_the_dynamics_have_them():
    predictor = BehaviourPredictor(dt=0.1, labels=LABELS)
    predictor.restart(np.eye(3, 2))
    first = predictor.observe(
        0.0, np.array([1.0, 2.0]), None, np.array([3.0, 4.0]), np.array([5.0, 6.0]), None
    )
    assert_allclose(first.human, [1.0, 0.0, 2.0, 0.0])
    assert_allclose(first.robot, [3.0, 5.0, 4.0, 6.0])
    second = predictor.observe(0.5, np.array([2.0, 2.0]), None, np.array([3.0, 4.0]), None, None)
    assert_allclose(second.human, [2.0, 2.0, 2.0, 0.0])
    assert_allclose(second.human_position, [2.0, 2.0])
    walking = BehaviourPredictor(
        GoalLQR(), GoalLQR(), dt=0.1, labels=LABELS, dynamics=Dynamics.single_integrator(0.1)
    )
    walking.restart(np.eye(3, 2))
    assert_allclose(walking.observe(0.0, np.ones(2), None, STILL, None, None).human, [1.0, 1.0])


def test_histories_are_as_long_as_asked_for_and_end_with_now():
    human, robot = two_agents(samples=7)
    predictor = BehaviourPredictor(dt=0.1, labels=LABELS, history=3)
    for sample, situation in enumerate(steps(predictor, human, robot)):
        assert situation.human_history.shape == (min(sample + 1, 3), 4)
        assert_allclose(situation.human_history[-1], situation.human)
        assert_allclose(situation.robot_history[-1], situation.robot)
        assert_allclose(situation.robot_history[0, [0, 2]], robot.position[max(0, sample - 2)])
    predictor.restart(human.goals[0], keep_history=True)
    assert len(predictor.observe(0.0, STILL, STILL, STILL, STILL, None).human_history) == 3
    predictor.restart(human.goals[0])
    assert len(predictor.observe(0.0, STILL, STILL, STILL, STILL, None).human_history) == 1
    without = BehaviourPredictor(dt=0.1, labels=LABELS)
    assert next(steps(without, human, robot)).human_history is None


def test_a_human_out_of_sight_is_where_they_were():
    human, robot = two_agents(samples=3)
    predictor = BehaviourPredictor(dt=0.1, labels=LABELS, history=5)
    *_, seen = steps(predictor, human, robot)
    lost = predictor.observe(0.3, None, None, STILL, STILL, 0)
    assert_allclose(lost.human, seen.human)
    assert_allclose(lost.belief.values, seen.belief.values)
    assert len(lost.human_history) == 4


def test_goals_that_are_absent_stay_so():
    predictor = BehaviourPredictor(dt=0.1, labels=LABELS)
    goals = np.array([[1.0, 0.0], [np.nan, np.nan], [0.0, 3.0]])
    predictor.restart(goals, present=np.array([True, False, True]))
    situation = predictor.observe(0.0, STILL, STILL, np.ones(2), STILL, None)
    assert situation.belief.values[1] == situation.mental_model.values[1] == 0.0
    for name in ("naive", "courtesy", "influence", "expected-cost"):
        decision = CHOOSERS[name]().choose(situation)
        assert decision.score[1] == np.inf
        assert (decision.post.values[:, 1] == 0).all()
    predictor.restart(np.eye(3, 2), present=np.ones(3, dtype=bool))
    assert predictor.observe(0.0, STILL, STILL, STILL, STILL, None).present is None


def test_beliefs_may_start_from_a_prior_or_be_carried():
    predictor = BehaviourPredictor(dt=0.1, labels=LABELS)
    predictor.restart(np.eye(3, 2), prior=[1.0, 2.0, 1.0])
    begun = predictor.observe(0.0, STILL, STILL, STILL, STILL, None)
    assert_allclose(begun.belief.values, [0.25, 0.5, 0.25])
    assert_allclose(begun.mental_model.values, np.full(3, 1 / 3))
    predictor.restart(np.eye(3, 2), carry=True)
    assert_allclose(predictor.observe(0.0, STILL, STILL, STILL, STILL, None).belief.values, [0.25, 0.5, 0.25])


def test_a_predictor_says_what_it_lacks():
    predictor = BehaviourPredictor(dt=0.1, labels=LABELS)
    with pytest.raises(LogError, match="restart"):
        predictor.observe(0.0, STILL, STILL, STILL, STILL, None)
    predictor.restart(np.eye(3, 2))
    with pytest.raises(LogError, match="not seen yet"):
        predictor.observe(0.0, None, None, STILL, STILL, None)
    with pytest.raises(ModelError, match="previous"):
        predictor.observe(0.1, STILL, STILL, STILL, STILL, 3)
    with pytest.raises(ModelError, match="history"):
        BehaviourPredictor(dt=0.1, labels=LABELS, history=-1)
    with pytest.raises(ModelError, match="GoalLQR only"):
        BehaviourPredictor(NearestGoal(), dt=0.1, labels=LABELS, rationalities=(1.0, 2.0))


def test_a_model_that_looks_at_partners_is_shown_the_robot():
    human, robot = two_agents()
    shown = replace(
        human, partners=(PartnerMotion("robot", robot.position, robot.seen, robot.velocity, robot.control),)
    )
    believed = infer_goals(GoalCoupled(), shown).log_posterior
    predictor = BehaviourPredictor(GoalCoupled(), dt=0.1, labels=LABELS)
    for sample, situation in enumerate(steps(predictor, human, robot)):
        assert_allclose(situation.belief.log_values, believed[sample], atol=1e-9)


def test_an_instant_at_which_goals_are_new_can_be_looked_at_twice():
    predictor = BehaviourPredictor(dt=0.1, labels=["cup", "bowl"])
    predictor.restart(np.eye(2))
    for step in range(2):
        first = predictor.observe(0.1 * step, np.array([0.2 * step, 0.0]), None, np.zeros(2), None, None)
    predictor.restart(2 * np.eye(2), keep_history=True)
    again = predictor.observe(0.1, np.array([0.2, 0.0]), None, np.zeros(2), None, None)
    np.testing.assert_allclose(again.human, [0.2, 2.0, 0.0, 0.0])
    np.testing.assert_array_equal(again.human, first.human)
