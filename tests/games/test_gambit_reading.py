"""Games are read from Gambit's own files, and bad files are refused with line and column."""

from __future__ import annotations

import re
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppinfer import Axis
from ppinfer.errors import GameError, GameFileError
from ppinfer.games import Game, pure_equilibria, read_nfg

HEAD = 'NFG 1 R "title" { "a" "b" } { 2 2 }\n'

SELTEN = """NFG 1 R "Selten (IJGT, 75), Figure 2, normal form"
{ "Player 1" "Player 2" } { 3 2 }

1 1 0 2 0 2 1 1 0 3 2 0
"""

LOOP = """NFG 1 R "Backward bend" { "Player 1" "Player 2" }

{ { "1" "2" }
{ "1" "2" }
}
"With a comment, which may
go over lines and say { 1 2 }."

{
{ "11" 6, 7 }
{ "12" 6, 7 }
{ "21" 7.32, 6 }
{ "22" 1, 4 }
}
1 3 2 4
"""


def equilibria(game):
    return [tuple(int(i) for i in cell) for cell in np.argwhere(pure_equilibria(game).values == 1.0)]


def test_payoffs_are_listed_with_the_first_players_strategy_varying_fastest():
    game = read_nfg(SELTEN)
    assert game.players == ("Player 1", "Player 2")
    assert game.plans == (Axis("Player_1_plan", 3), Axis("Player_2_plan", 2))
    assert np.array_equal(-game.costs[0], [[1, 1], [0, 0], [0, 2]])
    assert np.array_equal(-game.costs[1], [[1, 1], [2, 3], [2, 0]])


def test_outcomes_are_looked_up_by_number():
    game = read_nfg(LOOP)
    assert np.array_equal(-game.costs[0], [[6, 6], [7.32, 1]])
    assert np.array_equal(-game.costs[1], [[7, 7], [6, 4]])
    assert game.plans[0] == Axis("Player_1_plan", ["1", "2"])


def test_outcome_number_zero_pays_nothing():
    game = read_nfg('NFG 1 R "" { "a" "b" } { 2 1 } { { "only" 3 4 } } 0 1')
    assert np.array_equal(-game.costs, [[[0.0], [3.0]], [[0.0], [4.0]]])
    nothing = read_nfg('NFG 1 R "new" { "a" "b" } { { "1" "2" } { "1" "2" } } "" { } 0 0 0 0')
    assert not nothing.costs.any()


def test_three_players_and_more_are_read_in_order():
    sizes = (2, 3, 4)
    payoffs = [f"{a}{b}{c} {a} -{c}" for c in range(4) for b in range(3) for a in range(2)]
    game = read_nfg(f'NFG 1 R "" {{ "x" "y" "z" }} {{ 2 3 4 }} {" ".join(payoffs)}')
    for a, b, c in np.ndindex(*sizes):
        assert game.costs[:, a, b, c].tolist() == [-(100 * a + 10 * b + c), -a, c]


def test_payoffs_are_maximised_so_costs_are_their_negatives():
    dilemma = read_nfg('NFG 1 R "pd" { "1" "2" } { { "c" "d" } { "c" "d" } } 9 9 10 0 0 10 1 1')
    assert equilibria(dilemma) == [(1, 1)]
    assert dilemma.plans[0].name == "player_1_plan"


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("5/2", 2.5),
        ("-1/3", -1 / 3),
        ("+7", 7.0),
        (".5", 0.5),
        ("-.5", -0.5),
        ("5.", 5.0),
        ("1e3", 1000.0),
        ("-2.50E-1", -0.25),
        ("0.000000", 0.0),
        ("100000000000000000000001/3", 100000000000000000000001 / 3),
        ("1e-400", 0.0),
        ("9007199254740993", 9007199254740992.0),
    ],
)
def test_numbers_are_integers_decimals_rationals_and_powers_of_ten(text, number):
    game = read_nfg(f'NFG 1 D "" {{ "a" }} {{ 2 }} {text}, 1')
    assert -game.costs[0, 0] == number


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_line_ends_and_byte_order_marks_make_no_difference(tmp_path, end, mark):
    path = tmp_path / "game.nfg"
    path.write_bytes((mark + LOOP.replace("\n", end)).encode())
    assert read_nfg(path) == read_nfg(str(path)) == Game.from_nfg(path) == read_nfg(LOOP)
    path.write_bytes((mark + HEAD + "1 2 3 4\n 5 x").replace("\n", end).encode())
    with pytest.raises(
        GameFileError, match=r"game\.nfg: line 3, column 4: expected the payoff of 'b' .* got x$"
    ):
        read_nfg(path)


