import hashlib
import json
import math

import pytest

from ppinfer.studies.statistics import analyse

from ..studies.statistics.designs import ATTITUDES, BUSHTUCKER
from .commands import checked_json, run_one


def write(path, measures):
    """Write measures as a long table."""
    lines = [",".join(["who", *measures.factors, measures.dv])]
    for subject, values in zip(measures.subjects, measures.values, strict=True):
        cells = [()]
        for levels in measures.levels:
            cells = [(*cell, level) for cell in cells for level in levels]
        lines += [
            ",".join([subject, *cell, str(value)]) for cell, value in zip(cells, values.ravel(), strict=True)
        ]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture
def retch(tmp_path):
    return write(tmp_path / "retch.csv", BUSHTUCKER)


ASK = ("--dv", "score", "--within", "factor 0", "--subject", "who")


def test_json_holds_the_analysis_and_where_it_comes_from(retch, capsys):
    assert run_one("anova", retch, *ASK, "--posthoc", "holm", "--json") == 0
    out, err = capsys.readouterr()
    printed = checked_json("anova", out)
    expected = analyse([BUSHTUCKER], posthoc="holm").to_json()
    assert {name: printed[name] for name in ("anova", "posthoc")} == json.loads(json.dumps(expected))
    assert (round(printed["anova"][0]["F"], 2), round(printed["anova"][0]["p_gg"], 3)) == (3.79, 0.063)
    assert printed["input_sha256"] == hashlib.sha256(retch.read_bytes()).hexdigest()
    assert printed["options"]["posthoc"] == "holm"
    assert printed["warnings"] == []
    assert err == ""


def test_without_posthoc_there_are_no_pairs(retch, capsys):
    assert run_one("anova", retch, *ASK, "--json") == 0
    assert checked_json("anova", capsys.readouterr().out)["posthoc"] == []


def test_names_follow_one_flag_or_several(tmp_path, capsys):
    path = write(tmp_path / "a.csv", ATTITUDES)
    path.write_text("\n".join(f"{line},{number}" for number, line in enumerate(path.read_text().split())))
    path.write_text(path.read_text().replace("score,0", "score,row"))
    one = ["--dv", "score", "row", "--within", "drink", "imagery", "--subject", "who", "--json"]
    several = [
        "--dv",
        "score",
        "--dv",
        "row",
        "--within",
        "drink",
        "--within",
        "imagery",
        "--subject",
        "who",
        "--json",
    ]
    answers = []
    for flags in (one, several):
        assert run_one("anova", path, *flags) == 0
        answers.append(checked_json("anova", capsys.readouterr().out))
    assert answers[0] == answers[1]
    rows = answers[0]["anova"]
    assert [(row["dv"], row["effect"]) for row in rows[:3]] == [
        ("score", "drink"),
        ("score", "imagery"),
        ("score", "drink:imagery"),
    ]
    # the number of the row differs between levels by the same for everybody
    assert [row["F"] for row in rows[3:]] == [None, None, None]
    assert [row["p"] for row in rows[3:]] == [0.0, 0.0, None]


def test_the_table_is_for_people(retch, capsys):
    assert run_one("anova", retch, *ASK, "--posthoc", "bonferroni") == 0
    out = capsys.readouterr().out
    for part in ("F(3, 21) = 3.79", "0.0626", "8.125 ± 0.789", "a0 - a2", "p adjusted", "bonferroni", "BF10"):
        assert part in out


def test_many_levels_are_listed_one_a_line(tmp_path, capsys):
    path = write(tmp_path / "a.csv", ATTITUDES)
    ask = ("--dv", "score", "--within", "drink", "imagery", "--subject", "who")
    assert run_one("anova", path, *ask) == 0
    out = capsys.readouterr().out
    assert "drink:imagery" in out
    assert "a2 : b1" in out


GAPS = "who,x,y\n1,a,1\n1,b,2\n2,a,3\n3,a,2\n3,b,\n4,a,1\n4,b,5\n5,a,2\n5,b,2\n5,b,4\n"


