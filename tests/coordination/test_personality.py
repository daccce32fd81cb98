"""The repaired posterior: by hand, repair by repair, and the same online as offline."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from jaxtyping import TypeCheckError

from ppinfer.coordination import (
    LiteralPersonality,
    Motion,
    Personality,
    PlayDesign,
    PlayHistory,
    coordination_equilibria,
    infer_personality,
)
from ppinfer.errors import ImpossibleEvidenceError, ModelError
from ppinfer.testing import example_trial, histories
from tests.coordination.test_figure1 import seen, table


def by_hand(trial, model):
    """Return p(theta) of two agents at every replan of a trial, step by step in plain Python."""
    belief = [0.5, 0.5]
    found = [belief]
    for before, now in itertools.pairwise(trial):
        belief = [model.stay * belief[t] + (1 - model.stay) * belief[1 - t] for t in (0, 1)]
        executed = [k for k in range(1, len(now.motion.held)) if not now.motion.held[k]]
        stride = round(model.every / now.motion.dt)
        counted = list(range(stride, len(executed) + 1, stride)) or ([len(executed)] if executed else [])
        states = [(step, now.motion.position[executed[step - 1], 1]) for step in counted]
        states = [(step, where) for step, where in states if not np.isnan(where).any()]
        cells = [tuple(cell) for cell in np.argwhere(coordination_equilibria(before.game).values).tolist()]
        likelihood = []
        for theta in (0, 1):
            fits = []
            for cell in cells:
                cost = [float(before.game.costs[(i, *cell)]) for i in (0, 1)]
                if cost[theta] <= cost[1 - theta] + 1e-9:
                    far = math.fsum(
                        float(x) ** 2
                        for step, where in states
                        for x in where - before.plans[1].positions([step * now.motion.dt])[cell[1], 0]
                    )
                    fits.append(math.exp(-model.rationality * math.sqrt(far)))
            likelihood.append(math.fsum(fits) / len(fits) if fits else None)
        if states and None not in likelihood:
            share = model.contamination
            weight = [(1 - share) * one / math.fsum(likelihood) + share / 2 for one in likelihood]
            belief = [b * w for b, w in zip(belief, weight, strict=True)]
            belief = [b / math.fsum(belief) for b in belief]
        found.append(belief)
    return found


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize(
    "model", [Personality(), Personality(stay=0.8, contamination=0.2, every=0.3)], ids=["", "other"]
)
def test_the_posterior_is_what_one_gets_step_by_step_in_plain_python(seed, model):
    trial = example_trial(
        np.random.default_rng(seed),
        replans=5,
        plans=(5, 5),
        colliding=0.6,
        held=0.1,
        durations=(1.0, 2.0) if seed % 2 else (),
        leaves=seed % 3 == 0,
    )
    history = PlayHistory.from_situations([trial], "robot")
    found = infer_personality(model, history, "robot").values
    np.testing.assert_allclose(found, by_hand(trial, model), rtol=1e-9)


@settings(max_examples=12)
@given(histories(max_trials=2, max_replans=4))
def test_online_and_offline_agree_for_every_repair_switched_off(history):
    plain = Personality()
    for model in (
        plain,
        replace(plain, reanchor=False),
        replace(plain, average=False),
        replace(plain, skip_empty=False),
        replace(plain, ties=False),
        replace(plain, contamination=0.0),
        replace(plain, stay=1.0),
        replace(plain, observed="all", velocities=True),
        LiteralPersonality(),
    ):
        offline = infer_personality(model, history, "robot").log_values
        online = []
        for trial, replans in enumerate(history.replan_row_size):
            state = None
            for replan in range(replans):
                state = model.observe(history.situation(trial, replan), "robot", state)
                online.append(state.log_belief)
        with np.errstate(invalid="ignore"):
            gap = np.where(np.stack(online) == offline, 0.0, np.abs(np.stack(online) - offline))
        assert gap.max() <= 1e-10


def test_with_every_repair_off_it_is_the_literal_one_where_nobody_was_held():
    literal = Personality(
        reanchor=False, average=False, skip_empty=False, ties=False, contamination=0.0,
        observed="all", velocities=True, every=0.1,
    )  # fmt: skip
    for seed in range(10):
        trial = example_trial(np.random.default_rng(seed), replans=4, plans=(4, 4), held=0.0)
        history = PlayHistory.from_situations([trial], "robot")
        np.testing.assert_allclose(
            infer_personality(literal, history, "robot").values,
            infer_personality(LiteralPersonality(), history, "robot").values,
            atol=1e-12,
        )


def test_a_fully_held_interval_and_an_agent_who_has_left_tell_nothing_but_theta_moves_on():
    model = Personality(stay=0.9)
    state = model.observe(table(), "robot", None)
    state = model.observe(table(seen(human=0.5)), "robot", state)
    p = state.belief.prob(theta="human")
    held, left = seen(human=0.5), seen(human=0.5)
    held.held[1:] = True
    left.position[1:, 1] = np.nan
    for motion in (held, left):
        after = model.observe(table(motion), "robot", state).belief.prob(theta="human")
        assert after == pytest.approx(0.9 * p + 0.1 * (1 - p), abs=1e-12)


def test_a_held_step_is_skipped_and_the_last_executed_sample_of_a_short_interval_counts():
    position = np.array([[[0.0], [x]] for x in (0.0, 0.02, 0.04, 0.04)])
    short = Motion(position, np.zeros_like(position), np.array([False, False, False, True]))
    cut = Motion(position[:3], np.zeros_like(position[:3]), np.zeros(3, bool))
    model = Personality()
    state = model.observe(table(), "robot", None)
    beliefs = [model.observe(table(motion), "robot", state).belief.values for motion in (short, cut)]
    np.testing.assert_array_equal(*beliefs)
    far = [math.exp(-10 * abs(0.04 - plan)) for plan in (0.0, 0.2 / 7.5)]
    weight = [0.96 * one / sum(far) + 0.02 for one in far]
    np.testing.assert_allclose(beliefs[0], weight, rtol=1e-9)


def test_an_ego_sees_the_others_and_not_itself_unless_asked():
    model = Personality()
    state = model.observe(table(), "robot", None)
    robot_moves = Motion(seen(0.5).position[:, ::-1].copy(), seen(0.5).velocity, seen(0.5).held)
    still = seen(0.0)
    np.testing.assert_array_equal(
        model.observe(table(robot_moves), "robot", state).belief.values,
        model.observe(table(still), "robot", state).belief.values,
    )
    everybody = replace(model, observed="all")
    start = everybody.observe(table(), "robot", None)
    assert everybody.observe(table(robot_moves), "robot", start).belief.prob(theta="robot") > 0.75


def test_nobody_is_written_off_for_ever():
    model = Personality()
    state = model.observe(table(), "robot", None)
    for _ in range(200):
        state = model.observe(table(seen(human=0.8 / 7.5)), "robot", state)
    assert state.belief.prob(theta="human") > 0.85
    turns = 0
    while state.belief.prob(theta="human") > 0.5:
        state = model.observe(table(seen(human=0.0)), "robot", state)
        turns += 1
    assert turns <= 5


def test_without_contamination_contradictions_are_refused_and_named():
    model = Personality(skip_empty=False, contamination=0.0, stay=1.0)
    only_robot, only_human = (one_sided(first) for first in (True, False))
    state = model.observe(only_robot(None), "robot", None)
    state = model.observe(only_human(seen(0.1)), "robot", state)
    assert state.belief.values.tolist() == [1.0, 0.0]
    with pytest.raises(ImpossibleEvidenceError, match="no personality is possible"):
        model.observe(table(seen(0.1)), "robot", state)


def one_sided(robot_first):
    """Return what makes situations whose equilibria all favour one agent: the other's only plan is slow."""
    from ppinfer.coordination import PlanSet, Situation

    slow, quick = ("human", "robot") if robot_first else ("robot", "human")

    def make(motion):
        plans = {
            agent: PlanSet(agent, [2], [0.0, duration], [[0.0], [1.0]])
            for agent, duration in ((slow, 9.0), (quick, 2.0))
        }
        return Situation.from_contacts([plans["robot"], plans["human"]], [[np.inf]], motion=motion)

    return make


