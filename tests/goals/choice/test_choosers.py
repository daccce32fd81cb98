"""Choosers obey the laws, and choose what their formulas say."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, note
from numpy.testing import assert_allclose

from ppinfer.distributions import Axis, Distribution
from ppinfer.errors import ModelError
from ppinfer.goals import SoftmaxConditional
from ppinfer.goals.choice import (
    CHOOSERS,
    Courtesy,
    ExpectedCost,
    GoalChooser,
    GoalDecision,
    Influence,
    NearestGoal,
    ReactToGoal,
    Switching,
)
from ppinfer.goals.conditional import unmoved_post
from ppinfer.testing import check_goal_chooser, example_goal_situation, goal_situations


@pytest.mark.parametrize("name", CHOOSERS)
def test_every_chooser_obeys_the_laws(name):
    # the joint choice draws obstacles and rollouts for one goal after another
    check_goal_chooser(CHOOSERS[name](), examples=25, symmetric=name != "joint")


def test_parameters_keep_the_laws():
    for chooser in (
        ReactToGoal(threshold=0.0),
        Courtesy(change_weight=0.0),
        ExpectedCost(penalty=0.0, change_weight=0.0, conditional=SoftmaxConditional.study_people()),
        Switching(threshold=1.0),
    ):
        check_goal_chooser(chooser, examples=15)


def test_choosers_are_known_by_their_names():
    assert list(CHOOSERS) == [
        "naive",
        "reactive",
        "courtesy",
        "influence",
        "switching",
        "expected-cost",
        "joint",
    ]
    assert all(CHOOSERS[name].name == name for name in CHOOSERS)


@given(goal_situations())
def test_scores_are_what_the_formulas_say_term_by_term(situation):
    goals, there = situation.goals, _there(situation)
    x_H, x_R = situation.human_position, situation.robot_position
    belief = situation.belief.values
    post = SoftmaxConditional().post(situation).values
    previous = situation.previous if situation.previous in there else None
    scores = {
        name: np.full(len(goals), np.inf)
        for name in ("naive", "reactive", "courtesy", "influence", "expected-cost")
    }
    wanted = max(there, key=lambda j: belief[j])
    for r in there:
        change = 0.0 if previous is None else np.linalg.norm(goals[r] - goals[previous])
        d_R = np.linalg.norm(goals[r] - x_R)
        scores["naive"][r] = d_R
        if belief[wanted] >= 0.8 and r != wanted:
            scores["reactive"][r] = d_R
        scores["courtesy"][r] = -(post[r, wanted] - 0.02 * change)
        theirs = max(there, key=lambda i: post[r, i])
        scores["influence"][r] = np.linalg.norm(x_H - goals[theirs]) + d_R + 20 * (theirs == r)
        scores["expected-cost"][r] = 0.1 * change + sum(
            post[r, i] * (max(d_R, np.linalg.norm(goals[i] - x_H)) + 20 * (i == r)) for i in there
        )
    for name, score in scores.items():
        note(name)
        assert_allclose(CHOOSERS[name]().choose(situation).score, score, rtol=1e-9, atol=1e-9)


def test_of_equal_scores_the_first_is_taken():
    situation = replace(example_goal_situation(), goals=np.tile([[1.0, 1.0]], (3, 1)), previous=None)
    assert NearestGoal().choose(situation).goal == 0
    assert Influence().choose(situation).goal in (0, 1)


def test_the_reactive_robot_waits_until_it_is_sure_and_then_takes_the_nearest_other_goal():
    situation = example_goal_situation()
    unsure = ReactToGoal(threshold=0.71).choose(situation)
    assert unsure.goal is None
    assert (unsure.score == np.inf).all()
    assert ReactToGoal(threshold=0.7 - 1e-9).choose(situation).goal == 1


def test_a_robot_that_is_sure_of_the_human_waits_where_there_is_no_other_goal():
    situation = example_goal_situation()
    alone = replace(
        situation,
        present=np.array([True, False, False]),
        belief=Distribution.from_probabilities(situation.belief.axes, [1.0, 0.0, 0.0]),
    )
    assert ReactToGoal().choose(alone).goal is None
    assert NearestGoal().choose(alone).goal == 0


def test_the_influencing_robot_claims_what_both_are_near_and_the_courteous_one_does_not():
    situation = example_goal_situation()
    assert Influence().choose(situation).goal == 0
    assert Courtesy().choose(situation).goal != 0


def test_with_weights_that_cannot_yield_influence_leaves_the_human_their_goal():
    situation = replace(
        example_goal_situation(),
        belief=Distribution.from_probabilities(example_goal_situation().belief.axes, [0.998, 0.001, 0.001]),
    )
    deadlocked = Influence(conditional=SoftmaxConditional.study_people())
    assert deadlocked.choose(situation).goal != 0
    assert Influence().choose(situation).goal == 0


def test_a_change_of_goal_costs_and_new_goals_do_not():
    situation = example_goal_situation()
    fresh = replace(situation, previous=None)
    chooser = ExpectedCost(change_weight=0.5)
    assert_allclose(
        chooser.choose(situation).score - chooser.choose(fresh).score, [0.0, 4.0, 2.5], atol=1e-12
    )


def test_the_switching_robot_influences_the_unsure_and_is_courteous_to_the_resolute():
    situation = example_goal_situation()
    for probability, chooser in (([0.5, 0.3, 0.2], Influence()), ([0.1, 0.1, 0.8], Courtesy())):
        rationality = Distribution.from_probabilities([Axis("rationality", [5e-6, 5e-5, 5e-3])], probability)
        joint = situation.belief * rationality
        decided = Switching().choose(replace(situation, rationality_belief=joint))
        assert decided.goal == chooser.choose(situation).goal
        assert_allclose(decided.score, chooser.choose(situation).score)


def test_the_switching_robot_says_what_it_lacks():
    with pytest.raises(ModelError, match="GoalAndRationality"):
        Switching().choose(replace(example_goal_situation(), rationality_belief=None))


@pytest.mark.parametrize(
    "make",
    [
        lambda: ReactToGoal(threshold=1.5),
        lambda: Courtesy(change_weight=-1.0),
        lambda: Influence(penalty=float("nan")),
        lambda: ExpectedCost(penalty=-1.0),
        lambda: Switching(threshold=-0.1),
    ],
)
def test_parameters_out_of_range_are_refused(make):
    with pytest.raises(ModelError, match="must lie in"):
        make()


def _there(situation):
    return [i for i in range(len(situation.goals)) if situation.present is None or situation.present[i]]


# choosers that break a law, and what the check calls it


@dataclass(frozen=True)
class Last(GoalChooser):
    def choose(self, situation):
        return GoalDecision(
            len(situation.goals) - 1, np.zeros(len(situation.goals)), unmoved_post(situation.belief)
        )


@dataclass(frozen=True)
class FirstListed(GoalChooser):
    def choose(self, situation):
        score = np.arange(len(situation.goals), dtype=float)
        if situation.present is not None:
            score[~situation.present] = np.inf
        return GoalDecision.minimising(score, unmoved_post(situation.belief))


@dataclass(frozen=True)
class NearTheOrigin(GoalChooser):
    def choose(self, situation):
        score = np.where(np.isnan(situation.goals[:, 0]), np.inf, np.linalg.norm(situation.goals, axis=1))
        return GoalDecision.minimising(score, unmoved_post(situation.belief))


class Undecided(GoalChooser):
    def __init__(self):
        self.rng = np.random.default_rng(0)

    def choose(self, situation):
        score = np.where(np.isnan(situation.goals[:, 0]), np.inf, self.rng.random(len(situation.goals)))
        return GoalDecision.minimising(score, unmoved_post(situation.belief))


@dataclass(frozen=True)
class Wasteful(GoalChooser):
    def choose(self, situation):
        naive = NearestGoal().choose(situation)
        uniform = Distribution.uniform(*naive.post.axes, given=["robot_goal"])
        return replace(naive, post=uniform)


@pytest.mark.parametrize(
    ("chooser", "complaint"),
    [
        (Last(), "least score|absent"),
        (FirstListed(), "order in which goals are listed"),
        (NearTheOrigin(), "where the whole scene is"),
        (Undecided(), "twice differently"),
        (Wasteful(), "absent goal is a post goal"),
    ],
)
def test_a_chooser_that_breaks_a_law_is_told_which(chooser, complaint):
    with pytest.raises(AssertionError, match=complaint):
        check_goal_chooser(chooser, examples=20)
