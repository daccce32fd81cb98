"""What is simulated by known parameters gives them back."""

from __future__ import annotations

import numpy as np
import pytest

from ppinfer.errors import ModelError
from ppinfer.goals import GoalCoupled, GoalDesign, infer_goals
from ppinfer.goals.coupled import Distance, Lead, LqrMotion, Motion, Partner
from ppinfer.goals.coupled.simulation import draw_goals
from ppinfer.goals.fitting import LabelledEvidence, fit_goals, predictive_score
from ppinfer.testing.goals import check_generative_twin

from .scenes import scene


def test_motion_alone_predicts_its_own_simulations_with_calibrated_probabilities():
    plain = GoalCoupled(experts=(Motion(concentration=6.0, outliers=0.2, tempering=1.0),), stay=1.0)
    check_generative_twin(plain, np.random.default_rng(0))


def test_the_simulated_partner_goes_for_another_goal():
    rng = np.random.default_rng(1)
    design = GoalDesign.random(rng, rows=50, samples=40)
    robot = GoalCoupled().simulate(design, rng).of_partner("robot")
    nearest = robot.geometry.distance.reshape(50, 40, 3)[:, -1].argmin(axis=1)
    towards = robot.geometry.cosine.reshape(50, 40, 3)[:, 1].argmax(axis=1)
    assert (towards != design.true_goal).all()
    assert (nearest != design.true_goal).mean() > 0.8


def test_goals_drawn_from_the_product_give_its_parameters_back():
    rng = np.random.default_rng(2)
    truth = GoalCoupled(
        experts=(
            Motion(concentration=8.0, half_speed=2.0, outliers=0.05, tempering=0.5),
            Distance(weight=0.4),
            Lead(weight=0.3, cap=3.0),
            Partner(distance=0.6, closing=0.3),
        ),
        stay=0.7,
    )
    evidence = scene(rng, rows=300, samples=40)
    drawn = draw_goals(truth, evidence, rng)
    data = LabelledEvidence(evidence, drawn, np.full(len(drawn), 1 / len(drawn)))
    held = ("motion.concentration", "motion.half_speed", "motion.outliers", "lead.cap")
    begin = truth.with_parameters(
        **{"stay": 0.9, "motion.tempering": 0.2, "distance.weight": 0.1, "lead.weight": 0.1},
        **{"partner.distance": 0.2, "partner.closing": 0.0},
    )
    fit = fit_goals(begin, data, fixed=held)
    assert fit.converged
    assert fit.value >= predictive_score(truth, data)
    found, expected = fit.model.parameters, truth.parameters
    for name, tolerance in (
        ("stay", 0.08),
        ("motion.tempering", 0.1),
        ("distance.weight", 0.06),
        ("lead.weight", 0.06),
        ("partner.distance", 0.1),
        ("partner.closing", 0.1),
    ):
        assert found[name] == pytest.approx(expected[name], abs=tolerance), name
    assert all(found[name] == expected[name] for name in held)


def labelled(evidence, drawn):
    return LabelledEvidence(evidence, drawn, np.full(len(drawn), 1 / len(drawn)))


def test_a_fit_does_not_depend_on_the_order_of_the_data():
    rng = np.random.default_rng(4)
    evidence = scene(rng, rows=60, samples=20)
    drawn = draw_goals(GoalCoupled(), evidence, rng)
    order = rng.permutation(60)
    # rows of the scene are of one length
    other = labelled(evidence.take_rows(order), drawn.reshape(60, -1)[order].ravel())
    one, again = fit_goals(GoalCoupled(), labelled(evidence, drawn)), fit_goals(GoalCoupled(), other)
    assert one.value == pytest.approx(again.value, abs=1e-6)
    found, expected = again.model.parameters, one.model.parameters
    for name in one.model.parameter_scales:
        assert found[name] == pytest.approx(expected[name], rel=2e-3, abs=1e-4), name


def test_a_few_segments_drive_no_parameter_to_its_bounds():
    rng = np.random.default_rng(5)
    evidence = scene(rng, rows=4, samples=12)
    drawn = draw_goals(GoalCoupled(), evidence, rng)
    fit = fit_goals(GoalCoupled(), labelled(evidence, drawn))
    assert not fit.at_bound
    unseen = scene(rng, rows=200, samples=12)
    score = predictive_score(fit.model, labelled(unseen, draw_goals(GoalCoupled(), unseen, rng)))
    assert score > np.log(1 / len(unseen.goal_labels)) - 0.5


def test_the_noisily_rational_agent_may_be_the_one_that_moves():
    rng = np.random.default_rng(3)
    model = GoalCoupled(experts=(LqrMotion(5.0, 0.5, 0.0), Partner()), stay=1.0)
    design = GoalDesign.random(rng, rows=40, samples=20)
    belief = infer_goals(model, model.simulate(design, rng)).log_posterior.reshape(40, 20, 3)
    assert (belief[:, -1].argmax(axis=1) == design.true_goal).mean() > 0.9


def test_a_product_without_motion_simulates_none():
    rng = np.random.default_rng(4)
    with pytest.raises(ModelError, match="simulates with a motion expert"):
        GoalCoupled(experts=(Distance(),)).simulate(GoalDesign.random(rng, rows=1), rng)
