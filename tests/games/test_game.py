"""A game holds costs over named plans, and refuses what is none."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

from ppinfer import Axis, AxisError
from ppinfer.errors import GameError
from ppinfer.games import Game, pure_equilibria

PLAYERS = ["robot", "human"]
TWO_BY_THREE = np.arange(12.0).reshape(2, 2, 3)


def test_plan_axes_are_named_for_the_players():
    game = Game(TWO_BY_THREE, PLAYERS)
    assert game.plans == (Axis("robot_plan", 2), Axis("human_plan", 3))
    assert game.players == ("robot", "human")
    assert game.player("human") == 1


def test_players_whose_names_are_no_identifiers_still_get_plan_axes_of_different_names():
    game = Game(np.zeros((4, 1, 1, 1, 1)), ["Player 1", "Player-1", "2", ""])
    names = [axis.name for axis in game.plans]
    assert names[:3] == ["Player_1_plan", "Player_1_plan_2", "player_2_plan"]
    assert len(set(names)) == 4


def test_batch_axes_come_before_the_player():
    trial = Axis("trial", ["a", "b"])
    game = Game(np.zeros((2, 2, 2, 3)), PLAYERS, batch=[trial])
    assert [axis.name for axis in game.axes] == ["trial", "robot_plan", "human_plan"]
    assert game.batch == (trial,)


def test_costs_are_a_read_only_copy():
    costs = TWO_BY_THREE.copy()
    game = Game(costs, PLAYERS)
    costs[0, 0, 0] = 99.0
    assert game.costs[0, 0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        game.costs[0, 0, 0] = 1.0
    with pytest.raises(AttributeError):
        game.costs = costs


@pytest.mark.parametrize(
    ("value", "shown"), [(np.nan, "nan"), (-np.inf, "-inf")], ids=["not a number", "minus infinity"]
)
def test_a_cost_that_is_none_is_refused_by_its_cell(value, shown):
    costs = TWO_BY_THREE.copy()
    costs[1, 0, 2] = value
    with pytest.raises(
        GameError, match=f"cost is {shown} at player='human', robot_plan=0, human_plan=2; costs"
    ):
        Game(costs, PLAYERS)


def test_infinite_costs_are_held():
    assert Game(np.full((2, 2, 3), np.inf), PLAYERS).costs.min() == np.inf


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros((3, 2, 3)), PLAYERS), r"shape \(3, 2, 3\).* calls for \(2, 2, 3\)"),
        ((np.zeros((2, 2)), PLAYERS), "call for 3 dimensions"),
        ((np.zeros((2, 2, 3)), ["robot", "robot"]), "two players are called 'robot'"),
        ((np.zeros((2, 2, 3)), "ab"), "not one string"),
        ((np.zeros(0), []), "at least one player"),
        (([["a", "b"]], PLAYERS), "must be real numbers"),
        (([[[1.0], [1.0, 2.0]]], PLAYERS), "rectangular grid"),
        ((np.zeros((2, 2, 3)), PLAYERS, [Axis("a", 2)]), "1 plan axes; each player has one"),
        ((np.zeros((2, 2, 3)), PLAYERS, [Axis("a", 2), Axis("b", 4)]), r"calls for \(2, 2, 4\)"),
    ],
)
def test_what_does_not_fit_is_refused(arguments, message):
    with pytest.raises(GameError, match=message):
        Game(*arguments)


def test_axes_share_no_name():
    with pytest.raises(AxisError, match="two axes of the game are called 'plan'"):
        Game(np.zeros((2, 2, 2)), PLAYERS, [Axis("plan", 2), Axis("plan", 2)])


def test_an_unknown_player_is_refused_by_name():
    with pytest.raises(GameError, match="no player 'guest'; there are robot, human"):
        Game(TWO_BY_THREE, PLAYERS).player("guest")


def test_absent_profiles_hold_no_cost():
    costs = TWO_BY_THREE.copy()
    costs[:, 1, 1] = np.nan
    present = np.ones((2, 3), bool)
    present[1, 1] = False
    game = Game(costs, PLAYERS, present=present)
    assert (game.costs[:, 1, 1] == np.inf).all()
    assert not game.present[1, 1]
    with pytest.raises(GameError, match=r"bool of shape \(2, 3\)"):
        Game(costs, PLAYERS, present=np.ones((3, 2), bool))
    with pytest.raises(GameError, match="got int64"):
        Game(costs, PLAYERS, present=present.astype(int))


def test_a_mask_that_leaves_nothing_out_is_no_mask():
    assert Game(TWO_BY_THREE, PLAYERS, present=np.ones((2, 3), bool)) == Game(TWO_BY_THREE, PLAYERS)


def test_restriction_picks_plans_and_games():
    costs = np.arange(48.0).reshape(4, 2, 2, 3)
    present = np.ones((4, 2, 3), bool)
    present[2, 0, 0] = False
    trial = Axis("trial", ["a", "b", "c", "d"])
    plans = [Axis("robot_plan", ["left", "right"]), Axis("human_plan", 3)]
    game = Game(costs, PLAYERS, plans, [trial], present)
    some = game.restrict(trial="c", human_plan=[2, 0], robot_plan="right")
    assert some.batch == ()
    assert some.plans == (Axis("robot_plan", ["right"]), Axis("human_plan", [2, 0]))
    assert np.array_equal(some.costs, costs[2][:, 1:, [2, 0]])
    assert some.present is None
    assert not game.restrict(trial=["c", "a"]).present[0, 0, 0]
    assert game.restrict(trial=["c", "a"]).batch == (Axis("trial", ["c", "a"]),)
    with pytest.raises(AxisError, match="no axis 'goal'"):
        game.restrict(goal=1)


def test_games_are_equal_by_value_and_survive_pickling():
    game = Game(TWO_BY_THREE, PLAYERS, present=TWO_BY_THREE[0] > 0.0)
    assert pickle.loads(pickle.dumps(game)) == game
    assert copy.deepcopy(game) == game
    assert game != Game(TWO_BY_THREE, PLAYERS)
    assert game != Game(TWO_BY_THREE, ["robot", "other"], game.plans, present=game.present)
    assert game != "a game"


def test_a_notebook_shows_the_table_with_its_equilibria():
    game = Game([[[1.0, 4.0], [2.0, np.inf]], [[1.0, 2.0], [1.0, np.inf]]], PLAYERS)
    shown = game._repr_html_()
    assert "<b>1, 1</b>" in shown
    assert "<td>4, 2</td>" in shown
    assert "inf, inf" in shown
    absent = Game(game.costs, PLAYERS, present=[[True, True], [True, False]])
    assert "absent" in absent._repr_html_()
    labelled = Game(game.costs, PLAYERS, [Axis("r", ["<b>", "x"]), Axis("h", 2)])
    assert "<th>&lt;b&gt;</th>" in labelled._repr_html_()


def test_a_notebook_shows_of_many_games_what_they_are():
    game = Game(np.zeros((5, 2, 2, 3)), PLAYERS, batch=[Axis("trial", 5)])
    assert repr(game) == "Game of robot, human: trial 5, robot_plan 2, human_plan 3"
    assert "<table>" not in game._repr_html_()
    assert "<table>" not in Game(np.zeros((3, 2, 2, 2)), ["a", "b", "c"])._repr_html_()


def test_a_game_may_have_one_player_and_a_million_plans():
    game = Game(np.arange(1e6)[None], ["robot"])
    assert pure_equilibria(game).log_values[0] == 0.0
    assert pure_equilibria(game).sum().values == 1.0


def test_complex_costs_are_refused():
    with pytest.raises(GameError, match="real numbers"):
        Game(np.zeros((2, 2, 2), complex), PLAYERS)
