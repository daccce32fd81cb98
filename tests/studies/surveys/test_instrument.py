"""Instruments: what they mean, and every fault of one told at once."""

import pytest

from ppinfer.studies.faults import FaultyLogError
from ppinfer.studies.surveys import Instrument

from .tables import INSTRUMENT


def test_an_instrument_says_what_its_columns_and_numbers_mean(tmp_path):
    (tmp_path / "i.toml").write_text(INSTRUMENT)
    instrument = Instrument.load(tmp_path / "i.toml")
    assert instrument.column("quick") == "how_quick"
    assert instrument.column("easy") == "easy"
    assert instrument.points("easy") == range(1, 6)
    assert instrument.texts("easy") == {1: "Strongly Disagree", 4: "Agree", 5: "Strongly Agree"}
    assert instrument.score_names == ("easy", "quick", "slow_reversed")
    assert instrument.wording("quick") == "quick"


def test_an_item_may_have_anchors_of_its_own_and_a_scale_may_be_below_zero():
    instrument = Instrument.parse("""
        columns = {subject = "user"}
        anchors = {1 = "no", 7 = "yes"}
        items.often = {anchors = {-3 = "much less", 0 = "", 3 = "much more"}}
        items.easy = {}
    """)
    assert instrument.points("often") == range(-3, 4)
    assert instrument.points("easy") == range(1, 8)
    assert instrument.factors == ()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("slow = {reversed", "slow = {revrsed"), "no entry 'items.slow.revrsed'; did you mean 'reversed'?"),
        (("[columns]", "[column]"), "there is no entry 'column'; did you mean 'columns'?"),
        (('subject = "user"', ""), "'columns.subject' is missing"),
        (
            ("reversed = true", 'reversed = "yes"'),
            "'items.slow.reversed': Input should be a valid boolean, got 'yes'",
        ),
        (('items = ["easy", "quick", "slow"]', 'items = ["esay"]'), "no item 'esay'; did you mean 'easy'?"),
        (('items = ["easy", "quick", "slow"]', "items = []"), "a scale has at least one item"),
        (('items = ["easy", "quick", "slow"]', 'items = ["easy", "easy"]'), "each item once"),
        (('1 = "Strongly Disagree"', 'one = "Strongly Disagree"'), "belongs to a whole number, got 'one'"),
        (('1 = "Strongly Disagree"\n4 = "Agree"\n', ""), "give the lowest and the highest number"),
        (('4 = "Agree"', '4 = "strongly  agree"'), "two numbers have the same text"),
        (('4 = "Agree"', '4 = "2"'), "4 is called '2', which is another number"),
        (('4 = "Agree"', '4000 = "Agree"'), "at most 101 points"),
        (("[anchors]", "[file.anchors]"), "no entry 'file.anchors'"),
        (('column = "how_quick"', 'column = "easy"'), "are the same column 'easy'"),
        (('condition = "robot"', 'condition = "user"'), "are the same column 'user'"),
        (('condition = "robot"', "condition = []"), "an empty list"),
        (("easy = {text", "participant = {text"), "none is called 'participant'"),
        (("[scales.fluency]", "[scales.easy]"), "'easy' would be 2 columns of a table of scores"),
        (
            ("slow = {reversed = true}", "slow = {reversed = true, anchors = {0 = 'a', 9 = 'b'}}"),
            "0 to 9, 1 to 5",
        ),
        (
            ("[scales", "[conditions.rbot]\na = 'A'\n[scales"),
            "no column of a condition is called so; did you mean 'robot'",
        ),
        (("[scales", "[conditions.robot]\n[scales"), "name at least one condition"),
        (("[scales", "[orders]\npositions = ['x']\n[scales"), "name at least two columns"),
        (("[columns]", "[columns"), "is not TOML"),
    ],
)
def test_what_is_wrong_with_an_instrument_is_told_with_the_closest_name(change, told):
    assert change[0] in INSTRUMENT
    with pytest.raises(FaultyLogError) as caught:
        Instrument.parse(INSTRUMENT.replace(*change))
    assert told in " ".join(caught.value.lines)


def test_all_that_is_wrong_is_told_at_once():
    with pytest.raises(FaultyLogError) as caught:
        Instrument.parse("""
            columns = {subject = "user"}
            items = {a = {}, b = {anchors = {1 = "no"}}}
            scales.s.items = ["c"]
        """)
    assert len(caught.value.lines) == 3


def test_a_file_that_is_not_there_or_is_no_text_is_refused(tmp_path):
    with pytest.raises(FaultyLogError, match=r"none\.toml: 1 fault: cannot be read: No such file"):
        Instrument.load(tmp_path / "none.toml")
    (tmp_path / "bad.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(FaultyLogError, match="is not UTF-8 text"):
        Instrument.load(tmp_path / "bad.toml")
