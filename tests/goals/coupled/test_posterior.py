"""The posterior of goal-coupled: the formula, what is kept and what is not, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ppinfer.errors import LogError, ModelError
from ppinfer.goals import GoalCoupled, Observation, OnlineGoalBelief, infer_goals
from ppinfer.goals.configuration import make_model
from ppinfer.goals.coupled import Distance, Lead, Motion, Partner
from ppinfer.testing.goals import partners_at

from .literal import PRINTED, literal_posterior
from .scenes import scene


@pytest.mark.parametrize("velocities", [False, True])
@pytest.mark.parametrize(("goals", "partners"), [(3, 1), (5, 2), (2, 1)])
def test_it_is_the_formula_written_down(goals, partners, velocities):
    evidence = scene(np.random.default_rng(goals), goals=goals, partners=partners, velocities=velocities)
    model = make_model("goal-coupled", PRINTED)
    belief = np.exp(infer_goals(model, evidence).log_posterior)
    assert_allclose(belief, literal_posterior(evidence, PRINTED), rtol=0, atol=1e-10)


def test_what_holds_at_an_instant_is_not_fed_back():
    evidence = scene(np.random.default_rng(1), rows=1)
    model = GoalCoupled(experts=(Motion(), Distance(weight=3.0)), stay=0.9)
    moved = replace(evidence, position=evidence.position.copy())
    moved.position[:10] += 50.0  # another place, the same steps but for the tenth
    later = slice(25, 30)
    ours, theirs = (infer_goals(model.without("motion"), each).log_posterior for each in (evidence, moved))
    assert_allclose(ours[later], theirs[later], atol=1e-12)
    assert np.abs(ours[:10] - theirs[:10]).max() > 0.1


def test_standing_still_for_long_says_no_more_than_for_an_instant():
    evidence = scene(np.random.default_rng(2), rows=1)
    still = replace(evidence, position=np.tile(evidence.position[:1], (30, 1)))
    belief = infer_goals(GoalCoupled(experts=(Distance(),)), still).log_posterior
    assert_allclose(belief, np.tile(belief[:1], (30, 1)), atol=1e-12)


def test_a_dropout_keeps_where_everybody_was_last_seen():
    evidence = scene(np.random.default_rng(3), rows=1)
    seen = np.ones(30, dtype=bool)
    seen[10:20] = False
    gone = replace(
        evidence,
        observed=seen,
        position=np.where(seen[:, None], evidence.position, np.nan),
        partners=tuple(replace(partner, observed=seen) for partner in evidence.partners),
    )
    belief = infer_goals(GoalCoupled(stay=1.0), gone).log_posterior
    assert_allclose(belief[10:20], np.tile(belief[9], (10, 1)), atol=1e-12)


def test_nobody_seen_yet_leaves_the_prior():
    evidence = scene(np.random.default_rng(4), rows=1)
    unseen = np.zeros(30, dtype=bool)
    gone = replace(
        evidence,
        observed=unseen,
        position=np.full((30, 2), np.nan),
        partners=tuple(replace(partner, observed=unseen) for partner in evidence.partners),
    )
    belief = infer_goals(GoalCoupled(), gone, prior=[0.5, 0.3, 0.2]).distribution.values
    assert_allclose(belief, np.tile([0.5, 0.3, 0.2], (30, 1)), atol=1e-12)


def test_a_goal_that_does_not_stay_is_drawn_from_the_prior_itself_included():
    evidence = scene(np.random.default_rng(5), rows=1, goals=2)
    deaf = GoalCoupled(experts=(Motion(tempering=0.0),), stay=0.4)
    belief = infer_goals(deaf, evidence, prior=[0.9, 0.1]).distribution.values
    assert_allclose(belief, np.tile([0.9, 0.1], (30, 1)), atol=1e-12)


@pytest.mark.parametrize("dropouts", [False, True])
def test_a_carried_belief_is_the_gathered_one_online_and_offline(dropouts):
    evidence = scene(np.random.default_rng(6), rows=3, samples=8, dropouts=dropouts)
    present = np.array([[True, True, False], [True, True, True], [False, True, True]])
    carried = replace(evidence, present=present, continues=np.array([False, True, True]))
    model = GoalCoupled()
    offline = infer_goals(model, carried).log_posterior
    belief = OnlineGoalBelief(model, dt=0.1, labels=evidence.goal_labels)
    online = []
    for row, start in enumerate(carried.row_start):
        belief.restart(carried.goals[row], present=present[row], carry=row > 0)
        for sample in range(start, start + 8):
            position = evidence.position[sample] if evidence.seen[sample] else None
            told = belief.observe(
                float(evidence.time[sample]), position, partners=partners_at(evidence, sample)
            )
            online.append(told.log_values)
    assert_allclose(np.exp(online), np.exp(offline), atol=1e-12)


def test_the_order_of_partners_does_not_matter():
    evidence = scene(np.random.default_rng(7), partners=2)
    turned = replace(evidence, partners=evidence.partners[::-1])
    assert_allclose(
        infer_goals(GoalCoupled(), turned).log_posterior,
        infer_goals(GoalCoupled(), evidence).log_posterior,
        atol=1e-12,
    )


def test_a_partner_sure_of_its_goal_leaves_the_others_their_digits():
    evidence = scene(np.random.default_rng(8), rows=1)
    near = replace(evidence.partners[0], position=np.tile(evidence.goals[0, 1], (30, 1)))
    sure = replace(evidence, partners=(near,))
    belief = infer_goals(GoalCoupled(experts=(Partner(distance=300.0),)), sure).log_posterior
    assert np.isfinite(belief).all()
    assert (belief[:, 1] < -500).all()


def test_a_lone_goal_is_shared():
    evidence = scene(np.random.default_rng(9), goals=1)
    assert (infer_goals(GoalCoupled(), evidence).log_posterior == 0).all()


def test_smoothed_motion_meets_the_same_instants():
    evidence = scene(np.random.default_rng(10))
    judging = GoalCoupled(experts=(Distance(), Lead(), Partner()))
    assert_allclose(
        infer_goals(judging, evidence, mode="smooth").log_posterior,
        infer_goals(judging, evidence).log_posterior,
        atol=1e-12,
    )


def test_evidence_about_one_agent_alone_is_refused_in_a_line():
    evidence = replace(scene(np.random.default_rng(11)), partners=())
    with pytest.raises(ModelError, match=r"'human' alone: give it a partner.*experts=motion,distance"):
        infer_goals(GoalCoupled(), evidence)
    belief = OnlineGoalBelief(GoalCoupled(), dt=0.1, labels=evidence.goal_labels)
    belief.restart(evidence.goals[0])
    with pytest.raises(ModelError, match="give it a partner"):
        belief.observe(0.0, np.zeros(2))
    assert infer_goals(GoalCoupled().without("lead", "partner"), evidence).distribution.random == ("goal",)


def test_a_partner_that_comes_late_or_is_nowhere_is_named():
    belief = OnlineGoalBelief(GoalCoupled(), dt=0.1, labels=["cup", "bowl"])
    belief.restart(np.eye(2))
    belief.observe(0.0, np.zeros(2), partners=[Observation(0.0, np.ones(2))])
    with pytest.raises(LogError, match="began with 1 partners, and 2 are given"):
        belief.observe(0.1, np.zeros(2), partners=[Observation(0.1, np.ones(2))] * 2)
    with pytest.raises(LogError, match=r"seen of a partner .* is not finite"):
        belief.observe(0.2, np.zeros(2), partners=[Observation(0.2, np.array([np.nan, 0.0]))])
    with pytest.raises(LogError, match="partner's position"):
        belief.observe(0.3, np.zeros(2), partners=[Observation(0.3, np.zeros(3))])


def test_half_the_time_step_forgets_as_much_in_a_second():
    model = GoalCoupled().at_time_step(0.05)
    assert model.stay**2 == pytest.approx(GoalCoupled().stay)
    assert model.experts[0].tempering == pytest.approx(Motion().tempering / 2)
