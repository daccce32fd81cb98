"""Examples for learned prediction: games side by side are the games of the seats, and data of any size are the same."""

import json
from dataclasses import replace

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.studies.prediction_examples import ExampleStore
from ppsim.cli import main
from ppsim.errors import SimulationError
from ppsim.reaching import ReachingWorld, Rules
from ppsim.reaching.examples import ExampleStudy, record_examples
from ppsim.reaching.humans import make_human
from ppsim.reaching.many_games import KINDS, GameRules, ManyGames
from ppsim.reaching.movement import Movement

SMALL = ExampleStudy(seed=3, games=3, instants=2, continuations=2, every=0.5, limit=3.0)


@pytest.mark.parametrize("kind", KINDS)
def test_games_side_by_side_go_as_seats_play_them_step_by_step(kind):
    movement, noise, seeds = Movement(), 0.4, range(4)
    worlds = [ReachingWorld(Rules(goals=4), movement.dynamics) for _ in seeds]
    seen = [world.reset(seed) for world, seed in zip(worlds, seeds, strict=True)]
    seats = [make_human(kind, movement, noise=noise) for _ in seeds]
    for seat, seed in zip(seats, seeds, strict=True):
        seat.reset(np.random.default_rng(seed))
    draws = [np.random.default_rng(seed) for seed in seeds]
    games = ManyGames.start(
        np.stack([each["human"].state for each in seen]),
        np.stack([each["robot"].state for each in seen]),
        np.stack([each["human"].goals for each in seen]),
        np.ones((4, 4), bool),
        np.full(4, KINDS.index(kind)),
    )
    rules, scored = GameRules(movement, noise), 0
    since = np.zeros(4, int)
    for _ in range(200):
        # never as long for one goal as for another since goals were new: of exact ties rounding decides
        robot_goal = (np.arange(4) + ((since >= 12) & (since < 19))) % 4
        since += 1
        drawn = np.stack([each.standard_normal(2) for each in draws])
        games = rules.step(games, robot_goal, drawn)
        for game, (world, seat) in enumerate(zip(worlds, seats, strict=True)):
            human, robot = seen[game]["human"], seen[game]["robot"]
            goal = robot.goals[robot_goal[game]]
            seen[game], _ = world.step(
                {"human": seat.act(human), "robot": movement.control(robot.state, goal)}
            )
            np.testing.assert_allclose(games.human[game], seen[game]["human"].state, atol=1e-9)
            np.testing.assert_allclose(games.robot[game], seen[game]["robot"].state, atol=1e-9)
            if seen[game]["human"].drawn != human.drawn:
                games = games.with_goals(game, seen[game]["human"].goals)
                since[game], scored = 0, scored + 1
    assert scored > 0


def same(one, other):
    for name in ("human", "robot", "plan", "goals", "present", "frequency", "robot_goal"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


def test_the_first_examples_are_the_same_however_many_follow_and_whoever_made_them(tmp_path):
    record_examples(SMALL, 20, tmp_path / "whole.zarr")
    record_examples(SMALL, 20, tmp_path / "parallel.zarr", workers=2)
    for count in (4, 11, 20):
        told = []
        resumed = record_examples(
            SMALL, count, tmp_path / "parts.zarr", progress=lambda *done, told=told: told.append(done)
        )
        assert told[0] == (resumed, count)
        assert told[-1] == (count, count)
    assert resumed == 11
    whole = ExampleStore(tmp_path / "whole.zarr")
    for name in ("parallel", "parts"):
        store = ExampleStore(tmp_path / f"{name}.zarr")
        same(store.read(0, 20), whole.read(0, 20))
        np.testing.assert_array_equal(store.kinds(0, 20), whole.kinds(0, 20))
        assert store.interaction(0, 20) == whole.interaction(0, 20)


def test_plans_follow_the_dynamics_and_lead_to_the_goal_that_they_are_said_to():
    examples = SMALL.batch(0).examples
    dynamics = SMALL.movement.dynamics
    steps = np.concatenate([examples.robot[:, -1:], examples.plan], axis=1)
    control = np.diff(steps[..., [1, 3]], axis=1) / 0.1
    np.testing.assert_allclose(dynamics.step(steps[:, :-1], control), steps[:, 1:], atol=1e-4)
    goal = examples.goals[np.arange(len(examples)), examples.robot_goal]
    before, after = (np.linalg.norm(steps[:, t][:, [0, 2]] - goal, axis=1) for t in (0, -1))
    assert (after < np.maximum(0.4 * before, 0.5)).all()


def test_a_stubborn_human_without_noise_goes_for_the_nearest_goal_every_time():
    study = ExampleStudy(
        seed=1, games=20, instants=1, continuations=3, noise=0.0, humans=("stubborn",), goals=(3,)
    )
    examples = study.batch(0).examples
    away = np.linalg.norm(examples.goals - examples.human[:, -1:, [0, 2]], axis=-1)
    assert set(examples.frequency.max(axis=1).tolist()) == {1.0}
    # one that it passes on the way there would count, and none lies nearer than the nearest
    np.testing.assert_array_equal(examples.frequency.argmax(axis=1), away.argmin(axis=1))


def test_frequencies_are_of_as_many_continuations_and_absent_goals_are_never_reached():
    stored = ExampleStudy(seed=2, games=30, instants=1, continuations=5, goals=(2, 4)).batch(0)
    frequency = stored.examples.frequency
    np.testing.assert_allclose(frequency * 5, np.rint(frequency * 5), atol=1e-5)
    assert not frequency[~stored.examples.present].any()
    assert set(stored.examples.present.sum(axis=1).tolist()) == {2, 4}
    assert (stored.interaction > 1.0).all()


def test_examples_made_otherwise_are_not_mixed(tmp_path):
    record_examples(SMALL, 3, tmp_path / "d.zarr")
    with pytest.raises(LogError, match=r"noise is 0\.5, not 0\.1"):
        record_examples(replace(SMALL, noise=0.1), 3, tmp_path / "d.zarr")
    with pytest.raises(SimulationError, match="already holds 3 examples, more than the 2 asked for"):
        record_examples(SMALL, 2, tmp_path / "d.zarr")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"continuations": 0}, "continuations must be at least 1"),
        ({"noise": -1.0}, "noise must be finite"),
        ({"noise": 1e200}, "noise must be finite"),
        ({"goals": (1,)}, "goals must be at least 2"),
        ({"humans": ("shy",)}, "humans must be some of waiting, moving, stubborn; got shy"),
        ({"keep": 1.5}, "keep must be a probability"),
        ({"every": 0.01}, "every must be at least one step"),
        ({"goals": (3, 99)}, "do not fit"),
    ],
)
def test_what_cannot_be_generated_is_refused(options, message):
    with pytest.raises(SimulationError, match=message):
        ExampleStudy(**options)


def test_the_command_says_what_is_there_and_goes_on_with_it(tmp_path, capsys):
    line = [
        "examples",
        "6",
        "-o",
        str(tmp_path / "d.zarr"),
        "--seed",
        "4",
        "--continuations",
        "1",
        "--limit",
        "1",
    ]
    assert main(line) == 0
    assert "6 examples from" in capsys.readouterr().out
    assert main([*line[:1], "8", *line[2:], "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["examples"], told["examples_resumed"]) == (8, 6)
    assert told["configuration"]["continuations"] == 1
