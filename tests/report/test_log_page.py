"""The page about any log: the posterior that a model infers for it, and the paths."""

import numpy as np
import pytest

from ppinfer.errors import ModelError
from ppinfer.goals import GoalLQR, NearestGoal
from ppinfer.goals.configuration import write_model
from ppinfer.plots.motion_data import read_motion
from ppinfer.report import write_report
from ppinfer.studies import (
    calibrate_posterior,
    infer_posterior,
    open_posterior,
    score_posterior,
    write_log,
)
from ppinfer.testing.example_plays import example_planned_log

from .logs import reaches
from .pages import Page


def _report(tmp_path, log, **options):
    write_log(log, tmp_path / "log.nc")
    return write_report(tmp_path / "log.nc", tmp_path / "report", **options)


def _words(report):
    return Page(report.page.read_text()).words


def test_scores_and_calibration_are_those_of_a_posterior_that_is_inferred_by_itself(tmp_path):
    report = _report(tmp_path, reaches())
    infer_posterior(tmp_path / "log.nc", tmp_path / "post.nc", GoalLQR())
    with open_posterior(tmp_path / "post.nc") as posterior:
        scores = score_posterior(posterior, at=[0.25, 0.5, 0.75])
        error = calibrate_posterior(posterior).expected_calibration_error
    assert report.scores.overall == scores.overall
    assert report.calibration.expected_calibration_error == error
    assert [path.name for path in report.figures][:3] == ["paths.png", "scores.png", "participants.png"]
    assert not list(tmp_path.glob("**/posterior.nc"))


def test_a_model_at_its_defaults_is_said_not_to_be_fitted_and_a_file_of_a_model_is_named(tmp_path):
    log = reaches()
    assert "by goal-lqr, at its defaults, not fitted: fit before you conclude." in _words(
        _report(tmp_path, log)
    )
    write_model(NearestGoal(scale=0.5), tmp_path / "near.toml", {})
    words = _words(_report(tmp_path, log, model=str(tmp_path / "near.toml")))
    assert "by nearest, with the parameters of near.toml." in words
    assert "not fitted" not in words
    words = _words(_report(tmp_path, log, model="nearest", parameters={"scale": "2.0"}))
    assert "by nearest, with parameters given by hand, not fitted" in words
    assert "--model nearest --set scale=2.0" in words
    with pytest.raises(ModelError):
        _report(tmp_path, log, model="no-such-model")


def test_of_several_agents_the_one_with_most_segments_is_inferred_unless_another_is_named(tmp_path):
    log = reaches(agents=("walker", "cart", "dog"))
    report = _report(tmp_path, log)
    words = _words(report)
    assert "over the goals of walker (the agent with most segments; --human says another)" in words
    assert "In the names of metrics, the human is walker." in words
    assert report.scores is not None
    other = _report(tmp_path, log, human="cart")
    assert other.scores is None
    assert "over the goals of cart was inferred" in _words(other)


def test_goals_that_are_all_ruled_out_leave_a_page_that_says_so(tmp_path, monkeypatch):
    from ppinfer.errors import ImpossibleEvidenceError

    def refuse(*given, **options):
        raise ImpossibleEvidenceError("trial 'p1-a-0': sample 3: no goal is left")

    monkeypatch.setattr("ppinfer.report.log_page.infer_posterior", refuse)
    report = _report(tmp_path, reaches())
    assert report.scores is None
    assert "trial 'p1-a-0': sample 3: no goal is left" in report.warnings[0]
    assert report.metrics is not None


def test_trials_without_goals_are_shown_by_place_or_by_name(tmp_path):
    log = reaches(goals=())
    assert _report(tmp_path, log).trials == ("p1-a-0", "p2-a-1", "p3-b-1")
    assert _report(tmp_path, log, participants=["p2"]).trials == ("p2-a-0", "p2-a-1", "p2-b-1")
    assert _report(tmp_path, log, trials=["p2-b-0"]).trials == ("p2-b-0",)
    assert "The log has no goals, so nothing is inferred." in _words(_report(tmp_path, log))


def test_participants_that_are_left_out_are_not_measured(tmp_path):
    report = _report(tmp_path, reaches(), exclude=["p1"])
    row = report.to_json()["metrics"]["groups"][0]
    assert row["participants"] == 2
    assert "trials on this page 8" in _words(report)


def test_of_long_logs_some_trials_are_drawn_and_hands_where_there_are_hands(monkeypatch):
    log = reaches()
    monkeypatch.setattr("ppinfer.plots.motion_data._MOST_SAMPLES", 40)
    motion = read_motion(log)
    assert (motion.trials, motion.of_all) == (3, 12)
    np.testing.assert_array_equal(motion.position[12:24], log["position"].values[48:60])
    monkeypatch.undo()
    planned = example_planned_log(trials=1, replans=2)
    motion = read_motion(planned)
    if "end_effector" in planned:
        assert motion.axes == tuple(planned["table"].values[:2])
