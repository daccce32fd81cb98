"""``ppinfer fit``: a model that others can use, and how well it predicts people left out."""

import tomllib
from pathlib import Path

import pytest

from ppinfer.goals import GoalLQR, infer_goals
from ppinfer.goals.configuration import read_model
from ppinfer.studies import read_log, write_log
from ppinfer.studies.fit import fit_study
from ppinfer.studies.goal_evidence import goal_evidence
from ppinfer.testing import example_log

from .commands import checked_json, run_one


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("fit") / "log.nc"
    write_log(example_log(participants=4, trials=6), path)
    return path


def test_the_model_says_how_it_came_about(log, tmp_path, capsys):
    assert (
        run_one("fit", log, "--model", "goal-lqr", "-o", tmp_path / "m.toml", "--set", "stay=1", "--json")
        == 0
    )
    record = checked_json("fit", capsys.readouterr().out)
    document = tomllib.loads((tmp_path / "m.toml").read_text())
    assert document["model"] == "goal-lqr"
    assert document["parameters"]["stay"] == 1.0
    assert document["fit"]["objective"] == "predictive"
    assert document["fit"]["participants"] == ["p0", "p1", "p2", "p3"]
    assert len(document["cross_validation"]["parameters"]) == 4
    assert record["cross_validation"]["folds"] == 4
    assert [score["segments"] for score in record["cross_validation"]["scores"]] == [24, 24, 24]


def test_the_table_shows_people_left_out(log, tmp_path, capsys):
    assert run_one("fit", log, "--model", "nearest", "-o", tmp_path / "m.toml", "--folds", "2") == 0
    shown = capsys.readouterr().out
    assert "participants left out, in 2 folds" in shown
    assert "expected calibration error" in shown


def test_participants_are_chosen_or_left_out(log, tmp_path, capsys):
    for arguments, expected in (
        (("--participants", "p1", "p2"), ["p1", "p2"]),
        (("--exclude", "p0"), ["p1", "p2", "p3"]),
    ):
        run_one("fit", log, "--model", "nearest", "-o", tmp_path / "m.toml", "--folds", "0", *arguments)
        assert tomllib.loads((tmp_path / "m.toml").read_text())["fit"]["participants"] == expected
    capsys.readouterr()


def test_a_participant_left_out_has_no_say_in_the_fit_that_predicts_them(log):
    fixed = ("stay", "evidence_floor")
    whole = read_log(log)
    other = whole.copy(deep=True)
    samples = (other["participant"].values.astype(str) == "p3").repeat(other["row_size"].values)
    other["control"].values[samples] *= 7.0
    ours = [fold.model for fold in fit_study(whole, GoalLQR(), fixed=fixed).folds]
    theirs = [fold.model for fold in fit_study(other, GoalLQR(), fixed=fixed).folds]
    # of four folds, the one that leaves p3 out is the same to the last bit, and the three that see p3 are not
    same = [model for model, changed in zip(ours, theirs, strict=True) if model == changed]
    assert same == [fit_study(whole, GoalLQR(), fixed=fixed, exclude=["p3"], folds=0).fit.model]


def test_people_who_never_changed_their_mind_do_not_make_a_change_impossible():
    # of the participants of the shipped log, those that one of three folds is fitted to never changed theirs
    shipped = read_log(Path(__file__).parents[2] / "data" / "reaching-small.nc")
    fitted = fit_study(shipped, GoalLQR(), folds=3)
    assert all(fold.model.stay < 1.0 for fold in fitted.folds)
    assert min(score.mean_log_posterior for score in fitted.held_out) > -1.0


def test_the_held_out_posterior_is_that_of_the_fold(log):
    whole = read_log(log)
    fitted = fit_study(whole, GoalLQR(), fixed=("stay", "evidence_floor", "control_weight"), folds=4)
    evidence = goal_evidence(whole, "human")
    held_out = fitted.held_out_posterior["log_posterior"].values
    predictions = [infer_goals(fold.model, evidence).log_posterior for fold in fitted.folds]
    for trial in range(24):
        rows = slice(20 * trial, 20 * trial + 20)
        assert any((held_out[rows] == prediction[rows]).all() for prediction in predictions)


def test_a_fit_that_could_not_be_cross_validated_says_so(log, tmp_path, capsys):
    for arguments in (("--folds", "1"), ("--participants", "p1")):
        assert run_one("fit", log, "--model", "nearest", "-o", tmp_path / "m.toml", *arguments) == 0
        assert "warning: there was no cross-validation" in capsys.readouterr().err
    assert run_one("fit", log, "--model", "nearest", "-o", tmp_path / "m.toml", "--folds", "0") == 0
    assert capsys.readouterr().err == ""


def test_the_likelihood_objective_gives_the_plain_model(log, tmp_path, capsys):
    arguments = ("--objective", "likelihood", "--folds", "0")
    assert run_one("fit", log, "--model", "goal-lqr", "-o", tmp_path / "m.toml", *arguments) == 0
    model = read_model(tmp_path / "m.toml")
    assert (model.tempering, model.stay, model.evidence_floor) == (1.0, 1.0, 0.0)
    # what example_log was simulated with
    assert model.control_weight == pytest.approx(5.0, rel=0.3)
    assert model.rationality == pytest.approx(0.02, rel=0.2)
    capsys.readouterr()


def test_the_same_fit_is_written_twice(log, tmp_path, capsys):
    for name in ("a.toml", "b.toml"):
        run_one("fit", log, "--model", "nearest", "-o", tmp_path / name)
    assert (tmp_path / "a.toml").read_text() == (tmp_path / "b.toml").read_text()
    capsys.readouterr()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--participants", "nobody"), "there is no participant 'nobody'; there are p0, p1, p2, p3"),
        (("--exclude", "p0", "p1", "p2", "p3"), "no participant is left"),
        (("-o", "nowhere/m.toml"), "there is no folder 'nowhere'"),
        (("--set", "scale=1"), "nothing left to fit"),
        (("--objective", "likelihood"), "likelihood objective is that of goal-lqr"),
    ],
)
def test_what_cannot_be_fitted_is_one_line_and_writes_nothing(log, tmp_path, capsys, arguments, message):
    assert run_one("fit", log, "--model", "nearest", "-o", tmp_path / "m.toml", *arguments) == 1
    shown = capsys.readouterr()
    assert message in shown.err
    assert shown.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_log_without_true_goals_cannot_be_fitted(tmp_path, capsys):
    log = example_log(participants=1, trials=2)
    log["true_goal"].values[:] = ""
    write_log(log, tmp_path / "log.nc")
    assert run_one("fit", tmp_path / "log.nc", "--model", "nearest", "-o", tmp_path / "m.toml") == 1
    assert "no segment of agent 'human' with a true_goal" in capsys.readouterr().err
