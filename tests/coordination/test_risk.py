from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ppinfer import Axis, Distribution
from ppinfer.coordination import (
    BayesRisk,
    MinNorm,
    Motion,
    PlanPrediction,
    PlanSet,
    PredictivePersonality,
    Situation,
    coordination_equilibria,
)
from ppinfer.errors import ModelError
from ppinfer.testing import check_personality, check_policy

from .test_prediction import plan_set, random_situation

FEW = PredictivePersonality(prediction=PlanPrediction(games=4, plans=2))


def test_bayes_risk_obeys_the_laws_of_policies():
    check_policy(BayesRisk(personality=FEW), examples=15, agents=(2,), relabelling=False)


def test_the_predictive_personality_is_the_same_online_and_offline_and_recovers_its_own_truth():
    check_personality(FEW, examples=10, agents=(2,), relabelling=False)


def test_risk_is_the_expected_and_fading_danger_of_contact():
    situation = random_situation(3)
    policy = BayesRisk(sure_until=0.9, fade=4.0)
    predictive = Distribution.from_probabilities(
        [situation.game.plans[1]], np.random.default_rng(0).dirichlet(np.ones(6))
    )
    by_hand = [
        sum(
            p * (1.0 if t <= 0.9 else np.exp(-(t - 0.9) / 4.0))
            for p, t in zip(predictive.values, row, strict=True)
        )
        for row in situation.contact_time
    ]
    assert_allclose(policy.risk(situation, "robot", predictive), by_hand, atol=1e-14)


def test_the_distribution_is_norm_times_personality_less_risk_and_delay():
    situation = random_situation(11, own=4, other=4)
    policy = BayesRisk(personality=FEW, norm=MinNorm(rationality=0.7), risk_weight=3.0, delay_weight=0.2)
    decision = policy.decide(situation, "robot")
    among = coordination_equilibria(situation.game).values > 0
    robot, human = situation.game.costs
    belief = decision.belief.values
    favour = np.stack([robot <= human, human <= robot]) & among
    sizes = favour.sum(axis=(1, 2))
    p_alpha = sum(
        belief[theta] / belief[sizes > 0].sum() * favour[theta] / sizes[theta]
        for theta in range(2)
        if sizes[theta]
    )
    risk = policy.risk(situation, "robot", decision.predictive)
    with np.errstate(divide="ignore", invalid="ignore"):
        score = (
            -0.7 * np.minimum(robot, human)
            + np.log(p_alpha)
            - 3.0 * risk[:, None]
            - 0.2 * (robot - robot[among].min())
        )
    expected = np.where(among, np.exp(np.where(among, score, 0.0)), 0.0)
    assert_allclose(decision.distribution.values, expected / expected.sum(), atol=1e-12)
    assert decision.profile == np.unravel_index(expected.argmax(), expected.shape)


def test_where_going_first_is_risky_it_waits_until_it_knows_better():
    situation = contested()
    assert BayesRisk(risk_weight=0.0).decide(situation, "robot").profile == (0, 1)
    assert BayesRisk().decide(situation, "robot").profile == (1, 0)
    # the human waited: now there is nothing to fear
    waited = replace(situation, motion=motion_along(situation.plans[1], 1, 8), time=0.8)
    memory = BayesRisk().decide(situation, "robot").memory
    assert BayesRisk().decide(waited, "robot", memory).profile == (0, 1)


def test_only_the_first_of_its_plans_are_considered_and_the_static_one():
    situation = random_situation(21, own=9, other=9, density=0.2)
    decision = BayesRisk(personality=FEW, acting=3).decide(situation, "robot")
    considered = decision.distribution.values.sum(axis=1) > 0
    assert not considered[3:9].any()


def test_without_an_equilibrium_it_holds_and_goes_on_predicting():
    situation = Situation.from_contacts(
        [plan_set("robot", [3.0]), plan_set("human", [2.0])], np.full((2, 2), 0.5)
    )
    decision = BayesRisk().decide(situation, "robot")
    assert decision.plan == 1
    assert decision.profile is None
    assert decision.predictive.prob(human_plan=1) == 1.0


