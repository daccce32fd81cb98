"""Both papers' hypotheses in one posterior, on the reaching game: where a human is heading, and whether it yields."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ppinfer import Distribution, Factor
from ppinfer.coordination import GoalChoiceGame
from ppinfer.goals import Observation, infer_goals
from ppinfer.goals.yielding import OnlineYielding, Yielding
from ppinfer.studies import encounter_evidence, log_of_trials
from ppsim.reaching.game_study import GameStudy

GAMES = 10


@pytest.fixture(scope="module")
def log():
    """Return games of 10 s with a robot that heads for its nearest goal, and humans who yield to it or do not."""
    study = GameStudy(games=GAMES, robots=("naive",), humans=("moving", "stubborn"), seed=21, duration=10.0)
    told = study.header()
    return log_of_trials(
        [study.trial(index) for index in range(study.trials)],
        agents=told.agents,
        goals=told.goals,
        has_velocity=told.has_velocity,
    )


@pytest.fixture(scope="module")
def evidence(log):
    """Return the motion of both agents."""
    return encounter_evidence(log)


def of_true_theta(log, posterior):
    """Return the posterior over theta at the end of each game, and whether the human is one who favours itself."""
    last = np.cumsum(log.row_size.values) - 1
    theta = posterior.marginal("theta")
    assert theta.axis("theta").labels == ("robot", "human")
    stubborn = log.controller.sel(agent="human").values.astype(str) == "stubborn"
    return theta.log_values[last], stubborn


def separation(log_theta, stubborn):
    """Return the area under the curve, and the mean log posterior of what is true."""
    favours_itself = log_theta[:, 1]
    area = (favours_itself[stubborn][:, None] > favours_itself[~stubborn]).mean()
    return area, log_theta[np.arange(len(stubborn)), stubborn.astype(int)].mean()


@pytest.mark.parametrize(
    ("model", "least_area", "least_score"),
    [(Yielding(), 0.85, -0.6), (Yielding(reaction=GoalChoiceGame()), 0.95, -0.3)],
    ids=["softmax", "equilibria"],
)
def test_humans_who_yield_and_humans_who_do_not_are_told_apart(log, evidence, model, least_area, least_score):
    posterior = model.infer(evidence)
    area, score = separation(*of_true_theta(log, posterior))
    assert area >= least_area
    assert score >= least_score
    # and where the human is heading is known at least as well as without theta
    pursued = log.pursued.sel(agent="human").values
    going = np.flatnonzero(pursued >= 0)
    with_theta, alone = (
        belief.log_values[going, pursued[going]].mean()
        for belief in (
            posterior.marginal("goal"),
            infer_goals(model.motion, evidence.human).distribution,
        )
    )
    assert with_theta >= alone - 0.002


def test_the_first_papers_personality_is_a_prior_and_its_evidence_a_factor_of_the_same_posterior(evidence):
    model = Yielding(reaction=GoalChoiceGame())
    even = model.infer(evidence)
    elsewhere = Distribution.from_probabilities([model.theta], [0.85, 0.15])
    assert_allclose(
        even.update(Factor(elsewhere.axes, elsewhere.log_values)).values,
        model.infer(evidence, prior=elsewhere).values,
        atol=1e-12,
    )
    # the chain rule, spelled out: p(goal, theta) = p(goal | theta) p(theta)
    last = Distribution(even.axes[1:], even.log_values[-1])
    rebuilt = last.given("theta") * last.marginal("theta")
    assert_allclose(rebuilt.align("goal", "theta").log_values, last.log_values, atol=1e-9)


def test_a_robot_that_watches_one_game_holds_the_same_belief_live(log, evidence):
    model = Yielding(reaction=GoalChoiceGame())
    offline = model.infer(evidence)
    human, robot = evidence.human, evidence.robot
    online = OnlineYielding(model, dt=human.dt, labels=human.goal_labels)
    for row in np.flatnonzero(evidence.encounter == 0):
        online.restart(human.goals[row])
        for sample in np.flatnonzero(human.row_of_sample == row):
            joint = online.observe(
                *(
                    Observation(float(agent.time[sample]), agent.position[sample], agent.velocity[sample])
                    for agent in (human, robot)
                )
            )
            assert_allclose(joint.values, offline.values[sample], atol=1e-10)
