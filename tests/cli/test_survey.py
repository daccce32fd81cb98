"""``ppinfer survey``: what it prints and writes, and that each failure is one line and leaves nothing."""

import csv

import pytest

from .commands import checked_json, run_one

INSTRUMENT = """
title = "After each robot"
columns = {subject = "user", condition = ["robot", "task"]}
anchors = {1 = "no", 5 = "yes"}
items = {easy = {}, slow = {reversed = true}}
scales.ease.items = ["easy", "slow"]
"""
ANSWERS = "user,name,robot,task,easy,slow\n" + "".join(
    f"u{user},Name {user},{robot},{task},{1 + (2 * user + len(robot)) % 5},{5 - (2 * user + len(task)) % 4}\n"
    for user in range(5)
    for robot in ("one", "three")
    for task in ("pick", "place")
)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "answers.csv").write_text(ANSWERS)
    (tmp_path / "i.toml").write_text(INSTRUMENT)
    (tmp_path / "orders.csv").write_text("user,first,second\nu0,one,three\nu1,three,one\nu2,one,\n")
    return tmp_path


def survey(folder, *more, table="answers.csv"):
    return run_one("survey", folder / table, "--instrument", folder / "i.toml", *more)


def refused(folder, capsys, *more, table="answers.csv"):
    """Return the one line of a command that failed, once it has written nothing."""
    before = sorted(folder.iterdir())
    assert survey(folder, *more, table=table) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("ppinfer survey: ")
    assert err.count("\n") == 1
    assert sorted(folder.iterdir()) == before
    return err


def test_json_has_items_scales_reliability_and_where_they_come_from(folder, capsys):
    assert survey(folder, "--json", "-o", folder / "scores.csv") == 0
    printed = checked_json("survey", capsys.readouterr().out)
    assert printed["title"] == "After each robot"
    assert printed["conditions"] == ["one / pick", "one / place", "three / pick", "three / place"]
    assert (printed["participants"], printed["responses"]) == (5, 20)
    assert printed["counterbalancing"] is None
    assert printed["output"] == str(folder / "scores.csv")
    assert printed["options"]["missing"] == "refuse"
    with (folder / "scores.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["participant", "robot", "task", "easy", "slow_reversed", "ease"]
    assert len(rows) == 20


def test_conditions_can_be_told_apart_by_one_column_and_orders_checked(folder, capsys):
    assert survey(folder, "--json", "--by", "robot", "--orders", folder / "orders.csv") == 0
    printed = checked_json("survey", capsys.readouterr().out)
    assert printed["conditions"] == ["one", "three"]
    found = printed["counterbalancing"]
    assert found["source"] == "orders.csv"
    assert found["design"] == "fully counterbalanced"
    assert (len(found["incomplete"]), len(found["without_order"])) == (1, 2)


def test_nobody_is_named_unless_asked_for(folder, capsys):
    assert (
        survey(folder, "--by", "robot", "--orders", folder / "orders.csv", "-o", folder / "scores.csv") == 0
    )
    told = "".join(capsys.readouterr()) + (folder / "scores.csv").read_text()
    assert "Name" not in told
    assert "u1" not in told
    assert "P05" in told
    assert survey(folder, "--keep-ids", "-o", folder / "scores.csv") == 0
    assert "u1" in (folder / "scores.csv").read_text()
    assert "Name" not in (folder / "scores.csv").read_text()


def test_tables_are_printed_for_people(folder, capsys):
    assert survey(folder, "--by", "robot", "--orders", folder / "orders.csv") == 0
    out = capsys.readouterr().out
    for part in (
        "After each robot: 20 responses of 5 participants",
        "Cronbach's alpha",
        "within participants",
        "then one",
    ):
        assert part in out


def test_missing_answers_are_refused_named_or_treated_as_chosen(folder, capsys):
    lines = ANSWERS.splitlines()
    lines[5], lines[14] = lines[5].rpartition(",")[0] + ",", lines[14].rpartition(",")[0] + ",NA"
    (folder / "answers.csv").write_text("\n".join(lines))
    told = refused(folder, capsys, "-o", folder / "scores.csv")
    assert (
        "2 faults: line 6: column 'slow': no answer (condition 'one / pick') | line 15: column 'slow': no answer"
        in told
    )
    assert told.count("drop-responses or mean-of-answered") == 1
    for way, dropped in (("mean-of-answered", 0), ("drop-responses", told.count("no answer"))):
        assert survey(folder, "--missing", way, "--json") == 0
        out, err = capsys.readouterr()
        printed = checked_json("survey", out)
        assert printed["dropped_responses"] == dropped
        assert printed["missing_answers"] == told.count("no answer")
        assert "warning:" in err


def test_what_comes_from_a_table_is_text_in_the_next_one(folder, capsys):
    (folder / "answers.csv").write_text(ANSWERS.replace(",three,", ",=cmd(),").replace("u1,", "+u1,"))
    assert survey(folder, "--keep-ids", "-o", folder / "scores.csv") == 0
    with (folder / "scores.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["robot"] for row in rows} == {"one", "'=cmd()"}
    assert "'+u1" in {row["participant"] for row in rows}


@pytest.mark.parametrize(
    ("change", "more", "told"),
    [
        ({"answers.csv": "u,x\n1,2\n"}, (), "no such column (the instrument's 'columns.subject')"),
        ({"answers.csv": ""}, (), "the file is empty"),
        ({"answers.csv": b"\xff\xfe\x00"}, (), "answers.csv"),
        (
            {"answers.csv": ANSWERS + "u9,x,one,pick,7,1\n"},
            (),
            "line 22: column 'easy': expected a whole number from 1",
        ),
        (
            {"answers.csv": ANSWERS + "u1,x,one,pick,1,1\n"},
            (),
            "this participant has answered under this condition in line",
        ),
        (
            {"i.toml": INSTRUMENT.replace("scales.ease", "scale.ease")},
            (),
            "there is no entry 'scale'; did you mean 'scales'",
        ),
        ({"i.toml": "x = "}, (), "is not TOML"),
        ({}, ("--by", "rbot"), "no condition column 'rbot' in the instrument; did you mean 'robot'"),
        (
            {"orders.csv": "user,first,second\nu0,one,two\n"},
            ("--by", "robot", "--orders"),
            "no condition 'two'",
        ),
        (
            {"orders.csv": "user,a,b\nu0,one,three\n"},
            ("--by", "robot", "--orders"),
            "column 'first': there is no such column",
        ),
        ({}, ("-o", "scores.txt"), "the output is a .csv file"),
        ({}, ("-o", "answers.csv"), "is both read and written"),
        ({}, ("-o", "nowhere/scores.csv"), "nowhere'; make it first"),
    ],
)
def test_a_failure_is_one_line_and_leaves_nothing(folder, capsys, change, more, told):
    for name, text in change.items():
        (folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    if more[-1:] == ("--orders",):
        more = (*more, folder / "orders.csv")
    if more[:1] == ("-o",):
        more = ("-o", folder / more[1])
    assert told in refused(folder, capsys, *more)


def test_a_table_that_is_not_there_is_refused(folder, capsys):
    assert "there is no such file" in refused(folder, capsys, table="none.csv")


def test_all_wrong_cells_are_in_the_one_line(folder, capsys):
    (folder / "answers.csv").write_text(ANSWERS + "u9,x,one,pick,7,maybe\n")
    told = refused(folder, capsys)
    assert "2 faults: line 22: column 'easy'" in told
    assert " | line 22: column 'slow'" in told
