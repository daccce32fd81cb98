"""Fitted parameters come back from simulations with known ones."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import minimize_scalar

from ppinfer.errors import ModelError
from ppinfer.goals import Dynamics, GoalDesign, GoalKalman, GoalLQR, Heading, NearestGoal, NoisilyRational
from ppinfer.goals.fitting import LabelledEvidence, fit_goals, predictive_score


def labelled(model, *, rows=200, samples=40, seed=0):
    rng = np.random.default_rng(seed)
    design = GoalDesign.random(rng, rows=rows, samples=samples)
    evidence = model.simulate(design, rng)
    true_goal = np.repeat(design.true_goal, design.row_size)
    return LabelledEvidence(evidence, true_goal, np.full(len(true_goal), 1 / len(true_goal)))


@pytest.mark.parametrize("dynamics", ["single-integrator", "double-integrator"])
@pytest.mark.parametrize(("control_weight", "rationality"), [(5.0, 0.5), (60.0, 0.01), (0.5, 0.1)])
def test_the_likelihood_gives_back_rationality_and_control_weight(dynamics, control_weight, rationality):
    truth = GoalLQR(dynamics=dynamics, control_weight=control_weight, rationality=rationality)
    fit = fit_goals(GoalLQR(dynamics=dynamics), labelled(truth), objective="likelihood")
    assert fit.converged
    assert_allclose(fit.model.control_weight, control_weight, rtol=0.1)
    assert_allclose(fit.model.rationality, rationality, rtol=0.1)
    assert fit.model.tempering == 1.0


@pytest.mark.parametrize(("control_weight", "rationality"), [(5.0, 0.02), (60.0, 0.005)])
def test_prediction_gives_back_both_and_finds_no_need_for_tempering(control_weight, rationality):
    truth = GoalLQR(control_weight=control_weight, rationality=rationality)
    fixed = ("stay", "evidence_floor")
    fit = fit_goals(GoalLQR(), labelled(truth, rows=400), fixed=fixed)
    assert_allclose(fit.model.control_weight, control_weight, rtol=0.15)
    assert_allclose(fit.model.rationality, rationality, rtol=0.15)
    assert_allclose(fit.model.tempering, 1.0, rtol=0.2)
    assert (fit.model.stay, fit.model.evidence_floor) == (1.0, 0.0)


def test_prediction_of_goals_that_never_change_finds_that_they_stay():
    fit = fit_goals(GoalLQR(), labelled(GoalLQR(control_weight=5.0, rationality=0.02)))
    # nearly always, and not for certain: 8000 samples without a change do not rule one out
    assert 0.998 < fit.model.stay < 1.0
    assert fit.model.evidence_floor < 0.01


def test_a_fit_that_ends_at_a_bound_can_be_fitted_again():
    data = labelled(GoalLQR(control_weight=5.0, rationality=0.5), rows=20, samples=15)
    once = fit_goals(GoalLQR(), data)
    again = fit_goals(once.model, data)
    assert np.isfinite(again.value)
    for model in (GoalLQR(stay=0.0), GoalKalman(stay=1.0), Heading(concentration=0.0)):
        assert np.isfinite(fit_goals(model, data).value)


def test_where_rationality_is_fixed_tempering_is_fitted():
    data = labelled(GoalLQR(control_weight=5.0, rationality=0.02), rows=400)
    fixed = ("rationality", "control_weight", "stay", "evidence_floor")
    fit = fit_goals(GoalLQR(control_weight=5.0, rationality=0.1), data, fixed=fixed)
    assert fit.model.rationality == 0.1
    assert_allclose(fit.model.tempering, 0.2, rtol=0.15)
    other = fit_goals(GoalLQR(control_weight=5.0, tempering=0.5), data, fixed=("tempering", *fixed[1:]))
    assert other.model.tempering == 0.5
    assert_allclose(other.model.rationality, 0.04, rtol=0.15)


def test_repeated_evidence_is_tempered_by_the_number_of_repetitions():
    # every sample counted four times over: the posterior has to be tempered by a quarter to be calibrated
    truth = GoalLQR(control_weight=5.0, rationality=0.02)
    data = labelled(truth, rows=500)
    repeated = replace(truth, tempering=4.0)
    fit = fit_goals(GoalLQR(control_weight=5.0), data, fixed=("stay", "evidence_floor", "control_weight"))
    product = fit.model.rationality * fit.model.tempering
    assert_allclose(product, truth.rationality, rtol=0.15)
    assert predictive_score(fit.model, data) > predictive_score(repeated, data)


def test_a_share_of_wild_steps_asks_for_an_evidence_floor():
    data = labelled(GoalLQR(control_weight=5.0, rationality=0.05), rows=300, samples=20)
    rng = np.random.default_rng(1)
    wild = rng.random(data.evidence.samples) < 0.05
    control = np.where(wild[:, None], rng.normal(0, 200, data.evidence.control.shape), data.evidence.control)
    noisy = replace(data, evidence=replace(data.evidence, control=control))
    fit = fit_goals(GoalLQR(), noisy, fixed=("stay",))
    plain = fit_goals(GoalLQR(), noisy, fixed=("stay", "evidence_floor"))
    assert fit.model.evidence_floor > 1e-6
    assert fit.value > plain.value + 0.05


def test_the_scale_of_the_nearest_goal_comes_back():
    fit = fit_goals(NearestGoal(), labelled(NearestGoal(scale=2.0), rows=400, samples=20))
    assert_allclose(fit.model.scale, 2.0, rtol=0.1)


def test_the_concentration_of_headings_comes_back():
    fit = fit_goals(Heading(), labelled(Heading(concentration=3.0), rows=400, samples=20))
    assert_allclose(fit.model.concentration, 3.0, rtol=0.15)


def test_a_kalman_model_is_fitted_by_prediction():
    truth = GoalKalman(control_weight=5.0, rationality=0.05, measurement_noise=0.1)
    data = labelled(truth, rows=150, samples=25)
    fit = fit_goals(replace(truth, rationality=0.5), data, fixed=("stay", "control_weight"))
    assert_allclose(fit.model.rationality, 0.05, rtol=0.5)


def test_matrices_of_ones_own_leave_tempering_to_fit():
    agent = NoisilyRational.lqr(Dynamics.single_integrator(0.1), control_weight=5.0, rationality=0.02)
    data = labelled(GoalLQR(agent=agent), rows=400)
    fit = fit_goals(GoalLQR(agent=agent, tempering=0.2), data, fixed=("stay", "evidence_floor"))
    assert_allclose(fit.model.tempering, 1.0, rtol=0.2)


def test_the_predictive_optimum_is_one():
    data = labelled(NearestGoal(scale=2.0), rows=60, samples=10)
    fit = fit_goals(NearestGoal(), data)
    best = minimize_scalar(
        lambda x: -predictive_score(NearestGoal(scale=np.exp(x)), data), bracket=(0.0, 1.0)
    )
    assert_allclose(fit.value, -best.fun, atol=1e-6)


def test_what_cannot_be_fitted_is_refused():
    data = labelled(GoalLQR(), rows=2, samples=5)
    with pytest.raises(ModelError, match="nothing left to fit"):
        fit_goals(NearestGoal(), data, fixed=("scale",))
    with pytest.raises(ModelError, match="no parameter 'sclae' to hold fixed"):
        fit_goals(NearestGoal(), data, fixed=("sclae",))
    with pytest.raises(ModelError, match="likelihood objective is that of goal-lqr"):
        fit_goals(NearestGoal(), data, objective="likelihood")
    with pytest.raises(ModelError, match="both fixed"):
        fit_goals(GoalLQR(), data, objective="likelihood", fixed=("control_weight", "rationality"))
    with pytest.raises(ModelError, match="no sample has a known goal"):
        LabelledEvidence(data.evidence, data.true_goal, np.zeros(10))
    still = replace(
        data.evidence, position=np.zeros((10, 2)), control=np.zeros((10, 2)), goals=np.zeros((2, 3, 2))
    )
    with pytest.raises(ModelError, match="without any noise"):
        fit_goals(GoalLQR(), replace(data, evidence=still), objective="likelihood")
