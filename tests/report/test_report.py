import json
import os
import re

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.report import write_report
from ppinfer.report.trial_choice import choose_trials
from ppinfer.studies.posterior import write_posterior
from ppinfer.studies.scores import score_posterior

from ..studies.posteriors import make_posterior
from .pages import Page


def _write(tmp_path, posterior=None):
    path = tmp_path / "post.nc"
    write_posterior(make_posterior(outliers=True) if posterior is None else posterior, path)
    return path


def test_the_page_holds_everything_and_asks_for_nothing(tmp_path, drawn_figures):
    report = write_report(_write(tmp_path), tmp_path / "report")
    text = report.page.read_text()
    page = Page(text)
    assert "script" not in page.tags
    assert "link" not in page.tags
    assert all(re.match(r"#|data:image/png;base64,", address) for address in page.addresses)
    assert page.tags.count("img") == len(report.figures) == 6
    assert "url(" not in text
    assert "http://" not in text.replace("http-equiv", "")
    assert "https://" not in text


def test_the_page_says_what_it_is(tmp_path):
    report = write_report(_write(tmp_path), tmp_path / "report", trials=["t0"])
    text = " ".join(" ".join(Page(report.page.read_text()).text).split())
    for part in (
        "goal-lqr",
        "rationality",
        "0.005",
        "filter: each instant uses the past only",
        "log.nc",
        "ab" * 32,
        "0.1.0",
        "finite differences of past positions",
        "ppinfer infer log.nc -o post.nc --model goal-lqr --agent human --mode filter --seed 0 --set rationality=0.005",
        "expected calibration error",
        "outliers gated",
    ):
        assert part in text


def test_the_scores_on_the_page_are_those_of_the_posterior(tmp_path):
    report = write_report(_write(tmp_path), tmp_path / "report", at=[0.3, 0.6], min_samples=11)
    expected = score_posterior(make_posterior(outliers=True), at=[0.3, 0.6], min_samples=11)
    assert report.scores.overall == expected.overall
    text = report.page.read_text()
    for score in expected.overall:
        assert f">{score.accuracy:.3f}<" in text
        assert f">−{-score.mean_log_posterior:.3f}<" in text


def test_figures_are_files_as_well(tmp_path):
    report = write_report(_write(tmp_path), tmp_path / "report")
    assert sorted(path.name for path in report.figures) == [
        "calibration.png",
        "participants.png",
        "scores.png",
        "trial-1.png",
        "trial-2.png",
        "trial-3.png",
    ]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in report.figures)


def test_the_same_posterior_makes_the_same_page(tmp_path, drawn_figures):
    path = _write(tmp_path)
    one = write_report(path, tmp_path / "one", trials=["t0"]).page.read_bytes()
    two = write_report(path, tmp_path / "two", trials=["t0"]).page.read_bytes()
    assert one == two


def test_what_a_log_says_cannot_become_markup(tmp_path):
    evil = '<script>alert("1")</script>'
    posterior = make_posterior(goals=(evil, "b'\"&", "$c$"))
    posterior["participant"].values[:] = evil
    posterior["trial_id"].values[:] = [evil + str(i) for i in range(4)]
    posterior["condition"] = ("trial", np.array([evil] * 4, dtype=object))
    for name in ("model", "agent", "mode", "input", "configuration", "state_source", "extra"):
        posterior.attrs[name] = evil
    posterior.attrs[evil] = evil
    report = write_report(_write(tmp_path, posterior), tmp_path / "report")
    text = report.page.read_text()
    page = Page(text)
    assert "script" not in page.tags
    assert "<script" not in text
    assert evil in "".join(page.text)


def test_a_posterior_without_segments_still_has_a_page(tmp_path):
    report = write_report(_write(tmp_path, make_posterior(segments_per_trial=0)), tmp_path / "report")
    assert report.scores is None
    assert report.warnings == ("no segment can be scored: the log names no segments with true goals",)
    assert report.warnings[0] in report.page.read_text()
    assert report.trials == ("t0", "t2", "t3")
    assert len(report.figures) == 3