def motion_along(plans, plan, steps, held=None):
    """Return the motion of a robot that stays and a human that follows a plan."""
    where = plans.positions(np.arange(steps + 1) * 0.1)[plan]
    position = np.stack([np.zeros_like(where), where], axis=1)
    held = np.zeros(steps + 1, bool) if held is None else held
    return Motion(position, np.zeros_like(position), held)


def contested():
    """Return a situation in which one of two has to wait."""
    return Situation.from_contacts(
        [plan_set("robot", [2.0]), plan_set("human", [2.5])], [[1.5, np.inf], [np.inf, np.inf]]
    )


@pytest.mark.parametrize(("plan", "favoured"), [(0, "human"), (1, "robot")])
def test_who_goes_ahead_is_believed_to_favour_itself_and_who_waits_not_to(plan, favoured):
    model = PredictivePersonality()
    first = contested()
    state = model.observe(first, "robot", None)
    assert state.belief.values.tolist() == [0.5, 0.5]
    moved = replace(first, motion=motion_along(first.plans[1], plan, 8), time=0.8)
    assert model.observe(moved, "robot", state).belief.prob(theta=favoured) > 0.9


def test_steps_that_were_held_say_nothing():
    model = PredictivePersonality(stay=1.0)
    first = contested()
    state = model.observe(first, "robot", None)
    held = np.array([False, True])
    stopped = replace(first, motion=motion_along(first.plans[1], 1, 1, held), time=0.1)
    assert_allclose(model.observe(stopped, "robot", state).belief.values, [0.5, 0.5], atol=1e-12)
    # three steps of its plan and one held are three steps
    position = first.plans[1].positions([0.0, 0.1, 0.2, 0.3, 0.3])[0]
    motion = Motion(
        np.stack([np.zeros_like(position), position], axis=1),
        np.zeros((5, 2, 1)),
        np.array([False, False, False, False, True]),
    )
    short = replace(first, motion=motion_along(first.plans[1], 0, 3), time=0.3)
    assert_allclose(
        model.observe(replace(first, motion=motion), "robot", state).belief.values,
        model.observe(short, "robot", state).belief.values,
        atol=1e-12,
    )


def test_what_it_needs_is_asked_for():
    situation = contested()
    blind = Situation(situation.plans, situation.game)
    with pytest.raises(ModelError, match="give the situation its contact_time"):
        BayesRisk().decide(blind, "robot")
    with pytest.raises(ModelError, match="acting must be at least 1"):
        BayesRisk(acting=0)
    with pytest.raises(ModelError, match="fade positive"):
        BayesRisk(fade=0.0)
    with pytest.raises(ModelError, match="risk_weight must lie in"):
        BayesRisk(risk_weight=-1.0)
    with pytest.raises(ModelError, match="contamination must lie in"):
        PredictivePersonality(contamination=2.0)


def test_the_predictive_distribution_mixes_over_theta():
    situation = contested()
    decision = BayesRisk().decide(situation, "robot")
    assert decision.predictive.axes == (Axis("human_plan", 2),)
    assert_allclose(decision.predictive.values, [0.5, 0.5], atol=1e-12)


def test_plans_of_one_who_has_left_ask_for_no_evidence():
    robot = plan_set("robot", [2.0])
    gone = Situation.from_contacts([robot, PlanSet.holding("human", [0.0])], np.full((2, 1), np.inf))
    first = contested()
    state = PredictivePersonality(stay=1.0).observe(first, "robot", None)
    motion = motion_along(first.plans[1], 0, 8)
    motion.position[4:, 1] = np.nan
    after = PredictivePersonality(stay=1.0).observe(replace(gone, motion=motion), "robot", state)
    assert_allclose(after.belief.values, [0.5, 0.5], atol=1e-12)
