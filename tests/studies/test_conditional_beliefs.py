import json
from dataclasses import replace

import numpy as np
import pytest

from ppinfer.errors import LogError, ModelError
from ppinfer.goals import GoalLQR
from ppinfer.goals.conditional import SoftmaxConditional, overall_post
from ppinfer.goals.mental_model import paper_agent
from ppinfer.goals.prediction import BehaviourPredictor
from ppinfer.goals.reacted import ReactedConditional
from ppinfer.studies import build_log, infer_log_conditional, select_trials
from ppinfer.studies.assumed_reactions import assumed_agent, assumed_reaction, robots_of_ones_own
from ppinfer.studies.conditional_beliefs import other_agent, pursued_goals
from ppinfer.testing import example_interaction_log, example_log
from ppsim.reaching import GameStudy
from ppsim.reaching.robots import ROBOTS
from ppsim.study import log_of_study


def step_by_step(log, conditional, **models):
    """Return the beliefs of one trial as a robot holds them live, sample by sample."""
    labels = [str(goal) for goal in log["goal"].values]
    predictor = BehaviourPredictor(**models, dt=0.1, labels=labels)
    moving = log["goal_position"].dims[0] == "sample"
    told = {name: [] for name in ("log_belief", "log_mental_model", "log_post", "log_overall")}
    before = None
    velocity = log["velocity"].values if "velocity" in log else np.full(log["position"].shape, np.nan)
    for sample, now in enumerate(log["time"].values):
        goals = log["goal_position"].values[sample if moving else 0]
        present = ~np.isnan(goals).any(axis=1)
        if before is None or not np.array_equal(goals, before, equal_nan=True):
            predictor.restart(np.nan_to_num(goals), present=present, keep_history=True)
            before = goals
        human, robot = log["position"].values[sample]
        fast = [None if np.isnan(one).any() else one for one in velocity[sample]]
        seen = None if np.isnan(human).any() else human
        situation = predictor.observe(now, seen, fast[0], robot, fast[1], None)
        post = conditional.post(situation)
        told["log_belief"].append(situation.belief.log_values)
        told["log_mental_model"].append(situation.mental_model.log_values)
        told["log_post"].append(post.log_values)
        told["log_overall"].append(overall_post(post, situation.mental_model).log_values)
    return {name: np.exp(np.array(values)) for name, values in told.items()}


@pytest.mark.parametrize(
    "conditional", [SoftmaxConditional(), ReactedConditional(SoftmaxConditional(1.0, 2.0, 0.5, 0.3))]
)
def test_offline_beliefs_are_those_that_a_robot_holds_step_by_step(conditional):
    log = example_interaction_log()
    beliefs = infer_log_conditional(log, conditional=conditional)
    for trial in range(2):
        live = step_by_step(select_trials(log, [trial]), conditional)
        here = slice(30 * trial, 30 * (trial + 1))
        for name, values in live.items():
            np.testing.assert_allclose(np.exp(beliefs[name].values[here]), values, atol=1e-10, err_msg=name)


def test_goals_that_move_or_are_absent_and_a_human_out_of_sight_are_as_they_are_live():
    log = example_interaction_log(trials=1)
    position = log["position"].values.copy()
    position[12:16, 0] = np.nan
    goals = np.repeat(log["goal_position"].values, 30, axis=0)
    goals[18:] += 1.0
    goals[24:, 2] = np.nan
    moved = build_log(
        agents=["human", "robot"],
        goals=["0", "1", "2"],
        row_size=[30],
        time=log["time"].values,
        position=position,
        goal_position=goals,
    )
    conditional = ReactedConditional(SoftmaxConditional(1.0, 2.0, 0.5, 0.3))
    models = {"human_model": GoalLQR(rationality=0.01, stay=0.95), "robot_model": paper_agent(1e-3)}
    live = step_by_step(moved, conditional, **models)
    beliefs = infer_log_conditional(
        moved, models["human_model"], robot_model=models["robot_model"], conditional=conditional
    )
    for name, values in live.items():
        np.testing.assert_allclose(np.exp(beliefs[name].values), values, atol=1e-10, err_msg=name)
    assert (beliefs["log_post"].values[24:, :, 2] == -np.inf).all()


def test_a_human_not_yet_seen_has_no_reaction():
    log = example_interaction_log(trials=1)
    position = log["position"].values.copy()
    position[:3, 0] = np.nan
    blind = build_log(
        agents=["human", "robot"],
        goals=["0", "1", "2"],
        row_size=[30],
        time=log["time"].values,
        position=position,
        goal_position=log["goal_position"].values,
    )
    beliefs = infer_log_conditional(blind)
    unmoved = np.repeat(beliefs["log_belief"].values[:, None], 3, axis=1)
    np.testing.assert_array_equal(beliefs["log_post"].values[:3], unmoved[:3])
    assert not np.allclose(beliefs["log_post"].values[3], unmoved[3])