def test_impossible_true_goals_are_said_on_the_page(tmp_path):
    posterior = make_posterior(goals=("a", "b"))
    posterior["true_goal"].values[:] = "b"
    posterior["log_posterior"].values[:] = [0.0, -np.inf]
    report = write_report(_write(tmp_path, posterior), tmp_path / "report")
    assert "the true goal of 8 of 8 segments has probability zero" in report.page.read_text()


def test_chosen_trials_are_shown_once_in_the_order_asked(tmp_path):
    report = write_report(_write(tmp_path), tmp_path / "report", trials=["t2", "t0", "t2"])
    assert report.trials == ("t2", "t0")


def test_unknown_trials_are_refused_before_anything_is_written(tmp_path):
    with pytest.raises(LogError, match="unknown trial 't7'; the posterior has 4"):
        write_report(_write(tmp_path), tmp_path / "report", trials=["t7"])
    assert os.listdir(tmp_path) == ["post.nc"]


def test_best_typical_and_worst_trials_are_chosen_by_score():
    posterior = make_posterior(
        row_sizes=(20,) * 5, participants=("p",) * 5, segments_per_trial=1, goals=("a", "b")
    )
    posterior["true_goal"].values[:] = "a"
    sure = np.repeat([0.5, 0.9, 0.2, 0.6, 0.4], 20)
    posterior["log_posterior"].values[:] = np.log(np.column_stack([sure, 1 - sure]))
    chosen = choose_trials(posterior, score_posterior(posterior))
    assert [(each.index, each.why.split(":")[0].split(" score")[0]) for each in chosen] == [
        (0, "typical"),
        (1, "the best"),
        (2, "the worst"),
    ]


def test_an_earlier_report_is_replaced_and_other_files_stay(tmp_path):
    path, folder = _write(tmp_path), tmp_path / "report"
    write_report(path, folder, trials=["t0", "t1"])
    (folder / "notes.txt").write_text("mine")
    (folder / "figures" / "mine.png").write_text("mine")
    write_report(path, folder, trials=["t0"])
    assert sorted(os.listdir(folder)) == ["figures", "index.html", "notes.txt"]
    assert sorted(os.listdir(folder / "figures")) == [
        "calibration.png",
        "mine.png",
        "participants.png",
        "ppinfer-report.json",
        "scores.png",
        "trial-1.png",
    ]
    assert sorted(os.listdir(tmp_path)) == ["post.nc", "report"]


def test_a_manifest_cannot_remove_files_elsewhere(tmp_path):
    path, folder = _write(tmp_path), tmp_path / "report"
    write_report(path, folder, trials=["t0"])
    (tmp_path / "keep.png").write_text("mine")
    (folder / "figures" / "ppinfer-report.json").write_text(json.dumps(["../../keep.png", 3, ".."]))
    write_report(path, folder, trials=["t0"])
    assert (tmp_path / "keep.png").exists()


def test_a_foreign_page_and_a_file_are_left_alone(tmp_path):
    path = _write(tmp_path)
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "index.html").write_text("<h1>mine</h1>")
    with pytest.raises(LogError, match="was not written by ppinfer report"):
        write_report(path, tmp_path / "site")
    (tmp_path / "file").write_text("mine")
    with pytest.raises(LogError, match="is a file; a report is a folder"):
        write_report(path, tmp_path / "file")
    assert os.listdir(tmp_path / "site") == ["index.html"]


def test_a_failure_while_writing_leaves_no_folder(tmp_path, monkeypatch):
    path = _write(tmp_path)

    def fail(source, target):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("ppinfer.report.folder.os.rename", fail)
    with pytest.raises(OSError, match="No space"):
        write_report(path, tmp_path / "report", trials=["t0"])
    assert os.listdir(tmp_path) == ["post.nc"]


def test_progress_counts_every_figure(tmp_path):
    seen = []
    write_report(
        _write(tmp_path), tmp_path / "report", progress=lambda done, total: seen.append((done, total))
    )
    assert seen == [(i, 6) for i in range(1, 7)]
