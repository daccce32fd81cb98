import pytest

from ppinfer.studies import write_log
from ppinfer.studies.posterior import write_posterior
from ppinfer.studies.storage import write_signed
from ppinfer.testing import example_interaction_log
from ppsim.reaching import GameStudy
from ppsim.study import log_of_study

from ..plots.plays import make_plays
from ..report.logs import reaches
from ..studies.posteriors import make_posterior
from .commands import checked_json, run_one


@pytest.fixture(autouse=True)
def coarse_figures(monkeypatch):
    """Draw small: what is on the pages is tested, not how sharp it is."""
    monkeypatch.setattr("ppinfer.report.figures._DPI", 40)


@pytest.fixture
def post(tmp_path):
    write_posterior(make_posterior(), tmp_path / "post.nc")
    return tmp_path / "post.nc"


def test_json_says_what_was_written(post, tmp_path, capsys):
    assert run_one("report", post, "-o", tmp_path / "out" / "report", "--trials", "t1", "--json") == 0
    printed = checked_json("report", capsys.readouterr().out)
    assert printed["page"] == str(tmp_path / "out" / "report" / "index.html")
    assert printed["trials"] == ["t1"]
    assert len(printed["figures"]) == 4
    assert len(printed["scores"]) == 3


def test_without_scores_json_has_nulls(tmp_path, capsys):
    write_posterior(make_posterior(segments_per_trial=0), tmp_path / "p.nc")
    assert run_one("report", tmp_path / "p.nc", "-o", tmp_path / "report", "--json") == 0
    out, err = capsys.readouterr()
    printed = checked_json("report", out)
    assert printed["scores"] is None
    assert printed["expected_calibration_error"] is None
    assert "no segment can be scored" in err


def test_the_line_names_the_page(post, tmp_path, capsys):
    assert run_one("report", post, "-o", tmp_path / "report") == 0
    assert f"wrote {tmp_path / 'report' / 'index.html'} (6 figures; trials: " in capsys.readouterr().out


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["--trials", "nope"], "unknown trial 'nope'"),
        (["--participants", "nope"], "unknown participant 'nope'"),
    ],
)
def test_bad_requests_are_one_line_and_write_nothing(post, tmp_path, capsys, argv, message):
    assert run_one("report", post, "-o", tmp_path / "report", *argv) == 1
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1
    assert not (tmp_path / "report").exists()


def test_json_of_a_study_has_its_table_and_its_beliefs(tmp_path, capsys):
    write_log(
        make_plays(robots=("norm", "bayes"), humans=("norm",), scenes=1, unfinished=(0,)), tmp_path / "log.nc"
    )
    assert run_one("report", tmp_path / "log.nc", "-o", tmp_path / "report", "--json") == 0
    out, err = capsys.readouterr()
    printed = checked_json("report", out)
    assert [row["robot"] for row in printed["task_performance"]["pooled"]] == ["norm", "bayes"]
    # one scene says nothing of how scenes differ
    assert printed["task_performance"]["pooled"][0]["total_s_sem"] is None
    assert printed["beliefs"][0]["sem"] is None
    assert printed["scores"] is None
    assert "1 of 2 trials were not finished" in err


def test_a_log_of_two_agents_among_goals_has_scores_of_beliefs(tmp_path, capsys):
    write_log(example_interaction_log(), tmp_path / "log.nc")
    assert run_one("report", tmp_path / "log.nc", "-o", tmp_path / "report", "--json") == 0
    printed = checked_json("report", capsys.readouterr().out)
    assert [row["belief"] for row in printed["conditional_scores"][::3]] == [
        "without the robot",
        "given the robot's goal",
        "overall",
        "goal-coupled",
    ]
    assert printed["game_performance"] is None
    assert printed["scores"] is None


def test_a_log_of_games_has_what_the_game_counts(tmp_path, capsys):
    study = GameStudy(robots=("naive", "influence"), humans=("moving",), duration=3.0, goals=(3, 4))
    write_log(log_of_study(study, range(study.trials)), tmp_path / "log.nc")
    assert run_one("report", tmp_path / "log.nc", "-o", tmp_path / "report", "--json") == 0
    printed = checked_json("report", capsys.readouterr().out)
    pooled = printed["game_performance"]["pooled"]
    assert [(row["robot"], row["goals"]) for row in pooled] == [
        ("naive", 3),
        ("influence", 3),
        ("naive", 4),
        ("influence", 4),
    ]


def test_an_unsound_log_has_a_page_and_the_status_of_validate(tmp_path, capsys):
    log = example_interaction_log()
    log["time"].values[5] = -1.0
    write_signed(log, tmp_path / "log.nc")
    assert run_one("report", tmp_path / "log.nc", "-o", tmp_path / "report", "--json") == 1
    out, err = capsys.readouterr()
    printed = checked_json("report", out)
    assert [fault["kind"] for fault in printed["faults"]] == ["time-not-increasing"]
    assert printed["metrics"] is None
    assert printed["tests"] is None
    assert err.count("\n") == 1
    assert "nothing is concluded from it" in err
    assert (tmp_path / "report" / "index.html").exists()


def test_a_log_without_a_posterior_is_inferred_by_a_model_of_ones_choice(tmp_path, capsys):
    write_log(reaches(conditions=("a", "b", "c")), tmp_path / "log.nc")
    argv = (
        "report",
        tmp_path / "log.nc",
        "-o",
        tmp_path / "report",
        "--model",
        "nearest",
        "--set",
        "scale=2",
    )
    assert run_one(*argv, "--human", "walker", "--json") == 0
    printed = checked_json("report", capsys.readouterr().out)
    assert len(printed["scores"]) == 3
    assert {row["metric"] for row in printed["metrics"]["groups"]} >= {"accuracy", "duration_s"}
    assert printed["tests"]["within"] == "condition"
    assert printed["tests"]["why_none"] is None
    assert {row["dv"] for row in printed["tests"]["posthoc"]} >= {"log_posterior"}