def test_names_may_be_in_any_script_and_hold_quotes():
    game = read_nfg(
        'NFG 1 R "Ä \\"b\\" \\\\" { "机器人" "m\\"an" } { { "左 { 1" "" "right" } { "3" "" } } 1 2 3 4 5 6 7 8 9 0 1 2'
    )
    assert game.players == ("机器人", 'm"an')
    assert game.plans[0] == Axis("机器人_plan", ["左 { 1", "2", "right"])
    assert game.plans[1] == Axis("m_an_plan", ["3", "2"])


def test_strategies_and_players_without_names_go_by_their_numbers():
    game = read_nfg('NFG 1 R "" { "" "" } { { "" "1" "" } { "" } } 1 2 3 4 5 6')
    assert game.players == ("Player 1", "Player 2")
    assert game.plans[0].labels == ("_1", "1", "3")
    assert game.plans[1].labels == ("1",)


@pytest.mark.parametrize(
    ("text", "line", "column", "expected", "got"),
    [
        ('EFG 2 R "tree" { "a" "b" }\n', 1, 1, "NFG, which begins a strategic game", "EFG"),
        ("\n\n", 3, 1, "NFG", "the end of the file"),
        ('NFG 2 R "t" {', 1, 5, "1, the version", "2"),
        ('NFG 1 Q "t" {', 1, 7, "R or D", "Q"),
        ('NFG 1 R title { "a" }', 1, 9, "the title in double quotes", "title"),
        ('NFG 1 R "title { "a', 1, 19, "{ before the players", "a"),
        (
            'NFG 1 R "title {\n{ 1 2',
            1,
            9,
            "the title in double quotes, closed by a second",
            "the end of the file",
        ),
        ('NFG 1 R "t" "a" { 1 }', 1, 13, "{ before the players", '"a"'),
        ('NFG 1 R "t" { } { }', 1, 15, "at least one player's name", "}"),
        ('NFG 1 R "t" { a b } { 1 1 }', 1, 15, "at least one player's name in double quotes", "a"),
        ('NFG 1 R "t" { "a" "a" } { 1 1 }', 1, 19, "another name", "'a', which is player 1"),
        ('NFG 1 R "t" { "a" "b"\n{ 1 1 } 2 2', 2, 1, "a player's name in double quotes", "{"),
        ('NFG 1 R "t" { "a" "b" } 1 1', 1, 25, "{ before the strategies", "1"),
        ('NFG 1 R "t" { "a" "b" } { 2 0 } 1', 1, 29, "the number of strategies of 'b', at least 1", "0"),
        ('NFG 1 R "t" { "a" "b" } { 2 -1 } 1', 1, 29, "the number of strategies of 'b'", "-1"),
        ('NFG 1 R "t" { "a" "b" } { 2 1.5 } 1', 1, 29, "the number of strategies of 'b'", "1.5"),
        ('NFG 1 R "t" { "a" "b" } { 2 } 1', 1, 29, "the number of strategies of 'b'", "}"),
        ('NFG 1 R "t" { "a" "b" } { 2 2 2 } 1', 1, 31, "} after the strategies of 2 players", "2"),
        ('NFG 1 R "t" { "a" "b" } { { "x" } } 1', 1, 35, "{ before the names of the strategies of 'b'", "}"),
        ('NFG 1 R "t" { "a" "b" } { { "x" } { } } 1', 1, 37, "the name of a strategy of 'b'", "}"),
        ('NFG 1 R "t" { "a" "b" } { { "x" 2 } { "y" } } 1', 1, 33, "the name of a strategy of 'a'", "2"),
        (
            'NFG 1 R "t" { "a" "b" } { { "x"\n"y" "x" } { "z" } } 1',
            2,
            5,
            "another name",
            "'x', which is strategy 1 of 'a' already",
        ),
        (HEAD + "1 2 3 4 5 6 7", 2, 14, "the payoff of 'b' in profile 4 of 4", "the end of the file"),
        (HEAD + "1 2 3 4 5 6 7 8 9", 2, 17, "the end of the file after all 4 profiles", "9"),
        (HEAD + "1 2 3 four", 2, 7, "the payoff of 'b' in profile 2 of 4", "four"),
        (HEAD + "1 2 nan 4", 2, 5, "the payoff of 'a' in profile 2 of 4", "nan"),
        (HEAD + "1 2 -inf 4", 2, 5, "the payoff of 'a' in profile 2 of 4", "-inf"),
        (HEAD + "1 2 12abc 4", 2, 5, "the payoff of 'a' in profile 2 of 4", "12abc"),
        (HEAD + "1 2 1/0", 2, 5, "the payoff of 'a' in profile 2 of 4", "1/0, which divides by zero"),
        (HEAD + "1 2 1e999", 2, 5, "the payoff of 'a' in profile 2 of 4", "1e999, which no float can hold"),
        (HEAD + "1 2 1_000", 2, 5, "the payoff of 'a' in profile 2 of 4", "1_000"),
        (HEAD + "1 2 ٣", 2, 5, "the payoff of 'a' in profile 2 of 4", "٣"),
        (HEAD + '"comment" "another" 1', 2, 11, "the payoff of 'a' in profile 1 of 4", '"another"'),
        (HEAD + "{ { 1 2 } } 1", 2, 5, "the name of an outcome in double quotes", "1"),
        (HEAD + '{ { "" 1 } } 1', 2, 10, "the payoff of 'b' in outcome 1", "}"),
        (HEAD + '{ { "" 1 2 3 } } 1', 2, 12, "} after the payoffs of 2 players", "3"),
        (HEAD + '{ { "" 1 2 } 1', 2, 14, "{ before an outcome, or } after the last", "1"),
        (HEAD + '{ { "" 1 2 } } 1 1 2 1', 2, 20, "the outcome of profile 3 of 4, a number from 0 to 1", "2"),
        (HEAD + '{ { "" 1 2 } } 1 -1', 2, 18, "the outcome of profile 2 of 4", "-1"),
        (HEAD + '{ { "" 1 2 } } 1 1 1', 2, 21, "the outcome of profile 4 of 4", "the end of the file"),
        (HEAD + '{ { "" 1 2 } } 1 1 1 1 0', 2, 24, "the end of the file after all 4 profiles", "0"),
    ],
)
def test_a_bad_file_is_refused_with_line_column_what_was_expected_and_what_is_there(
    text, line, column, expected, got, tmp_path
):
    path = tmp_path / "bad.nfg"
    path.write_text(text, encoding="utf-8")
    message = re.escape(f"bad.nfg: line {line}, column {column}: expected {expected}")
    with pytest.raises(GameFileError, match=f"{message}.*, got {re.escape(got)}$"):
        read_nfg(path)


