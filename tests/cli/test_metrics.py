"""`ppinfer metrics`, as somebody at a terminal meets it."""

import csv

import numpy as np
import pytest

from ppinfer.studies import RecordingHeader, RecordingWriter, Trial, write_log
from ppinfer.studies.metrics import METRICS, trial_metrics
from ppinfer.testing import example_log, example_planned_log, example_team_log

from .commands import checked_json, run_one


@pytest.fixture
def team(tmp_path):
    path = tmp_path / "team.nc"
    write_log(example_team_log(), path)
    return path


def test_json_holds_the_metrics_and_keeps_its_schema(team, capsys):
    line = ("metrics", team, "--by", "condition", "--learning-by", "condition", "--resamples", 100, "--json")
    assert run_one(*line) == 0
    out = capsys.readouterr().out
    printed = checked_json("metrics", out)
    assert [metric["name"] for metric in printed["metrics"]] == list(METRICS)
    assert len(printed["trials"]) == 12
    assert {row["group"] for row in printed["groups"]} == {"c0", "c1"}
    assert len(printed["differences"]) == len(METRICS)
    assert printed["options"]["learning_over"] == "round"
    assert printed["log"] == "team.nc"
    # it is the same again, numbers of the bootstrap and all
    assert run_one(*line) == 0
    assert capsys.readouterr().out == out


def test_the_table_has_a_row_for_each_trial_that_reads_back_exactly(team, tmp_path, capsys):
    assert (
        run_one("metrics", team, "-o", tmp_path / "trials.csv", "--names", "score", "functional_delay") == 0
    )
    with (tmp_path / "trials.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    found = trial_metrics(team, names=["score", "functional_delay"])
    assert [row["trial_id"] for row in rows] == found.trial_id.tolist()
    assert list(rows[0])[:4] == ["trial_id", "participant", "condition", "round"]
    for name in found.names:
        values = [float(row[name]) if row[name] else np.nan for row in rows]
        np.testing.assert_array_equal(values, found.values_of(name))
    assert "12 trials, 2 metrics" in capsys.readouterr().out


def test_the_table_is_what_an_analysis_of_variance_reads(team, tmp_path, capsys):
    assert (
        run_one("metrics", team, "-o", tmp_path / "trials.csv", "--names", "score", "--by", "condition") == 0
    )
    capsys.readouterr()
    line = (
        "--dv",
        "score",
        "--within",
        "condition",
        "--subject",
        "participant",
        "--repeated",
        "mean",
        "--json",
    )
    assert run_one("anova", tmp_path / "trials.csv", *line) == 0
    (row,) = checked_json("anova", capsys.readouterr().out)["anova"]
    assert (row["dv"], row["effect"], row["subjects"]) == ("score", "condition", 3)


def test_the_tables_are_for_people(team, capsys):
    assert (
        run_one("metrics", team, "--by", "condition", "--learning-by", "condition", "--names", "score") == 0
    )
    out = " ".join(capsys.readouterr().out.split())
    for part in ("12 trials of 3 participants", "±", "c0 - c1", "slopes over round", "score"):
        assert part in out


def test_a_log_of_one_agent_says_what_it_cannot_give(tmp_path, capsys):
    write_log(example_log(participants=1, trials=2), tmp_path / "log.nc")
    assert run_one("metrics", tmp_path / "log.nc") == 0
    out, err = capsys.readouterr()
    assert "human_path_length" in out
    assert "not in this log: total_s" in out
    assert "one participant only" in err


def test_a_recording_and_a_log_without_goals_are_measured(tmp_path, capsys):
    write_log(example_planned_log(trials=2), tmp_path / "plays.nc")
    assert run_one("metrics", tmp_path / "plays.nc", "--names", "total_s", "stops") == 0
    trial = Trial("t", "ann", time=np.arange(3.0), position=np.zeros((3, 1, 2)))
    with RecordingWriter(tmp_path / "study.jsonl", RecordingHeader(agents=("human",))) as recording:
        recording.append(trial)
    assert run_one("metrics", tmp_path / "study.jsonl", "--names", "duration_s") == 0


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        (["--names", "robot_speed"], "there is no metric 'robot_speed'"),
        (["--by", "weather"], "trials cannot be grouped by 'weather'"),
        (["--learning-by", "weather"], "trials cannot be grouped by 'weather'"),
        (["--learning-by", "condition", "--learning-over", "participant"], "'participant' is text"),
        (["--robot", "cat"], "there is no agent 'cat' in the log; there are human, robot"),
        (
            ["--learning-over", "round"],
            "--learning-over says what rounds are counted by; give --learning-by too",
        ),
        (["-o", "trials.txt"], "the output is a .csv file"),
        (["-o", "nowhere/trials.csv"], "nowhere/trials.csv: there is no folder 'nowhere'; make it first"),
        (["-o", "folder.csv"], "folder.csv: is a folder"),
    ],
)
def test_what_cannot_be_is_one_line_and_nothing_is_written(team, tmp_path, monkeypatch, capsys, flags, told):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.csv").mkdir()
    before = sorted(tmp_path.iterdir())
    assert run_one("metrics", team, *(["-o", "trials.csv"] if "-o" not in flags else []), *flags) == 1
    out, err = capsys.readouterr()
    assert told in err
    assert err.count("\n") == 1
    assert out == ""
    assert sorted(tmp_path.iterdir()) == before


