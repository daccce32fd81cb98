"""What the human takes the robot to be about is the inference about the human, turned round."""

import numpy as np
from numpy.testing import assert_allclose

from ppinfer.goals import (
    GoalDesign,
    MentalModel,
    OnlineGoalBelief,
    infer_goals,
    infer_mental_model,
    paper_agent,
)
from ppinfer.goals.mental_model import HUMAN_RATIONALITY


def robot_log(rows=3, samples=15):
    rng = np.random.default_rng(0)
    return paper_agent(0.05).simulate(GoalDesign.random(rng, rows=rows, samples=samples), rng)


def test_the_default_is_the_paper_s_agent_and_beta_of_the_human():
    model = paper_agent()
    assert (model.dynamics, model.state_weight, model.control_weight) == ("double-integrator", 10.0, 1.0)
    assert model.rationality == HUMAN_RATIONALITY == 3e-4
    assert model.stay == 1.0


def test_the_mental_model_of_a_log_is_the_belief_about_the_robot_under_another_name():
    evidence = robot_log()
    mind = infer_mental_model(evidence)
    assert mind.random == ("robot_goal",)
    assert_allclose(mind.log_values, infer_goals(paper_agent(), evidence).log_posterior)
    other = infer_mental_model(evidence, paper_agent(0.01, stay=0.9), mode="smooth", prior=[3.0, 1.0, 1.0])
    expected = infer_goals(paper_agent(0.01, stay=0.9), evidence, mode="smooth", prior=[3.0, 1.0, 1.0])
    assert_allclose(other.log_values, expected.log_posterior)


def test_the_mental_model_at_control_rate_equals_that_of_the_log():
    evidence = robot_log()
    offline = infer_mental_model(evidence).log_values
    mind = MentalModel(dt=0.1, labels=evidence.goal_labels)
    for row in range(evidence.rows):
        begun = mind.restart(evidence.goals[row])
        assert begun.names == ("robot_goal",)
        for sample in range(15 * row, 15 * row + 15):
            now = mind.observe(
                float(evidence.time[sample]),
                evidence.position[sample],
                velocity=evidence.velocity[sample],
                control=evidence.control[sample],
            )
            assert now.axes[0].labels == evidence.goal_labels
            assert_allclose(now.log_values, offline[sample], atol=1e-9)


def test_a_mental_model_may_be_carried_to_new_goals():
    mind, belief = (
        kind(paper_agent(), dt=0.1, labels=["a", "b"]) for kind in (MentalModel, OnlineGoalBelief)
    )
    for kind in (mind, belief):
        kind.restart(np.eye(2), prior=[0.8, 0.2])
        kind.restart(np.ones((2, 2)) + np.eye(2), carry=True)
    seen = [kind.observe(0.0, np.zeros(2), velocity=np.zeros(2)) for kind in (mind, belief)]
    assert_allclose(seen[0].values, [0.8, 0.2])
    assert_allclose(seen[1].values, [0.8, 0.2])