@pytest.mark.parametrize("body", ["1 2 3", '{ { "" 1 2 } } 1 1'])
def test_sizes_that_the_file_does_not_bear_out_are_refused_before_room_is_made_for_them(body):
    text = f'NFG 1 R "big" {{ "a" "b" }} {{ 1000000 1000000 }}\n{body}'
    tracemalloc.start()
    with pytest.raises(
        GameFileError, match=r"line 2, column \d+: expected .* of 1000000000000, .*end of the file"
    ):
        read_nfg(text)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1e6


def test_numbers_of_thousands_of_digits_are_refused_in_few_words():
    with pytest.raises(GameFileError, match=r"got 9{40}\.\.\., which no float can hold"):
        read_nfg(HEAD + "9" * 10_000)
    with pytest.raises(GameFileError, match="the number of strategies of 'a'"):
        read_nfg('NFG 1 R "t" { "a" } { ' + "9" * 10_000 + " }")


def test_a_file_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "old.nfg"
    path.write_bytes('NFG 1 R "t" { "a" }\n{ "é" }'.encode("latin-1"))
    with pytest.raises(
        GameFileError, match=r"line 2, column 4: expected text in UTF-8, got the byte 0xe9; save"
    ):
        read_nfg(path)
    with pytest.raises(GameFileError, match=r"missing\.nfg: cannot be read: No such file"):
        read_nfg(tmp_path / "missing.nfg")
    with pytest.raises(GameFileError, match="cannot be read"):
        read_nfg(tmp_path)


def test_costs_of_at_least_the_stand_in_are_read_as_infinite():
    game = read_nfg(HEAD + "-1000 1 -999 2 3 4 -2000 1000", infinity=1000.0)
    assert game.costs[0].tolist() == [[np.inf, -3.0], [999.0, np.inf]]
    assert game.costs[1].tolist() == [[-1.0, -4.0], [-2.0, -1000.0]]
    with pytest.raises(GameError, match="stands in"):
        read_nfg(HEAD + "1 2 3 4 5 6 7 8", infinity=np.inf)


@given(st.text(alphabet='NFG 1R"{}\\,/.e+-02a\n', max_size=60), st.integers(0, 200))
def test_whatever_a_file_holds_it_is_a_game_or_refused_with_its_place(noise, cut):
    for text in (
        "NFG 1 R {" + noise,
        LOOP[:cut] + noise + LOOP[cut:],
        SELTEN[:cut] + noise,
        LOOP[:cut] + "\n{",
    ):
        try:
            game = read_nfg(text if "{" in text else text + "{")
        except GameFileError as error:
            assert re.match(r"the game's text: line \d+, column \d+: expected ", str(error))  # noqa: PT017
        else:
            assert isinstance(game, Game)
