"""The joint belief over goal and rationality, against brute force, and what it recovers."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ppinfer.errors import LogError, ModelError
from ppinfer.goals import (
    Dynamics,
    GoalAndRationality,
    GoalDesign,
    GoalEvidence,
    GoalLQR,
    NoisilyRational,
    OnlineGoalAndRationality,
    infer_goals,
    paper_agent,
)
from ppinfer.testing import check_normalisation

BETAS = (5e-6, 5e-5, 5e-3)


def evidence_of(rationality=5e-5, rows=3, samples=12, *, absent=True, seed=0):
    rng = np.random.default_rng(seed)
    evidence = paper_agent(rationality).simulate(GoalDesign.random(rng, rows=rows, samples=samples), rng)
    if absent:
        present = np.ones((rows, 3), dtype=bool)
        present[1, 2] = False
        evidence = replace(evidence, present=present)
    return evidence


def brute_force(joint, evidence, prior=None, rationality_prior=None):
    """Return the joint belief by literal products of densities and sums over pairs, sample by sample."""
    belief = np.zeros((evidence.samples, len(evidence.goal_labels), len(joint.rationalities)))
    agents = [
        NoisilyRational.lqr(
            Dynamics.double_integrator(0.1), state_weight=10.0, control_weight=1.0, rationality=beta
        )
        for beta in joint.rationalities
    ]
    for row, (start, size) in enumerate(zip(evidence.row_start, evidence.row_size, strict=True)):
        there = evidence.goal_present[row]
        weights = np.where(there, 1.0 if prior is None else np.asarray(prior), 0.0)
        log = np.log(np.where(weights > 0, weights, 1.0))[:, None] + np.log(
            np.ones(len(agents)) if rationality_prior is None else np.asarray(rationality_prior)
        )
        log = np.where((weights > 0)[:, None], log, -np.inf)
        for sample in range(start, start + size):
            x = np.array(
                [
                    evidence.position[sample, 0],
                    evidence.velocity[sample, 0],
                    evidence.position[sample, 1],
                    evidence.velocity[sample, 1],
                ]
            )
            for goal in np.flatnonzero(there):
                theta = np.array([evidence.goals[row, goal, 0], 0.0, evidence.goals[row, goal, 1], 0.0])
                for b, agent in enumerate(agents):
                    log[goal, b] += agent.log_density(evidence.control[sample], x, theta)
            shifted = np.exp(log - log.max())
            belief[sample] = shifted / shifted.sum()
    return belief


@pytest.mark.parametrize("rationality", BETAS)
def test_the_belief_is_what_products_of_densities_give(rationality):
    joint, evidence = GoalAndRationality(), evidence_of(rationality)
    belief = joint.infer(evidence)
    assert belief.random == ("goal", "rationality")
    check_normalisation(belief)
    assert_allclose(belief.values, brute_force(joint, evidence), atol=1e-9)


def test_priors_over_goals_and_rationalities_multiply():
    joint = GoalAndRationality(rationality_prior=(1.0, 2.0, 5.0))
    evidence = evidence_of()
    expected = brute_force(joint, evidence, prior=[1.0, 3.0, 2.0], rationality_prior=[1.0, 2.0, 5.0])
    assert_allclose(joint.infer(evidence, prior=[1.0, 3.0, 2.0]).values, expected, atol=1e-9)


def test_the_constant_that_depends_on_the_rationality_decides_and_is_kept():
    """Without the normaliser, the lowest rationality would always win."""
    joint, evidence = GoalAndRationality(), evidence_of(5e-3, rows=1, samples=40, absent=False)
    _, agent, motion = joint.model.squared_residuals(evidence)
    count, beta = motion.informative.sum(), np.array(BETAS)
    z = motion.control + motion.state @ agent.K.T
    best = agent.dynamics.goal_states(evidence.goals[0]) @ agent.goal_gain.T
    Z, S = z.sum(axis=0), agent.S
    inner = (
        2 * (best @ S @ Z)[:, None] * beta - beta * count * np.einsum("gi,ij,gj->g", best, S, best)[:, None]
    )
    constant = -beta * np.einsum("ti,ij,tj->", z, S, z) + count * np.log(beta)
    log_weights = inner + constant
    expected = np.exp(log_weights - log_weights.max())
    assert_allclose(joint.infer(evidence).values[-1], expected / expected.sum(), atol=1e-9)
    without = (log_weights - count * np.log(beta)).max(axis=0)
    assert without.argmax() == 0
    assert joint.infer(evidence).values[-1].sum(axis=0).argmax() == 2


def test_sums_over_a_row_give_what_a_filter_over_pairs_gives():
    joint, evidence = GoalAndRationality(), evidence_of()
    dropouts = np.ones(evidence.samples, dtype=bool)
    dropouts[[3, 17]] = False
    position = np.where(dropouts[:, None], evidence.position, np.nan)
    for variant in (evidence, replace(evidence, control=None, observed=dropouts, position=position)):
        cumulative = joint.infer(variant).values
        floored = GoalAndRationality(replace(joint.model, evidence_floor=1e-300))
        assert_allclose(floored.infer(variant).values, cumulative, atol=1e-9)


def test_given_the_rationality_the_belief_is_that_of_the_goal_alone():
    joint, evidence = GoalAndRationality(), evidence_of()
    conditional = joint.infer(evidence).given("rationality")
    for index, beta in enumerate(BETAS):
        alone = infer_goals(joint.at(beta), evidence).log_posterior
        assert_allclose(np.exp(conditional.log_values[:, :, index]), np.exp(alone), atol=1e-9)


def test_with_one_rationality_nothing_but_the_goal_is_uncertain():
    evidence = evidence_of()
    belief = GoalAndRationality(rationalities=(5e-5,)).infer(evidence)
    alone = infer_goals(paper_agent(5e-5), evidence).distribution
    assert_allclose(belief.marginal("goal").values, alone.values, atol=1e-12)


def test_goals_may_change_while_the_rationality_stays():
    model = paper_agent(stay=0.8)
    joint, evidence = GoalAndRationality(model), evidence_of()
    filtered, smoothed = (joint.infer(evidence, mode=mode) for mode in ("filter", "smooth"))
    last = evidence.row_start + evidence.row_size - 1
    assert_allclose(smoothed.values[last], filtered.values[last], atol=1e-12)
    # the rationality stays, so that smoothing knows as much of it at every sample
    of_rationality = smoothed.marginal("rationality").values
    for row, end in enumerate(last):
        start = evidence.row_start[row]
        assert_allclose(of_rationality[start:end], np.tile(of_rationality[end], (end - start, 1)), atol=1e-9)
    alone = infer_goals(replace(model, rationality=5e-5), evidence).log_posterior
    conditional = filtered.given("rationality").log_values[:, :, 1]
    assert_allclose(np.exp(conditional), np.exp(alone), atol=1e-9)


@pytest.mark.parametrize("stay", [1.0, 0.9])
@pytest.mark.parametrize("floor", [0.0, 0.01])
def test_the_belief_at_control_rate_equals_that_of_the_log(stay, floor):
    joint = GoalAndRationality(replace(paper_agent(stay=stay), evidence_floor=floor, tempering=0.7))
    logged = evidence_of()
    tracked = replace(logged, control=None, velocity=None)
    for evidence in (logged, tracked):
        offline = joint.infer(evidence).log_values
        online = OnlineGoalAndRationality(joint, dt=0.1, labels=evidence.goal_labels)
        for row in range(evidence.rows):
            online.restart(evidence.goals[row], present=evidence.goal_present[row])
            for sample in range(12 * row, 12 * row + 12):
                now = online.observe(
                    float(evidence.time[sample]),
                    evidence.position[sample],
                    velocity=None if evidence.velocity is None else evidence.velocity[sample],
                    control=None if evidence.control is None else evidence.control[sample],
                )
                assert_allclose(np.exp(now.log_values), np.exp(offline[sample]), atol=1e-9)


@pytest.mark.parametrize("rationality", BETAS)
def test_rationality_and_goal_are_recovered(rationality):
    joint = GoalAndRationality()
    rng = np.random.default_rng(1)
    design = GoalDesign.random(rng, rows=60, samples=30)
    evidence = joint.at(rationality).simulate(design, rng)
    belief = joint.infer(evidence)
    last = evidence.row_start + evidence.row_size - 1
    of_rationality = belief.marginal("rationality").values[last]
    assert (of_rationality.argmax(axis=1) == BETAS.index(rationality)).mean() > 0.95
    if rationality == BETAS[-1]:
        of_goal = belief.marginal("goal").values[last]
        assert (of_goal.argmax(axis=1) == design.true_goal).mean() > 0.95


def test_the_joint_belief_is_calibrated_where_rationality_is_drawn_from_its_prior():
    joint = GoalAndRationality()
    rng = np.random.default_rng(2)
    rows = 600
    surplus = []
    for index, beta in enumerate(BETAS):
        evidence = joint.at(beta).simulate(GoalDesign.random(rng, rows=rows, samples=2), rng)
        p = joint.infer(evidence).marginal("rationality").values[1::2]
        surplus.append(p[:, index] - (p**2).sum(axis=1))
    values = np.concatenate(surplus)
    assert abs(values.mean()) < 5 * values.std() / np.sqrt(len(values))


def test_new_goals_may_find_the_rationality_known():
    joint = GoalAndRationality(paper_agent(stay=0.9))
    online = OnlineGoalAndRationality(joint, dt=0.1, labels=["a", "b"])
    begun = online.restart(np.eye(2))
    assert_allclose(begun.values, np.full((2, 3), 1 / 6))
    for step in range(5):
        before = online.observe(0.1 * step, np.zeros(2), velocity=np.zeros(2), control=np.array([2.0, 0.0]))
    carried = online.restart(-np.eye(2), carry_rationality=True)
    learnt = before.marginal("rationality").values
    assert_allclose(carried.marginal("rationality").values, learnt)
    assert_allclose(carried.marginal("goal").values, [0.5, 0.5])
    forgotten = online.restart(-np.eye(2))
    assert_allclose(forgotten.marginal("rationality").values, np.full(3, 1 / 3))


def test_an_agent_of_one_s_own_may_be_any():
    agent = NoisilyRational.lqr(Dynamics.single_integrator(0.1), rationality=7.0)
    joint = GoalAndRationality(GoalLQR(agent=agent), rationalities=(0.1, 10.0))
    rng = np.random.default_rng(0)
    evidence = joint.at(10.0).simulate(GoalDesign.random(rng, rows=4, samples=20), rng)
    belief = joint.infer(evidence)
    assert (belief.marginal("rationality").values[19::20, 1] > 0.99).all()
    likelihood = joint.log_likelihood(evidence)
    assert likelihood.names == ("sample", "goal", "rationality")
    assert_allclose(
        likelihood.log_values[:, :, 1], joint.at(10.0).log_likelihood(evidence).log_values, rtol=1e-9
    )


@pytest.mark.parametrize(
    "wrong",
    [
        {"rationalities": ()},
        {"rationalities": (1.0, 1.0)},
        {"rationalities": (0.0,)},
        {"rationalities": (1.0, np.nan)},
        {"rationality_prior": (1.0, 1.0)},
        {"rationality_prior": (0.0, 0.0, 0.0)},
        {"rationality_prior": (-1.0, 1.0, 1.0)},
    ],
)
def test_rationalities_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ModelError, match="rationalit"):
        GoalAndRationality(**wrong)


def test_what_cannot_be_inferred_is_refused():
    joint, evidence = GoalAndRationality(), evidence_of()
    with pytest.raises(ModelError, match="continues=None"):
        joint.infer(replace(evidence, continues=np.array([False, True, False])))
    online = OnlineGoalAndRationality(joint, dt=0.1, labels=["a", "b"])
    with pytest.raises(LogError, match="restart"):
        online.observe(0.0, np.zeros(2))
    with pytest.raises(LogError, match="do not match"):
        online.restart(np.zeros((3, 2)))
    with pytest.raises(LogError, match="finite position"):
        online.restart(np.full((2, 2), np.nan))
    online.restart(np.eye(2))
    online.observe(0.0, np.zeros(2))
    with pytest.raises(LogError, match="increase"):
        online.observe(0.0, np.zeros(2))
    with pytest.raises(LogError, match="shape"):
        online.observe(0.1, np.zeros(3))
    with pytest.raises(LogError, match="not finite"):
        online.observe(0.1, np.array([0.0, np.nan]))


def test_a_dropout_tells_nothing():
    joint = GoalAndRationality()
    online = OnlineGoalAndRationality(joint, dt=0.1, labels=["a", "b"])
    online.restart(np.eye(2))
    seen = online.observe(0.0, np.zeros(2), velocity=np.zeros(2), control=np.ones(2))
    assert_allclose(online.observe(0.1, None).values, seen.values)


def test_a_goal_far_away_is_no_trouble():
    evidence = GoalEvidence(
        time=np.arange(3) * 0.1,
        position=np.zeros((3, 2)),
        goals=np.array([[[1e6, 0.0], [0.0, 1.0]]]),
        row_size=np.array([3]),
        goal_labels=("far", "near"),
        velocity=np.zeros((3, 2)),
        control=np.zeros((3, 2)),
        time_step=0.1,
    )
    belief = GoalAndRationality().infer(evidence)
    check_normalisation(belief)
    assert belief.marginal("goal").values[-1, 1] == 1.0