def test_a_metric_that_the_log_cannot_give_is_refused_by_name_with_what_is_missing(tmp_path, capsys):
    write_log(example_log(), tmp_path / "log.nc")
    assert run_one("metrics", tmp_path / "log.nc", "--names", "duration_s", "stops", "score") == 1
    err = capsys.readouterr().err
    assert "stops: the log has no stops; score: the log has no team_score" in err


@pytest.mark.parametrize("name", ["nowhere.nc", "empty.nc", "text.nc", "torn.jsonl"])
def test_files_that_are_no_logs_are_refused_in_one_line(tmp_path, capsys, name):
    (tmp_path / "empty.nc").write_bytes(b"")
    (tmp_path / "text.nc").write_text("time,x\n0,1\n")
    (tmp_path / "torn.jsonl").write_text('{"ppinfer')
    assert run_one("metrics", tmp_path / name) == 1
    out, err = capsys.readouterr()
    assert err.count("\n") == 1
    assert out == ""


def test_names_from_a_log_are_text_in_tables_and_no_formulas_in_the_csv(tmp_path, capsys):
    log = example_log(participants=2, trials=2)
    names = ["=cmd()", "=cmd()", "[red]b", "\x1b[31mc"]
    log["participant"] = ("trial", np.array(names, dtype=object))
    write_log(log, tmp_path / "log.nc")
    line = ("--by", "participant", "--names", "duration_s", "-o", tmp_path / "trials.csv")
    assert run_one("metrics", tmp_path / "log.nc", *line) == 0
    out = capsys.readouterr().out
    assert "[red]b" in out
    assert "\\x1b[31mc" in out
    assert "\x1b" not in out
    assert "'=cmd()" in (tmp_path / "trials.csv").read_text()


def test_a_table_of_another_study_comes_to_scores_by_layout_and_to_an_analysis_of_variance(tmp_path, capsys):
    rows = ["game,who,t,hx,hy,rx,ry,room,points,h_waits,r_waits,h_done,r_done"]
    scores = {}
    for trial in range(12):
        who, room = f"p{trial // 3}", ("open", "door", "maze")[trial % 3]
        points = scores[f"{trial}"] = (trial * 7 + trial % 3) % 10
        for time in range(3):
            waits = f"{int(time == trial % 3)},{int(time == 0)}"
            rows.append(
                f"{trial},{who},{100 * time},0,{time},1,{-time},{room},{points},{waits},{100 * (trial % 3)},"
            )
    (tmp_path / "games.csv").write_text("\n".join(rows) + "\n")
    (tmp_path / "games.toml").write_text(
        '[columns]\ntrial = "game"\nparticipant = "who"\ntime = "t"\n[units]\ntime = "ms"\n'
        '[agents.human]\nx = "hx"\ny = "hy"\n[agents.robot]\nx = "rx"\ny = "ry"\n'
        '[variables]\nlayout = "room"\nteam_score = "points"\nis_human_waiting = "h_waits"\n'
        'is_robot_waiting = "r_waits"\nfinish_time = {columns = {human = "h_done", robot = "r_done"}}\n'
    )
    log, table = tmp_path / "games.nc", tmp_path / "trials.csv"
    mapping = ("--from", "tidy", "--mapping", tmp_path / "games.toml")
    assert run_one("convert", tmp_path / "games.csv", "-o", log, *mapping) == 0
    assert "variable 'layout': text, one a trial" in capsys.readouterr().out
    assert run_one("metrics", log, "--by", "layout", "-o", table, "--json") == 0
    printed = checked_json("metrics", capsys.readouterr().out)
    assert printed["options"]["idle"]["from"] == "flags"
    names = {metric["name"] for metric in printed["metrics"]}
    assert {"score", "human_s", "failures", "human_idle_share"} <= names
    assert {row["group"] for row in printed["groups"]} == {"open", "door", "maze"}
    with table.open(newline="") as file:
        found = list(csv.DictReader(file))
    assert {row["trial_id"]: float(row["score"]) for row in found} == scores
    assert [float(row["human_s"]) for row in found] == [0.1 * (trial % 3) for trial in range(12)]
    assert {row["failures"] for row in found} == {"1.0"}
    line = ("--dv", "score", "--within", "layout", "--subject", "participant", "--json")
    assert run_one("anova", table, *line) == 0
    (effect,) = checked_json("anova", capsys.readouterr().out)["anova"]
    assert (effect["effect"], effect["subjects"]) == ("layout", 4)
