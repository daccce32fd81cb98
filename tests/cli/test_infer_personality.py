"""``ppinfer infer --model personality``: a table, a JSON object, and one line where it cannot be done."""

import pytest

from ppinfer.studies import read_theta_posterior, write_log
from ppinfer.testing import example_log
from ppinfer.testing.example_plays import example_planned_log

from .commands import checked_json, run_one


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """Return a log with replans on disk."""
    path = tmp_path_factory.mktemp("plays") / "plays.nc"
    write_log(example_planned_log(trials=3, replans=3, robots=("bayes", "bayes-literal", "norm")), path)
    return path


def test_the_table_says_that_offline_equals_live(log, tmp_path, capsys):
    assert run_one("infer", log, "-o", tmp_path / "post.nc", "--model", "personality") == 0
    shown = capsys.readouterr().out
    assert "personality (as-logged) on plays.nc" in shown
    assert "max |difference| of a probability" in shown
    assert read_theta_posterior(tmp_path / "post.nc").attrs["agent"] == "robot"


def test_json_tells_which_models_were_applied(log, tmp_path, capsys):
    assert run_one("infer", log, "-o", tmp_path / "post.nc", "--model", "personality", "--json") == 0
    record = checked_json("infer", capsys.readouterr().out)
    assert [(one["model"], one["trials"]) for one in record["applied"]] == [
        ("personality", 2),
        ("personality-literal", 1),
    ]
    assert record["live_difference"] < 1e-10
    assert (record["trials"], record["replans"], record["live_replans"]) == (3, 9, 6)


@pytest.mark.parametrize(
    ("variant", "model"),
    [
        ("repaired", "personality"),
        ("literal", "personality-literal"),
        ("predictive", "personality-predictive"),
    ],
)
def test_a_variant_is_one_model_for_all_trials(log, tmp_path, capsys, variant, model):
    arguments = (
        "--model",
        "personality",
        "--variant",
        variant,
        "--set",
        "rationality=5",
        "--json",
        "--agent",
        "human",
    )
    assert run_one("infer", log, "-o", tmp_path / "post.nc", *arguments) == 0
    record = checked_json("infer", capsys.readouterr().out)
    (applied,) = record["applied"]
    assert (applied["model"], applied["parameters"]["rationality"], applied["trials"]) == (model, 5.0, 3)
    assert record["agent"] == "human"
    assert record["live_difference"] is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--set", "stay=0.5"), "--variant repaired, literal or predictive"),
        (("--variant", "repaired", "--set", "stays=0.5"), "no parameter 'stays'"),
        (("--variant", "literal", "--set", "stay=0.5"), "'personality-literal' has no parameter 'stay'"),
        (("--mode", "smooth"), "--mode smooth is for models of goals"),
        (("--restart", "segments"), "--restart segments is for models of goals"),
        (("--carry",), "--carry is for models of goals"),
        (("--agent", "ghost"), "no replan is of 'ghost'"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_nothing_is_written(log, tmp_path, capsys, arguments, message):
    assert run_one("infer", log, "-o", tmp_path / "post.nc", "--model", "personality", *arguments) == 1
    told = capsys.readouterr().err
    assert message in told
    assert told.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_log_without_replans_is_told_what_to_do(tmp_path, capsys):
    write_log(example_log(participants=1, trials=1), tmp_path / "log.nc")
    assert run_one("infer", tmp_path / "log.nc", "-o", tmp_path / "post.nc", "--model", "personality") == 1
    assert "holds no replans" in capsys.readouterr().err


def test_goals_of_a_planned_log_are_told_to_be_personalities(log, tmp_path, capsys):
    assert run_one("infer", log, "-o", tmp_path / "post.nc") == 1
    assert "personalities are inferred with --model personality" in capsys.readouterr().err
    assert run_one("infer", log, "-o", tmp_path / "post.nc", "--variant", "literal") == 1
    assert "--variant is for --model personality" in capsys.readouterr().err


def test_a_posterior_over_theta_is_validated_and_neither_scored_nor_compared(log, tmp_path, capsys):
    for name in ("a.nc", "b.nc"):
        assert run_one("infer", log, "-o", tmp_path / name, "--model", "personality") == 0
    capsys.readouterr()
    assert run_one("validate", tmp_path / "a.nc") == 0
    assert "sound (3 trials, 9 replans)" in capsys.readouterr().out
    for command in (("score", tmp_path / "a.nc"), ("compare", tmp_path / "a.nc", tmp_path / "b.nc")):
        assert run_one(*command) == 1
        assert "is a posterior over theta" in capsys.readouterr().err
