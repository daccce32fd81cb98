"""Games are written as Gambit files from which every float comes back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppinfer import Axis
from ppinfer.errors import GameError
from ppinfer.games import Game, read_nfg, write_nfg
from ppinfer.testing import games


@given(
    games(max_players=4, max_plans=3, max_batch=0, infinities=False, absent=False),
    st.sampled_from(["payoffs", "outcomes"]),
)
def test_a_game_comes_back_from_its_file_exactly(game, form):
    assert read_nfg(write_nfg(game, form=form)) == game
    assert read_nfg(game.to_nfg(form=form)) == game


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=20))
def test_every_float_comes_back(costs):
    assert read_nfg(write_nfg(Game([costs], ["a"]))).costs[0].tolist() == costs


@given(games(max_players=3, max_plans=3, max_batch=0, absent=False))
def test_infinities_come_back_by_way_of_their_stand_in(game):
    stand_in = 1.5e300
    assert read_nfg(write_nfg(game, infinity=stand_in), infinity=stand_in) == game


@given(
    st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\r"), max_size=8),
    st.lists(
        st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\r"), min_size=1, max_size=6),
        min_size=1,
        max_size=3,
        unique=True,
    ),
)
def test_names_come_back_whatever_they_hold(title, labels):
    game = Game(np.zeros((1, len(labels))), [f"p {title}"], [Axis("plan", labels)])
    text = write_nfg(game, title=title, comment=title)
    back = read_nfg(text)
    assert back.players == game.players
    assert back.plans[0].labels == tuple(labels)


def test_plans_that_are_only_numbered_are_written_as_counts_and_others_by_name():
    numbered = Game(np.zeros((2, 2, 3)), ["a", "b"])
    assert "{ 2 3 }" in write_nfg(numbered)
    named = Game(np.zeros((2, 2, 3)), ["a", "b"], [Axis("a_plan", [True, False]), Axis("b_plan", 3)])
    assert '{ "True" "False" }\n  { "0" "1" "2" }' in write_nfg(named)


def test_outcomes_are_listed_once_each():
    game = Game([[[1.0, 0.0], [0.0, 1.0]], [[1.0, 0.0], [0.0, 1.0]]], ["a", "b"])
    text = write_nfg(game, form="outcomes", title="t", comment='say "hi"')
    assert text == (
        'NFG 1 R "t" { "a" "b" }\n\n{ 2 2 }\n"say \\"hi\\""\n\n{\n{ "" -1, -1 }\n{ "" 0, 0 }\n}\n1 2 2 1\n'
    )


def test_a_file_is_written_where_it_is_asked_for(tmp_path):
    game = Game([[[1.0, 2.0]], [[0.5, 0.0]]], ["räuber", "human"])
    text = game.to_nfg(tmp_path / "game.nfg", title="Passing")
    assert (tmp_path / "game.nfg").read_bytes() == text.encode()
    assert Game.from_nfg(tmp_path / "game.nfg") == game


@pytest.mark.parametrize(
    ("game", "options", "message"),
    [
        (
            Game([[[1.0, np.inf]], [[1.0, 2.0]]], ["a", "b"]),
            {},
            "player='a', a_plan=0, b_plan=1 is inf; .*infinity=1e6",
        ),
        (
            Game([[[1.0, np.inf]], [[1.0, 1e6]]], ["a", "b"]),
            {"infinity": 1e6},
            "the cost at player='b', a_plan=0, b_plan=1 is 1000000.0; choose a number above",
        ),
        (Game(np.zeros((3, 1, 2)), ["a"], batch=[Axis("trial", 3)]), {}, r"restrict\(trial=...\) picks one"),
        (Game([[1.0, 2.0]], ["a"], present=[True, False]), {}, "a_plan=1 is absent"),
        (Game([[1.0]], ["a"]), {"infinity": np.nan}, "the finite cost that stands in"),
    ],
)
def test_what_a_file_cannot_hold_is_refused_before_anything_is_written(game, options, message, tmp_path):
    with pytest.raises(GameError, match=message):
        write_nfg(game, tmp_path / "game.nfg", **options)
    assert not (tmp_path / "game.nfg").exists()