def test_theta_is_recovered_from_simulated_trials():
    rng = np.random.default_rng(0)
    trials = [example_trial(rng, replans=8, plans=(5, 5), colliding=0.6, held=0.0) for _ in range(60)]
    evidence = PlayHistory.from_situations(trials, "robot").seen_by("robot")
    theta = np.repeat(rng.integers(2, size=60), 8)
    seen_then = Personality().simulate(PlayDesign(evidence, theta), rng)
    belief = infer_personality(Personality(), seen_then.history, "robot").values.reshape(60, 8, 2)
    right = belief[np.arange(60), :, theta[::8]]
    assert right[:, -1].mean() > 0.68
    assert right[:, -1].mean() > right[:, 1].mean() > 0.5


def test_simulation_leaves_the_ego_and_who_has_left_alone():
    rng = np.random.default_rng(0)
    trials = [example_trial(rng, replans=3, leaves=True) for _ in range(5)]
    evidence = PlayHistory.from_situations(trials, "robot").seen_by("robot")
    drawn = Personality().simulate(PlayDesign(evidence, np.zeros(15, np.int64)), rng).history
    before = evidence.history
    np.testing.assert_array_equal(drawn.position[:, 0], before.position[:, 0])
    np.testing.assert_array_equal(np.isnan(drawn.position), np.isnan(before.position))
    assert (drawn.position[:, 1] != before.position[:, 1])[~np.isnan(before.position[:, 1])].mean() > 0.8


@pytest.mark.parametrize(
    "wrong",
    [
        {"rationality": -1.0}, {"rationality": math.inf}, {"contamination": 1.1}, {"stay": -0.1}, {"every": 0.0},
        {"fair_within": -1.0}, {"observed": "nobody"}, {"dominance": "total"},
    ],
    ids=str,
)  # fmt: skip
def test_parameters_out_of_range_are_refused(wrong):
    # the checks of types that run in tests may come first
    with pytest.raises((ModelError, TypeCheckError)):
        Personality(**wrong)
