import re

import numpy as np
import pytest

from ppinfer.studies.posterior import write_posterior
from ppinfer.studies.scores import score_posterior

from ..studies.posteriors import make_posterior
from .commands import checked_json, run_one


@pytest.fixture
def post(tmp_path):
    path = tmp_path / "post.nc"
    write_posterior(make_posterior(), path)
    return path


def test_json_holds_the_scores_and_keeps_its_schema(post, capsys):
    assert run_one("score", post, "--at", "0.25", "0.5", "--json") == 0
    out, err = capsys.readouterr()
    printed = checked_json("score", out)
    assert printed["scores"] == score_posterior(make_posterior(), at=[0.25, 0.5]).to_json()
    assert [row["at"] for row in printed["scores"]] == [0.25, 0.5]
    assert len(printed["calibration"]["bins"]) == 10
    assert err == ""


def test_options_choose_segments_and_participants(post, capsys):
    assert (
        run_one("score", post, "--min-samples", 13, "--participants", "p1", "p2", "--exclude", "p1", "--json")
        == 0
    )
    out, err = capsys.readouterr()
    printed = checked_json("score", out)
    assert printed["scores"][0]["participants"] == 1
    assert printed["scores"][0]["accuracy_se"] is None
    assert printed["left_out"]["participant"] == 6
    assert "one participant only" in err


def test_by_participant_adds_their_scores(post, capsys):
    assert run_one("score", post, "--by-participant", "--json") == 0
    rows = checked_json("score", capsys.readouterr().out)["by_participant"]
    assert len(rows) == 9
    assert {row["participant"] for row in rows} == {"p1", "p2", "p3"}


def test_the_table_is_for_people(post, capsys):
    assert run_one("score", post, "--by-participant", "--min-samples", 13) == 0
    out = capsys.readouterr().out
    for part in ("accuracy", "±", "expected calibration error", "segments left out (below min samples", "p2"):
        assert part in out


def test_an_impossible_true_goal_is_null_and_a_warning(tmp_path, capsys):
    posterior = make_posterior(goals=("a", "b"))
    posterior["true_goal"].values[:] = "b"
    posterior["log_posterior"].values[:] = [0.0, -np.inf]
    write_posterior(posterior, tmp_path / "p.nc")
    assert run_one("score", tmp_path / "p.nc", "--at", "0.5", "--json") == 0
    out, err = capsys.readouterr()
    printed = checked_json("score", out)
    assert printed["scores"][0]["mean_log_posterior"] is None
    assert "the true goal of 8 of 8 segments has probability zero" in err
    assert printed["warnings"] == [err.strip().removeprefix("ppinfer score: warning: ")]


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["--participants", "nobody"], "unknown participant 'nobody'; the posterior has 'p1', 'p2', 'p3'"),
        (["--min-samples", "999"], "no segment can be scored"),
    ],
)
def test_bad_requests_are_one_line_and_status_1(post, capsys, argv, message):
    assert run_one("score", post, *argv) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert err.count("\n") == 1


def test_a_missing_file_is_one_line(tmp_path, capsys):
    assert run_one("score", tmp_path / "none.nc") == 1
    assert capsys.readouterr().err.endswith("none.nc: there is no such file\n")


@pytest.mark.parametrize("command", ["score", "compare", "report"])
def test_help_shows_an_example(command, capsys):
    with pytest.raises(SystemExit) as caught:
        run_one(command, "--help")
    assert caught.value.code == 0
    assert re.search(rf"examples?:\n  ppinfer {command} ", capsys.readouterr().out)
