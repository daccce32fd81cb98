"""The online belief refuses what it cannot use, and carries over what it is asked to."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ppinfer.errors import LogError, ModelError
from ppinfer.goals import GoalDesign, GoalEvidence, GoalKalman, GoalLQR, OnlineGoalBelief, infer_goals
from ppinfer.goals.priors import log_priors

GOALS = np.array([[1.0, 0.0], [0.0, 1.0]])


def belief_of(model=None):
    return OnlineGoalBelief(model or GoalLQR(rationality=1.0), dt=0.1, labels=["cup", "bowl"])


def test_the_belief_begins_at_its_prior():
    belief = belief_of()
    assert belief.restart(GOALS).prob(goal="cup") == 0.5
    assert_allclose(belief.restart(GOALS, prior=np.array([3.0, 1.0])).prob(goal="cup"), 0.75)
    assert_allclose(belief.observe(0.0, np.zeros(2)).prob(goal="cup"), 0.75)


@pytest.mark.parametrize("stay", [1.0, 0.8])
def test_a_carried_belief_equals_the_offline_one(stay):
    model = GoalLQR(control_weight=4.0, rationality=0.01, stay=stay)
    rng = np.random.default_rng(0)
    evidence = model.simulate(GoalDesign.random(rng, rows=3, samples=5), rng)
    evidence = replace(evidence, control=None, continues=np.array([False, True, True]))
    offline = infer_goals(model, evidence).log_posterior
    belief = OnlineGoalBelief(model, dt=0.1, labels=evidence.goal_labels)
    for row in range(3):
        belief.restart(evidence.goals[row], carry=row > 0)
        for sample in range(5 * row, 5 * row + 5):
            now = belief.observe(float(evidence.time[sample]), evidence.position[sample])
            assert_allclose(now.log_values, offline[sample], atol=1e-9)


@pytest.mark.parametrize("stay", [1.0, 0.9])
def test_a_goal_that_appears_in_a_carried_row_can_be_believed_in(stay):
    model = GoalLQR(control_weight=1.0, rationality=0.5, stay=stay)
    goals = np.array([[[5.0, 0.0], [-5.0, 0.0], [0.0, 5.0]]] * 2)
    evidence = GoalEvidence(
        time=np.arange(12) * 0.1,
        position=np.concatenate(
            [np.outer(np.arange(6), [-0.4, 0.0]), np.outer(np.arange(6), [0.1, 0.45]) - [2, 0]]
        ),
        goals=goals,
        row_size=np.array([6, 6]),
        goal_labels=("a", "b", "c"),
        present=np.array([[True, True, False], [False, True, True]]),
        continues=np.array([False, True]),
        time_step=0.1,
    )
    offline = infer_goals(model, evidence).log_posterior
    assert np.exp(offline[6, 2]) == pytest.approx(0.5)
    assert np.exp(offline[11, 2]) > 0.9
    belief = OnlineGoalBelief(model, dt=0.1, labels=evidence.goal_labels)
    for row in range(2):
        start = belief.restart(goals[row], present=evidence.goal_present[row], carry=row > 0)
        assert start.prob(goal="c") == pytest.approx(0.5 * row)
        for sample in range(6 * row, 6 * row + 6):
            now = belief.observe(float(evidence.time[sample]), evidence.position[sample])
            assert_allclose(np.exp(now.log_values), np.exp(offline[sample]), atol=1e-12)


@pytest.mark.parametrize("prior", [[0.0, 0.0], [-1.0, 3.0], [np.nan, 3.0], [1.0, 1.0, 1.0], "even"])
def test_a_prior_that_is_none_is_refused_online_as_offline(prior):
    with pytest.raises(ModelError):
        belief_of().restart(GOALS, prior=prior)
    with pytest.raises(ModelError):
        log_priors(np.ones((1, 2), dtype=bool), prior)


def test_a_long_gap_costs_no_more_than_it_takes_to_forget():
    belief = belief_of(GoalKalman(rationality=1.0))
    belief.restart(GOALS)
    belief.observe(0.0, np.zeros(2))
    now = belief.observe(1e9, np.array([1.0, 0.0]))
    # after such a gap the agent is expected at its goal
    assert now.mode()["goal"] == "cup"


def test_what_it_cannot_use_is_refused():
    belief = belief_of()
    with pytest.raises(LogError, match=r"call restart\(goals\)"):
        belief.observe(0.0, np.zeros(2))
    with pytest.raises(LogError, match="do not match the 2 labels"):
        belief.restart(np.zeros((3, 2)))
    with pytest.raises(LogError, match="finite position"):
        belief.restart(np.full((2, 2), np.nan))
    belief.restart(GOALS)
    belief.observe(0.0, np.zeros(2))
    with pytest.raises(LogError, match="time must be finite and increase"):
        belief.observe(np.inf, np.zeros(2))
    with pytest.raises(LogError, match="the goals lie in 2 dimensions"):
        belief.observe(0.1, np.zeros(3))
    with pytest.raises(LogError, match="time must be finite and increase"):
        belief.observe(0.0, np.zeros(2))
    with pytest.raises(LogError, match="position=None for a dropout"):
        belief.observe(0.1, np.array([np.nan, 0.0]))


def test_a_dropout_leaves_the_belief_as_it_is():
    belief = belief_of(GoalKalman(rationality=1.0))
    belief.restart(GOALS)
    belief.observe(0.0, np.zeros(2))
    before = belief.observe(0.1, np.array([0.01, 0.0]))
    assert before.allclose(belief.observe(0.2, None))