def test_given_is_the_row_of_the_goal_that_the_robot_had_and_the_average_where_it_had_none():
    log = example_interaction_log(trials=1)
    log["pursued"].values[:5, 1] = -1
    beliefs = infer_log_conditional(log)
    assert beliefs["robot_goal_index"].values.tolist() == [-1] * 5 + [1] * 25
    np.testing.assert_array_equal(beliefs["log_given"].values[:5], beliefs["log_overall"].values[:5])
    np.testing.assert_array_equal(beliefs["log_given"].values[5:], beliefs["log_post"].values[5:, 1])


def test_what_an_agent_pursues_is_read_from_whatever_the_log_says():
    log = example_interaction_log(trials=2)
    said = pursued_goals(log, "human")
    named = log.drop_vars("pursued").assign(human_goal_index=("sample", said.astype(np.int8)))
    np.testing.assert_array_equal(pursued_goals(named, "human"), said)
    np.testing.assert_array_equal(pursued_goals(log.drop_vars("pursued"), "human"), said)
    assert (pursued_goals(log.drop_vars("pursued"), "robot") == -1).all()


def test_a_human_who_could_take_either_goal_is_expected_to_leave_the_robots():
    log = example_interaction_log(trials=1)
    beliefs = infer_log_conditional(log)
    before, given = (np.exp(beliefs[name].values[5]) for name in ("log_belief", "log_given"))
    assert before.argmax() == 1  # which is the robot's as well
    assert given[1] < 0.01


def test_what_the_beliefs_were_made_with_is_said():
    conditional = SoftmaxConditional.study_people()
    attrs = infer_log_conditional(example_interaction_log(trials=1), conditional=conditional).attrs
    said = json.loads(attrs["configuration"])
    assert (attrs["agent"], attrs["partner"]) == ("human", "robot")
    assert said["conditional"]["parameters"]["robot_weight"] == 3.0
    assert said["model"]["parameters"]["rationality"] == 3e-4


def test_one_agent_alone_or_an_unknown_one_is_refused():
    with pytest.raises(LogError, match="need one beside 'human'; the log has none"):
        infer_log_conditional(example_log(participants=1, trials=1))
    with pytest.raises(LogError, match="cannot react to 'dog'; the log has 'robot'"):
        other_agent(example_interaction_log(), "human", "dog")


def test_a_conditional_that_needs_situations_one_by_one_is_refused():
    other = ReactedConditional(ReactedConditional())
    with pytest.raises(ModelError, match="need a SoftmaxConditional, or a ReactedConditional of one"):
        infer_log_conditional(example_interaction_log(), conditional=other)


def test_a_simulated_games_own_agents_and_reactions_are_taken_from_its_log():
    log = example_interaction_log()
    said = {"world": "reaching-game", "reaction": "reacted", "rationality": 1e-3, "control_weight": 2.0}
    log.attrs["configuration"] = json.dumps(said)
    assert assumed_agent(log) == replace(paper_agent(1e-3), control_weight=2.0)
    assert assumed_reaction(log, "influence").conditional == ReactedConditional()
    assert assumed_reaction(log, "courtesy").conditional == SoftmaxConditional()
    assert assumed_reaction(log, "naive").conditional is None
    for other in ("{", "[]", json.dumps({**said, "world": "another"})):
        log.attrs["configuration"] = other
        assert assumed_agent(log) == paper_agent()
        assert assumed_reaction(log, "naive").conditional == SoftmaxConditional()


@pytest.mark.parametrize("reaction", ["reacted", "softmax"])
def test_what_is_inferred_of_a_game_is_what_its_robot_held_live_whichever_robot_it_is(reaction):
    study = GameStudy(
        robots=ROBOTS, humans=("moving",), duration=4.0, seed=5, goals=(3, 4), reaction=reaction
    )
    log = log_of_study(study, range(study.trials))
    beliefs = infer_log_conditional(log)
    robot = np.repeat(log["controller"].sel(agent="robot").values.astype(str), log["row_size"].values)
    assert set(robot) == set(ROBOTS)
    for name in ROBOTS:
        for inferred, live in (
            ("log_belief", "live_log_belief"),
            ("log_mental_model", "live_log_mental_model"),
            ("log_given", "live_log_post"),
        ):
            np.testing.assert_allclose(
                np.exp(beliefs[inferred].values[robot == name]),
                np.exp(log[live].values[robot == name]),
                atol=1e-9,
                err_msg=f"{name}: {live}",
            )
    said = json.loads(beliefs.attrs["configuration"])["conditional"]["by_robot"]
    assert set(said) == set(ROBOTS)
    assert said["switching"] == f"softmax, {reaction} while the human looks unsure"


def test_a_robot_of_ones_own_is_said_to_be_one():
    log = example_interaction_log()
    log.attrs["configuration"] = json.dumps({"world": "reaching-game", "reaction": "reacted"})
    log["controller"] = (
        ("trial", "agent"),
        np.array([["moving", "mine:Robot"], ["moving", "naive"]], object),
    )
    assert robots_of_ones_own(log, "robot") == ("mine:Robot",)
    said = json.loads(infer_log_conditional(log).attrs["configuration"])["conditional"]["by_robot"]
    assert said["mine:Robot"].startswith("reacted (the log does not say")
