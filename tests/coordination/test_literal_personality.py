"""(5)-(10) as printed, against loops in plain Python; and why they are repaired."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from ppinfer.coordination import (
    LiteralPersonality,
    PlayHistory,
    TrajectoryLikelihood,
    coordination_equilibria,
    infer_personality,
)
from ppinfer.testing import example_trial

DT = 0.1


def state_of_plan(plans, plan, when):
    """Return position and velocity of one plan at one time, from its waypoints."""
    start = int(plans.row_size[:plan].sum())
    times = [float(one) for one in plans.time[start : start + plans.row_size[plan]]]
    where = [[float(x) for x in one] for one in plans.position[start : start + plans.row_size[plan]]]
    if when <= 0.0:
        return [*where[0], *([0.0] * len(where[0]))]
    for k in range(1, len(times)):
        if when <= times[k]:
            share = (when - times[k - 1]) / (times[k] - times[k - 1])
            here = [a + share * (b - a) for a, b in zip(where[k - 1], where[k], strict=True)]
            speed = [(b - a) / (times[k] - times[k - 1]) for a, b in zip(where[k - 1], where[k], strict=True)]
            return [*here, *speed]
    return [*where[-1], *([0.0] * len(where[0]))]


def literally(trial, upto):
    """Return p(theta | H) at a replan of a trial, equation by equation."""
    first = trial[0]
    seen, clock = [], 0
    for turn, situation in enumerate(trial[1 : upto + 1]):
        for sample in range(0 if turn == 0 else 1, len(situation.motion.position)):
            states = [
                [
                    *map(float, situation.motion.position[sample, agent]),
                    *map(float, situation.motion.velocity[sample, agent]),
                ]
                for agent in range(len(first.agents))
            ]
            seen.append((clock * DT if turn == 0 else (clock + sample) * DT, states))
            clock += turn == 0
        clock += 0 if turn == 0 else len(situation.motion.position) - 1
        if turn == 0:
            clock -= 1
    profiles = [tuple(cell) for cell in np.argwhere(coordination_equilibria(first.game).values).tolist()]
    thetas = range(len(first.agents))
    if not profiles:
        return [1 / len(first.agents)] * len(first.agents)
    weight = {}
    for profile in profiles:
        squares = []
        for when, states in seen:
            for agent, state in enumerate(states):
                if any(math.isnan(x) for x in state[: len(state) // 2]):
                    continue
                expected = state_of_plan(first.plans[agent], profile[agent], when)
                squares += [(x - y) ** 2 for x, y in zip(state, expected, strict=True)]
        weight[profile] = -10.0 * math.sqrt(math.fsum(squares))
    top = max(weight.values())
    p_history = {profile: math.exp(value - top) for profile, value in weight.items()}
    total = math.fsum(p_history.values())
    favours = {
        profile: [
            # costs are sums of durations: less by rounding is not less
            all(
                first.game.costs[(i, *profile)] < first.game.costs[(j, *profile)] - 1e-9
                for j in thetas
                if j != i
            )
            for i in thetas
        ]
        for profile in profiles
    }
    size = [sum(favours[profile][theta] for profile in profiles) for theta in thetas]
    posterior = [0.0] * len(size)
    for profile in profiles:
        given = [favours[profile][theta] / size[theta] if size[theta] else 0.0 for theta in thetas]
        for theta in thetas:
            # (10), which says nothing where it is 0 / 0
            of_theta = given[theta] / sum(given) if sum(given) else 1 / len(size)
            posterior[theta] += p_history[profile] / total * of_theta
    return posterior


@pytest.mark.parametrize("seed", range(12))
def test_the_posterior_is_the_printed_one_at_every_replan(seed):
    rng = np.random.default_rng(seed)
    agents = ("robot", "human", "guest")[: 2 + (seed % 4 == 3)]
    trial = example_trial(
        rng,
        replans=4,
        agents=agents,
        plans=(4, 4, 3)[: len(agents)],
        colliding=0.6,
        durations=(1.0, 2.0) if seed % 2 else (),
        leaves=seed % 3 == 0,
    )
    history = PlayHistory.from_situations([trial], "robot")
    found = infer_personality(LiteralPersonality(), history, "robot").values
    expected = [literally(trial, upto) for upto in range(len(trial))]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


def test_6_is_the_trajectory_likelihood_since_the_start_of_the_trial():
    trial = example_trial(np.random.default_rng(5), replans=2, plans=(5, 5), colliding=0.6, held=0.0)
    first, second = trial
    p_history = (
        TrajectoryLikelihood()
        .log_likelihood(first.plans, second.motion)
        .where(coordination_equilibria(first.game))
        .normalize("robot_plan", "human_plan")
    )
    cost = first.game.costs
    assert (cost[0] != cost[1])[p_history.values > 0].all()
    found = infer_personality(LiteralPersonality(), PlayHistory.from_situations([trial], "robot"), "robot")
    expected = [p_history.values[cost[0] < cost[1]].sum(), p_history.values[cost[1] < cost[0]].sum()]
    np.testing.assert_allclose(found.values[1], expected, rtol=1e-9)


def test_p_alpha_is_uniform_at_the_start_of_a_trial_and_not_only_then_consistent_with_9():
    for seed in range(20):
        (situation,) = example_trial(np.random.default_rng(seed), replans=1, durations=(1.0, 2.0))
        state = LiteralPersonality().observe(situation, "robot", None)
        if state.equilibria.any():
            np.testing.assert_allclose(state.p_alpha.values[state.equilibria], 1 / state.equilibria.sum())


def test_where_all_equilibria_favour_one_agent_theta_is_certain_whatever_anybody_does():
    certain = 0
    for seed in range(30):
        trial = example_trial(np.random.default_rng(seed), replans=3, plans=(4, 4))
        cost = trial[0].game.costs[:, coordination_equilibria(trial[0].game).values > 0]
        if cost.size and (cost[0] < cost[1]).all():
            certain += 1
            history = PlayHistory.from_situations([trial], "robot")
            assert (
                infer_personality(LiteralPersonality(), history, "robot").prob(theta="robot").tolist()
                == [1.0] * 3
            )
    assert certain >= 3


def test_a_plan_that_has_ended_stays_at_its_last_state():
    trial = example_trial(np.random.default_rng(0), replans=2, plans=(2, 2))
    plans = trial[0].plans[0]
    for plan, when in itertools.product(range(2), (0.0, 0.3, 99.0)):
        state = [*plans.positions([when])[plan, 0], *plans.velocities([when])[plan, 0]]
        np.testing.assert_allclose(state, state_of_plan(plans, plan, when), atol=1e-12)