@pytest.mark.parametrize(
    ("text", "flags", "message"),
    [
        (
            GAPS.replace("5,b,4\n", ""),
            [],
            "t.csv: 2 faults: column 'y': subject '2' at x 'b' has no value | column 'y': subject '3' at x 'b' has "
            "no value; fill them in, or choose --missing drop-subjects or drop-levels",
        ),
        (GAPS, [], "subject '5' at x 'b' is there more than once (lines 10, 11); remove what is wrong"),
        (GAPS, ["--repeated", "mean", "--missing", "drop-levels"], "factor 'x' has too few levels: 1 ('a')"),
        (GAPS.replace(",", ";"), [], "cells seem to be separated by ';', not by ','"),
        ("who,x,y\n1,a,1\n1,b,2\n", [], "the number of subjects is 1, expected at least 2"),
        ("who,x,y\n1,a,1\n2,a,2\n", [], "factor 'x' has too few levels: 1 ('a'), expected at least 2"),
        ("who,x,y\n1,a,1\n1,b,good\n", [], "line 3: column 'y': expected a finite number, got 'good'"),
        ('who,x,y\n1,a,1\n1,b,"1,5"\n', [], "got '1,5'; for decimal commas give --decimal ,"),
        ("who,x,Y\n1,a,1\n", [], "column 'y': there is no such column; did you mean 'Y'?"),
        (
            "who,x,y\n1,a,1\n1,a,2\n2,b,3\n2,b,4\n",
            [],
            "subject '1' at x 'a' is there more than once (lines 2, 3) | subject '2' at x 'b' is there more than once "
            "(lines 4, 5); remove what is wrong, or have the mean taken (--repeated mean)\n",
        ),
        (
            "who,X,Y\n1,a,1\n",
            [],
            "column 'x': there is no such column; did you mean 'X'? | column 'y': there is no such column; did you "
            "mean 'Y'?; there are 'who', 'X', 'Y'\n",
        ),
        ("", [], "the file is empty"),
    ],
)
def test_what_cannot_be_analysed_is_one_line_and_status_1(tmp_path, capsys, text, flags, message):
    (tmp_path / "t.csv").write_text(text)
    ask = ("--dv", "y", "--within", "x", "--subject", "who", *flags)
    assert run_one("anova", tmp_path / "t.csv", *ask) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("ppinfer anova: ")
    assert err.count("\n") == 1
    assert message in err


def test_what_was_chosen_for_missing_and_repeated_cells_is_said(tmp_path, capsys):
    (tmp_path / "t.csv").write_text(GAPS)
    ask = (
        "--dv",
        "y",
        "--within",
        "x",
        "--subject",
        "who",
        "--repeated",
        "mean",
        "--missing",
        "drop-subjects",
    )
    assert run_one("anova", tmp_path / "t.csv", *ask, "--json") == 0
    out, err = capsys.readouterr()
    printed = checked_json("anova", out)
    assert printed["anova"][0]["subjects"] == 3
    assert [mean["mean"] for mean in printed["anova"][0]["means"]] == [
        pytest.approx(4 / 3),
        pytest.approx(10 / 3),
    ]
    assert printed["warnings"] == [
        "'y': mean of several rows taken in 1 cells (up to 2 rows)",
        "'y': 2 of 5 subjects dropped for missing cells: '2', '3'",
    ]
    assert err.splitlines() == [f"ppinfer anova: warning: {warning}" for warning in printed["warnings"]]


def test_markup_and_formulas_in_a_table_are_text(tmp_path, capsys):
    (tmp_path / "t.csv").write_text("C(x),[red]f,my dv\n=cmd(),<b>,1\n=cmd(),[bold],2\nb,<b>,3\nb,[bold],5\n")
    ask = ("--dv", "my dv", "--within", "[red]f", "--subject", "C(x)", "--posthoc", "holm")
    assert run_one("anova", tmp_path / "t.csv", *ask) == 0
    out = capsys.readouterr().out
    assert "[red]f" in out
    assert "<b> - [bold]" in out


def test_the_prior_scale_is_the_bayes_factors(retch, capsys):
    found = []
    for flags in ([], ["--prior-scale", "0.707106781186547524"], ["--prior-scale", "0.5"]):
        assert run_one("anova", retch, *ASK, *flags, "--json") == 0
        found.append(checked_json("anova", capsys.readouterr().out)["anova"][0]["log_bf10"])
    assert found[0] == found[1] != found[2]
    assert math.exp(found[0]) == pytest.approx(2.596, abs=0.001)


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--prior-scale", "0"], "expected a number above 0"),
        (["--delimiter", "::"], "expected one character, or tab"),
        (["--posthoc", "tukey"], "invalid choice"),
    ],
)
def test_wrong_arguments_are_one_line_and_status_2(retch, capsys, flags, message):
    with pytest.raises(SystemExit) as stop:
        run_one("anova", retch, *ASK, *flags)
    assert stop.value.code == 2
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1


def test_a_folder_in_place_of_a_table_is_named(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run_one("anova", ".", "--dv", "y", "--within", "x", "--subject", "who") == 1
    assert capsys.readouterr().err == "ppinfer anova: .: is a folder; give one CSV or Parquet file\n"
