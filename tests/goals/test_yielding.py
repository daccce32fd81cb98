"""One belief over goal and personality: its laws, an oracle, and what it finds in simulated humans."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from ppinfer import Distribution, Factor
from ppinfer.coordination import GoalChoiceGame
from ppinfer.errors import LogError, ModelError
from ppinfer.goals import GoalLQR, NearestGoal, Observation, infer_goals
from ppinfer.goals.conditional import SoftmaxConditional
from ppinfer.goals.yielding import (
    Encounter,
    EncounterEvidence,
    OnlineYielding,
    SoftmaxReaction,
    Yielding,
    simulate_encounters,
)
from ppinfer.testing import check_chain_rule, check_normalisation

REACTIONS = {"softmax": SoftmaxReaction(), "equilibria": GoalChoiceGame()}
reactions = pytest.mark.parametrize("reaction", REACTIONS.values(), ids=list(REACTIONS))


def simulated(model=None, seed=0, **size):
    """Return encounters drawn from a model, and what was true of them."""
    rng = np.random.default_rng(seed)
    encounter = Encounter.random(rng, **{"encounters": 2, "rows": 2, "samples": 12, **size})
    evidence, pursued = simulate_encounters(model or Yielding(), encounter, rng)
    return encounter, evidence, pursued


def observations(evidence, sample):
    """Return what is seen of both agents at a sample."""
    return [
        Observation(
            float(agent.time[sample]),
            agent.position[sample] if agent.seen[sample] else None,
            agent.velocity[sample],
            agent.control[sample],
        )
        for agent in (evidence.human, evidence.robot)
    ]


@reactions
def test_step_by_step_equals_all_at_once(reaction):
    model = Yielding(reaction=reaction)
    _, evidence, _ = simulated(model, seed=3)
    offline = model.infer(evidence, prior=[0.3, 0.7], goal_prior=[0.5, 0.3, 0.2])
    for encounter in range(2):
        online = OnlineYielding(model, dt=0.1, labels=evidence.human.goal_labels, prior=[0.3, 0.7])
        for row in np.flatnonzero(evidence.encounter == encounter):
            online.restart(evidence.human.goals[row], goal_prior=[0.5, 0.3, 0.2])
            for sample in np.flatnonzero(evidence.human.row_of_sample == row):
                now = online.observe(*observations(evidence, sample))
                assert now.axes == offline.axes[1:]
                assert_allclose(now.values, offline.values[sample], atol=1e-12)


@reactions
def test_goals_that_are_absent_and_samples_that_are_lost_are_the_same_online_and_offline(reaction):
    model = Yielding(reaction=reaction)
    _, evidence, _ = simulated(model, seed=4)
    present = np.array([[True, True, False], [True, True, True], [False, True, True], [True, False, True]])
    lost = np.random.default_rng(0).random((2, 48)) < 0.3
    agents = [
        replace(agent, present=present, observed=~gone)
        for agent, gone in zip((evidence.human, evidence.robot), lost, strict=True)
    ]
    evidence = EncounterEvidence(*agents, evidence.encounter)
    offline = model.infer(evidence).values
    assert (offline[~present[evidence.human.row_of_sample]] == 0.0).all()
    for encounter in range(2):
        online = OnlineYielding(model, dt=0.1, labels=evidence.human.goal_labels)
        for row in np.flatnonzero(evidence.encounter == encounter):
            online.restart(evidence.human.goals[row], present=present[row])
            for sample in np.flatnonzero(evidence.human.row_of_sample == row):
                now = online.observe(*observations(evidence, sample))
                assert_allclose(now.values, offline[sample], atol=1e-12)


def test_it_is_the_sum_over_all_that_may_have_happened():
    model = Yielding(motion=GoalLQR("double-integrator", 1.0, 10.0, 0.02, stay=0.9), reconsiders=0.4)
    encounter, evidence, _ = simulated(model, seed=5, encounters=1, rows=1, goals=2, samples=5)
    likelihood = model.motion.log_likelihood(evidence.human).log_values
    likelihood = np.exp(likelihood - likelihood.max(axis=1, keepdims=True))
    mental = infer_goals(model.robot_motion, evidence.robot).distribution.values
    goals = encounter.goals[0]
    chance = np.zeros((2, 2))
    for theta, *course in product(range(2), *[range(2)] * 5):
        value = 0.5 * 0.5 * likelihood[0, course[0]]
        for t in range(1, 5):
            before, after = course[t - 1], course[t]
            stays = 0.9 if before == after else 0.1
            if theta == 1:
                reacts = float(before == after)
            else:
                reacts = 0.0
                for robot_goal in range(2):
                    weight = [
                        np.exp(
                            -0.5
                            * (
                                2 * np.linalg.norm(goals[post] - evidence.human.position[t])
                                - 3 * np.linalg.norm(goals[post] - goals[robot_goal])
                                + np.linalg.norm(goals[post] - goals[before])
                            )
                        )
                        for post in range(2)
                    ]
                    reacts += mental[t - 1, robot_goal] * weight[after] / sum(weight)
            value *= (0.6 * stays + 0.4 * reacts) * likelihood[t, after]
        chance[course[-1], theta] += value
    assert_allclose(model.infer(evidence).values[-1], chance / chance.sum(), atol=1e-12)


@reactions
def test_it_is_a_distribution_whose_marginals_and_conditionals_agree(reaction):
    model = Yielding(reaction=reaction)
    posterior = model.infer(simulated(model)[1])
    check_normalisation(posterior)
    assert posterior.random == ("goal", "theta")
    last = Distribution(posterior.axes[1:], posterior.log_values[-1])
    check_chain_rule(last, "theta")


def test_a_human_who_never_thinks_again_tells_nothing_of_its_personality():
    model = Yielding(reconsiders=0.0)
    _, evidence, _ = simulated(seed=1, encounters=3, rows=1)
    posterior = model.infer(evidence, prior=[0.2, 0.8])
    assert_allclose(posterior.marginal("theta").values, [[0.2, 0.8]] * 36, atol=1e-12)
    alone = infer_goals(model.motion, evidence.human).distribution
    assert_allclose(posterior.marginal("goal").values, alone.values, atol=1e-9)


def test_of_one_who_is_known_not_to_yield_it_is_the_belief_over_goals_alone():
    model = Yielding(reconsiders=0.2)
    _, evidence, _ = simulated(seed=2, rows=1)
    posterior = model.infer(evidence, prior=[0.0, 1.0])
    stays = 1.0 - 0.8 * (1.0 - model.motion.stay)
    alone = infer_goals(replace(model.motion, stay=stays), evidence.human).distribution
    assert_allclose(posterior.marginal("goal").values, alone.values, atol=1e-9)


@settings(max_examples=8, deadline=None)
@given(st.floats(0.01, 0.99), st.permutations(range(3)))
def test_what_is_known_of_theta_may_come_before_or_after(share, order):
    model = Yielding()
    _, evidence, _ = simulated(model, seed=6, encounters=1)
    known = Factor.from_values([model.theta], [share, 1.0 - share])
    assert_allclose(
        model.infer(evidence, prior=known.normalize("theta")).values,
        model.infer(evidence).update(known).values,
        atol=1e-12,
    )
    # relabelling
    order = list(order)
    turned = [
        replace(
            agent,
            goals=agent.goals[:, order],
            goal_labels=tuple(agent.goal_labels[goal] for goal in order),
        )
        for agent in (evidence.human, evidence.robot)
    ]
    permuted = model.infer(EncounterEvidence(*turned, evidence.encounter))
    assert_allclose(permuted.values, model.infer(evidence).values[:, order], atol=1e-9)


def test_what_is_known_of_theta_is_kept_when_goals_are_new_and_forgotten_with_a_new_human():
    model = Yielding()
    _, evidence, _ = simulated(model, seed=7, encounters=2, rows=2)
    theta = model.infer(evidence).marginal("theta").values
    starts = evidence.human.row_start
    # a first sample is evidence about the goal alone
    assert_allclose(theta[starts[1]], theta[starts[1] - 1], atol=1e-12)
    assert_allclose(theta[starts[2]], [0.5, 0.5], atol=1e-12)


@reactions
def test_the_personality_of_simulated_humans_is_recovered_and_calibrated(reaction):
    model = Yielding(reaction=reaction, reconsiders=0.15)
    encounter, evidence, pursued = simulated(model, seed=8, encounters=400, rows=3, samples=30)
    posterior = model.infer(evidence)
    last = np.cumsum(np.bincount(evidence.encounter) * 30) - 1
    theta = posterior.marginal("theta")
    favours_itself, true = theta.values[last, 1], encounter.theta[::3] == 1
    assert (favours_itself[true][:, None] > favours_itself[~true]).mean() > 0.95
    assert theta.log_values[last, encounter.theta[::3]].mean() > -0.25
    # of those believed with p to favour themselves, a share p do
    for low, high in ((0.0, 0.2), (0.2, 0.8), (0.8, 1.0)):
        among = (favours_itself >= low) & (favours_itself <= high)
        error = np.sqrt(np.maximum((favours_itself * (1 - favours_itself))[among].mean(), 1e-3) / among.sum())
        assert abs(true[among].mean() - favours_itself[among].mean()) < 4 * error
    # to know what somebody is like helps to know where they are going
    sample = np.arange(len(pursued))
    alone = infer_goals(model.motion, evidence.human).log_posterior
    assert posterior.marginal("goal").log_values[sample, pursued].mean() > alone[sample, pursued].mean()


@pytest.mark.parametrize(("yields", "favoured"), [(True, "robot"), (False, "human")])
def test_who_turns_away_from_the_robots_goal_favours_it_and_who_goes_on_favours_itself(yields, favoured):
    goals = np.array([[5.0, 0.0], [0.0, 5.0]])
    model = Yielding(reconsiders=0.2)
    agent = model.motion.agent_at(0.1)
    belief = OnlineYielding(model, dt=0.1, labels=["cup", "bowl"])
    belief.restart(goals)
    human, robot = np.array([0.0, 0.0, 0.0, 0.0]), np.array([6.0, 0.0, -5.0, 0.0])
    for step in range(25):
        goal = 1 if yields and step > 3 else 0
        seen = []
        for state, target in ((human, goals[goal]), (robot, goals[0])):
            control = agent.mean_control(state, agent.dynamics.goal_states(target))
            seen.append(Observation(0.1 * step, state[::2].copy(), state[1::2].copy(), control))
            state[:] = agent.dynamics.step(state, control)
        joint = belief.observe(*seen)
    assert joint.mode()["goal"] == ("bowl" if yields else "cup")
    assert joint.marginal("theta").prob(theta=favoured) > 0.9


def test_evidence_from_elsewhere_is_one_more_factor():
    belief = OnlineYielding(Yielding(), dt=0.1, labels=["cup", "bowl"])
    belief.restart(np.eye(2))
    belief.update(Factor.from_values([belief.model.theta], [0.1, 0.3]))
    joint = belief.update(Factor.from_values([belief.belief.axis("goal")], [0.2, 0.6]))
    assert_allclose(joint.values, [[1 / 16, 3 / 16], [3 / 16, 9 / 16]])


def test_weights_that_cannot_make_anybody_yield_tell_less_of_theta():
    encounter, evidence, _ = simulated(Yielding(), seed=9, encounters=200, rows=2, samples=30)
    last = np.cumsum(np.bincount(evidence.encounter) * 30) - 1
    right = encounter.theta[::2]

    def score(conditional):
        model = Yielding(reaction=SoftmaxReaction(conditional))
        return model.infer(evidence).marginal("theta").log_values[last, right].mean()

    assert score(SoftmaxConditional()) > score(SoftmaxConditional.study_simulation()) + 0.1


def test_what_makes_no_sense_is_refused():
    with pytest.raises(ModelError, match="reconsiders"):
        Yielding(reconsiders=1.5)
    with pytest.raises(ModelError, match="two names"):
        Yielding(agents=("human", "human"))
    with pytest.raises(ModelError, match="judges each sample by itself"):
        Yielding(motion=NearestGoal())
    _, evidence, _ = simulated()
    with pytest.raises(ModelError, match="number the 4 rows"):
        EncounterEvidence(evidence.human, evidence.robot, np.zeros(3, np.int64))
    with pytest.raises(ModelError, match="same times, rows and goals"):
        EncounterEvidence(
            evidence.human, replace(evidence.robot, goals=evidence.robot.goals + 1.0), evidence.encounter
        )
    carried = replace(evidence.human, continues=np.array([False, True, False, False]))
    with pytest.raises(ModelError, match="row 1 carries beliefs"):
        EncounterEvidence(carried, evidence.robot, evidence.encounter)
    with pytest.raises(LogError, match="restart"):
        OnlineYielding(Yielding(), dt=0.1, labels=["cup"]).observe(*observations(evidence, 0))
