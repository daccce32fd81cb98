from collections import Counter

import numpy as np
import pytest

from ppinfer.coordination import LiteralPersonality
from ppinfer.errors import LogError
from ppinfer.plots import mean_beliefs, read_beliefs
from ppinfer.report import write_report
from ppinfer.report.rendering import number
from ppinfer.studies.personality_inference import infer_log_personality
from ppinfer.studies.theta_posterior import write_theta_posterior
from ppinfer.testing.example_plays import example_planned_log

from .pages import Page


@pytest.fixture(scope="module")
def log():
    return example_planned_log(trials=6, replans=6)


def _report(tmp_path, posterior, **options):
    write_theta_posterior(posterior, tmp_path / "post.nc")
    return write_report(tmp_path / "post.nc", tmp_path / "report", **options)


def test_the_page_says_what_was_believed_of_whom_and_how_it_was_computed(tmp_path, log, drawn_figures):
    posterior = infer_log_personality(log)
    posterior.attrs |= {"input": "plays.nc", "seed": 3}
    report = _report(tmp_path, posterior)
    names = [path.name for path in report.figures]
    assert names == ["beliefs.png", *(f"trial-{index}.png" for index in range(1, len(names)))]
    words = Page(report.page.read_text()).words
    for part in (
        "Whom does the human favour?",
        "at every replan of the robot, whom the human's choice of equilibria favours",
        *(
            f"applied to {count} trial{'s' * (count > 1)} {model}"
            for model, count in Counter(posterior["model"].values.tolist()).items()
        ),
        "who controlled the robot "
        + ", ".join(
            f"{name}: {count}"
            for name, count in Counter(posterior["controller"].values[:, 1].tolist()).items()
        ),
        "against what was believed live probabilities differ by at most",
        "ppinfer infer plays.nc -o post.nc --model personality --agent robot --seed 3",
    ):
        assert part in words, part
    expected = mean_beliefs(read_beliefs(posterior))
    assert [one.mean for one in report.beliefs] == [one.mean for one in expected]
    for one in expected:
        assert f"{one.robot} {one.human} {one.plan_sets} {number(one.mean)} {number(one.sem)}" in words


def test_the_command_names_the_model_and_its_parameters(tmp_path, log):
    posterior = infer_log_personality(log, LiteralPersonality(rationality=5.0))
    report = _report(tmp_path, posterior)
    words = Page(report.page.read_text()).words
    assert "--variant literal --set rationality=5.0 dominance=weak" in words


def test_beliefs_of_the_human_are_about_the_robot(tmp_path, log):
    report = _report(tmp_path, infer_log_personality(log, agent="human"))
    words = Page(report.page.read_text()).words
    assert "Whom does the robot favour?" in words
    assert "mean p(robot favours itself)" in words
    assert {one.label for one in report.beliefs} == {"robot"}
    assert {one.robot for one in report.beliefs} == {"norm"}  # the human's controller: whose beliefs they are


def test_trials_and_participants_are_chosen_by_name(tmp_path, log):
    report = _report(
        tmp_path, infer_log_personality(log), trials=["scene-2"], participants=["scene-2", "scene-4"]
    )
    assert report.trials == ("scene-2",)
    assert sum(one.trials for one in report.beliefs) == 2
    with pytest.raises(LogError, match="unknown trial 'none'; the posterior has 6"):
        write_report(tmp_path / "post.nc", tmp_path / "other", trials=["none"])
    with pytest.raises(LogError, match="min_samples chooses segments"):
        write_report(tmp_path / "post.nc", tmp_path / "other", min_samples=3)


def test_what_a_posterior_over_theta_says_cannot_become_markup(tmp_path, log):
    evil = '<script>alert("1")</script>'
    posterior = infer_log_personality(log)
    posterior["trial_id"].values[:] = [evil + str(index) for index in range(6)]
    for name in ("participant", "model"):
        posterior[name] = ("trial", np.array([evil] * 6, object))
    posterior["controller"].values[:] = evil
    posterior.attrs |= {"configuration": evil, "input": evil, "title": evil}
    text = _report(tmp_path, posterior).page.read_text()
    assert "<script" not in text
    assert evil in "".join(Page(text).text)


def test_a_damaged_posterior_over_theta_is_refused(tmp_path, log):
    posterior = infer_log_personality(log)
    write_theta_posterior(posterior, tmp_path / "post.nc")
    data = bytearray((tmp_path / "post.nc").read_bytes())
    del data[len(data) // 2 :]
    (tmp_path / "post.nc").write_bytes(bytes(data))
    with pytest.raises(LogError):
        write_report(tmp_path / "post.nc", tmp_path / "report")
    assert not (tmp_path / "report").exists()
