"""Beliefs over goals against the literal recursion, enumeration, and the laws."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from ppinfer.distributions import forward_filter
from ppinfer.errors import ImpossibleEvidenceError, LogError, ModelError
from ppinfer.goals import (
    MODELS,
    Dynamics,
    GoalDesign,
    GoalEvidence,
    GoalKalman,
    GoalLQR,
    GoalModel,
    Heading,
    NearestGoal,
    NoisilyRational,
    infer_goals,
)
from ppinfer.goals.switching import goal_transition
from ppinfer.testing import check_likelihood, goal_evidences

from .literal import enumerated_smoother, literal_belief, literal_log_density

SETTINGS = [
    (GoalLQR(control_weight=4.64, rationality=0.05), True),
    (GoalLQR(dynamics="double-integrator", control_weight=1.0, state_weight=10.0, rationality=0.05), True),
    (GoalLQR(stay=0.9, tempering=0.3, evidence_floor=0.05), False),
    (
        GoalLQR(
            agent=NoisilyRational.lqr(Dynamics.single_integrator(0.1), control_weight=3.0, rationality=0.1)
        ),
        True,
    ),
    (GoalKalman(rationality=1.0), True),
    (GoalKalman(dynamics="single-integrator", stay=0.9, tempering=0.5), False),
    (NearestGoal(scale=3.0), True),
    (Heading(concentration=1.5), True),
]


@pytest.mark.parametrize(("model", "twin"), SETTINGS, ids=lambda value: getattr(value, "name", None))
def test_every_model_obeys_the_laws(model, twin):
    check_likelihood(model, twin=twin)


@pytest.mark.parametrize("name", list(MODELS))
def test_every_model_that_commands_know_obeys_the_laws_as_it_comes(name):
    # a product of experts says which goals go with what is seen, and not what is seen: its motion alone has a twin
    check_likelihood(MODELS[name](), examples=15, twin=name != "goal-coupled")


def row_of(evidence, row):
    start = evidence.row_start[row]
    return slice(start, start + evidence.row_size[row])


@pytest.mark.parametrize("dynamics", ["single-integrator", "double-integrator"])
@pytest.mark.parametrize("stay", [1.0, 0.9])
def test_the_belief_is_the_printed_recursion(dynamics, stay):
    model = GoalLQR(dynamics=dynamics, control_weight=2.0, rationality=0.05, stay=stay)
    rng = np.random.default_rng(3)
    evidence = model.simulate(GoalDesign.random(rng, rows=4, samples=15), rng)
    agent = model.agent_at(0.1)
    A, B = agent.dynamics.A, agent.dynamics.B
    belief = np.exp(infer_goals(model, evidence).log_posterior)
    for row in range(evidence.rows):
        here = row_of(evidence, row)
        state = np.zeros((15, agent.dynamics.states))
        state[:, list(agent.dynamics.position_index)] = evidence.position[here]
        if agent.dynamics.velocity_index:
            state[:, list(agent.dynamics.velocity_index)] = evidence.velocity[here]
        goals = agent.dynamics.goal_states(evidence.goals[row])
        log_likelihood = np.array(
            [
                [literal_log_density(x, u, goal, A, B, agent.Q, agent.R, model.rationality) for goal in goals]
                for x, u in zip(state, evidence.control[here], strict=True)
            ]
        )
        transition = None if stay == 1.0 else goal_transition(np.ones(3, dtype=bool), stay)
        assert_allclose(
            belief[here], literal_belief(log_likelihood, np.full(3, 1 / 3), transition), atol=1e-10
        )


def test_the_smoother_sums_over_every_sequence_of_goals():
    model = GoalLQR(control_weight=2.0, rationality=0.02, stay=0.8)
    rng = np.random.default_rng(5)
    evidence = model.simulate(GoalDesign.random(rng, rows=2, samples=6), rng)
    log_likelihood = model.log_likelihood(evidence).log_values
    smoothed = np.exp(infer_goals(model, evidence, mode="smooth").log_posterior)
    transition = goal_transition(np.ones(3, dtype=bool), 0.8)
    for row in range(2):
        here = row_of(evidence, row)
        centred = log_likelihood[here] - log_likelihood[here].max(axis=1, keepdims=True)
        assert_allclose(
            smoothed[here], enumerated_smoother(centred, np.full(3, 1 / 3), transition), atol=1e-10
        )


@given(goal_evidences())
def test_the_cumulative_form_equals_the_recursion(evidence):
    model = GoalLQR(control_weight=3.0, rationality=0.01)
    fast = infer_goals(model, evidence).log_posterior
    present = evidence.goal_present
    with np.errstate(divide="ignore"):
        log_prior = np.log(present / present.sum(axis=1, keepdims=True))
    slow = forward_filter(model.log_likelihood(evidence).log_values, evidence.row_size, log_prior)
    assert_allclose(fast, slow, rtol=1e-9, atol=1e-9)


def test_a_far_origin_costs_no_digits():
    model = GoalLQR(control_weight=4.0, rationality=0.05)
    rng = np.random.default_rng(0)
    # moving by a power of two moves binary numbers on this grid exactly
    grid = 2.0**-12
    evidence = model.simulate(GoalDesign.random(rng, rows=3, samples=200), rng)
    near = replace(
        evidence,
        position=np.round(evidence.position / grid) * grid,
        goals=np.round(evidence.goals / grid) * grid,
        control=None,
    )
    far = replace(near, position=near.position + 2.0**22, goals=near.goals + 2.0**22)
    assert_allclose(infer_goals(model, far).log_posterior, infer_goals(model, near).log_posterior, atol=1e-5)


def test_rows_restart_exactly():
    model = GoalLQR(control_weight=4.0, rationality=0.05)
    rng = np.random.default_rng(1)
    evidence = model.simulate(GoalDesign.random(rng, rows=50, samples=37), rng)
    together = infer_goals(model, evidence).log_posterior
    for row in (0, 1, 49):
        alone = infer_goals(model, evidence.take_rows(np.array([row]))).log_posterior
        assert (together[row_of(evidence, row)] == alone).all()


def test_a_carried_belief_goes_on_where_the_row_before_it_ended():
    model = GoalLQR(control_weight=4.0, rationality=0.01)
    rng = np.random.default_rng(2)
    evidence = model.simulate(GoalDesign.random(rng, rows=2, samples=5), rng)
    carried = infer_goals(model, replace(evidence, continues=np.array([False, True]))).log_posterior
    anew = infer_goals(model, evidence).log_posterior
    last = np.exp(anew[4])
    log_likelihood = model.log_likelihood(evidence).log_values[5]
    expected = last * np.exp(log_likelihood - log_likelihood.max())
    assert_allclose(np.exp(carried[5]), expected / expected.sum(), atol=1e-12)
    assert_allclose(carried[:5], anew[:5], atol=1e-12)


def test_a_goal_that_vanishes_leaves_its_probability_to_the_others():
    present = np.array([True, True, False])
    matrix = goal_transition(present, 0.9)
    assert_allclose(matrix, [[0.9, 0.1, 0.0], [0.1, 0.9, 0.0], [0.5, 0.5, 0.0]])
    assert_allclose(goal_transition(np.array([False, True]), 0.9), [[0, 1], [0, 1]])


def test_after_a_change_of_mind_switching_recovers_and_a_plain_product_does_not():
    agent = GoalLQR(control_weight=1.0, rationality=0.5)
    rng = np.random.default_rng(4)
    goals = np.array([[[10.0, 0.0], [0.0, 10.0]]])
    there = GoalDesign(np.zeros((1, 2)), goals, np.array([0]), np.array([15]), 0.1)
    first = agent.simulate(there, rng)
    back = GoalDesign(first.position[-1:], goals, np.array([1]), np.array([8]), 0.1)
    then = agent.simulate(back, rng)
    evidence = replace(
        first,
        time=np.arange(23) * 0.1,
        position=np.concatenate([first.position, then.position]),
        control=np.concatenate([first.control, then.control]),
        row_size=np.array([23]),
    )
    plain = np.exp(infer_goals(agent, evidence).log_posterior[:, 1])
    switching = np.exp(infer_goals(replace(agent, stay=0.98), evidence).log_posterior[:, 1])
    assert switching[17] > 0.99
    assert plain[17] < 0.01


def test_a_prior_is_where_the_belief_begins():
    evidence = GoalEvidence(
        time=np.zeros(1),
        position=np.zeros((1, 2)),
        goals=np.ones((1, 2, 2)),
        row_size=np.array([1]),
        goal_labels=("a", "b"),
        time_step=0.1,
    )
    belief = infer_goals(GoalLQR(), evidence, prior=np.array([0.25, 0.75]))
    assert_allclose(np.exp(belief.log_posterior), [[0.25, 0.75]])
    with pytest.raises(ModelError, match="not negative"):
        infer_goals(GoalLQR(), evidence, prior=np.array([-1.0, 2.0]))
    with pytest.raises(ModelError, match="no probability to any goal"):
        infer_goals(GoalLQR(), evidence, prior=np.array([0.0, 0.0]))


def test_evidence_of_a_scale_that_no_exponential_survives_still_decides():
    model = GoalLQR(control_weight=1.0, rationality=1e6)
    rng = np.random.default_rng(6)
    design = GoalDesign.random(rng, rows=3, samples=10)
    belief = infer_goals(model, model.simulate(design, rng)).log_posterior
    assert np.isfinite(belief).all()
    assert belief.min() < -1e6
    assert (belief[9::10].argmax(axis=1) == design.true_goal).all()


class Contradiction(GoalModel):
    """A model that rules every goal out."""

    def log_likelihood(self, evidence):
        return evidence.likelihood_factor(np.full((evidence.samples, len(evidence.goal_labels)), -np.inf))

    def simulate(self, design, rng):
        raise NotImplementedError


def test_impossible_evidence_names_trial_and_sample():
    evidence = GoalEvidence(
        time=np.arange(2.0),
        position=np.zeros((2, 2)),
        goals=np.ones((1, 1, 2)),
        row_size=np.array([2]),
        goal_labels=("a",),
        name_row=lambda row: "trial 'seven'",
    )
    with pytest.raises(ImpossibleEvidenceError, match="trial 'seven', sample 0"):
        infer_goals(Contradiction(), evidence)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": np.array([0.0, 0.0, 0.2])}, "row 0, sample 1: time must"),
        ({"time": np.array([0.0, np.nan, 0.2])}, "sample 1: time must be finite"),
        ({"position": np.array([[0.0, 0], [np.nan, 0], [0, 0]])}, "row 0, sample 1: position is not finite"),
        ({"goals": np.full((1, 2, 2), np.nan)}, "goal 'a' has no finite position"),
        ({"row_size": np.array([2])}, "sum to the 3 samples"),
        ({"present": np.zeros((1, 2), dtype=bool)}, "no goal is present"),
        ({"velocity": np.zeros((2, 2))}, "velocity has shape"),
        ({"observed": np.ones(2, dtype=bool)}, "observed has shape"),
        ({"present": np.ones((1, 1), dtype=bool)}, "present has shape"),
        ({"continues": np.zeros(2, dtype=bool)}, "continues has shape"),
        ({"position": np.full((3, 2), 1e160)}, "nothing can be computed"),
    ],
)
def test_bad_evidence_is_refused_where_it_is(change, message):
    good = {
        "time": np.arange(3) * 0.1,
        "position": np.zeros((3, 2)),
        "goals": np.ones((1, 2, 2)),
        "row_size": np.array([3]),
        "goal_labels": ("a", "b"),
    }
    GoalEvidence(**good)
    with pytest.raises((LogError, ImpossibleEvidenceError), match=message):
        GoalEvidence(**{**good, **change})


@given(st.lists(st.booleans(), min_size=1, max_size=4).filter(any), st.floats(0, 1))
def test_transitions_are_distributions_over_the_goals_present(present, stay):
    matrix = goal_transition(np.array(present), stay)
    assert_allclose(matrix.sum(axis=1), 1.0, atol=1e-12)
    assert (matrix[:, ~np.array(present)] == 0).all()
