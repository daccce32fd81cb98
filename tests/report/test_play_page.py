import json
import os
import re

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.plots import mean_beliefs, read_beliefs
from ppinfer.report import write_report
from ppinfer.report.play_trials import choose_plays
from ppinfer.report.rendering import number
from ppinfer.studies import write_log
from ppinfer.studies.storage import write_signed
from ppinfer.studies.task_performance import task_performance

from ..plots.plays import make_plays
from .pages import Page


def _report(tmp_path, log, **options):
    write_log(log, tmp_path / "log.nc")
    return write_report(tmp_path / "log.nc", tmp_path / "report", **options)


def _cells(row, metrics=("total_s", "robot_s", "human_s", "stops", "stop_episodes", "failures")):
    """Return what a row of the table shows."""
    digits = {"total_s": 2, "robot_s": 2, "human_s": 2}
    return " ".join(
        f"{number(row[name], digits.get(name, 3))} ± {number(row[f'{name}_sem'], digits.get(name, 3))}"
        for name in metrics
    )


def test_the_page_of_a_study_has_its_pictures_tables_and_sheet(tmp_path, drawn_figures):
    log = make_plays()
    report = _report(tmp_path, log)
    assert [path.name for path in report.figures] == [
        "beliefs.png",
        *(f"trial-{index}.png" for index in range(1, len(report.trials) + 1)),
        "task-performance.png",
        "differences-1.png",
        "humans-1.png",
        "metrics.png",
    ]
    text = report.page.read_text()
    page = Page(text)
    assert page.tags.count("img") == len(report.figures)
    assert "script" not in page.tags
    assert all(re.match(r"#|data:image/png;base64,", address) for address in page.addresses)
    for part in (
        "Plays made by hand",
        "Paired differences from norm",
        "bayes against each human",
        "What was believed of each human",
        "scenes 2",
        "robots defensive: 6, norm: 6, bayes: 6",
        "The log is sound",
        "source a test",
        'live model {"model": "personality"}',
    ):
        assert part in page.words, part


def test_the_tables_say_what_the_study_says(tmp_path):
    log = make_plays(plan_sets=("shared", "independent"))
    report = _report(tmp_path, log)
    performance = task_performance(log)
    words = Page(report.page.read_text()).words
    for row in performance.pooled():
        assert f"{row['robot']} {row['plan_sets']} {_cells(row)} {row['trials']}" in words
    for row in performance.cells():
        assert f"{row['robot']} {row['human']} {row['plan_sets']} {_cells(row)} {row['trials']}" in words
    differences = performance.differences(["norm"])
    for time in (row for row in differences if row["metric"] == "total_s"):
        interval = f"{number(time['mean'], 2)} {number(time['low'], 2)} to {number(time['high'], 2)}"
        assert f"{time['robot']} {time['plan_sets']} {interval}" in words
    assert report.task_performance == {
        "pooled": performance.pooled(),
        "cells": performance.cells(),
        "differences": differences,
    }
    for one in mean_beliefs(read_beliefs(log)):
        assert f"{one.robot} {one.human} {one.plan_sets} {number(one.mean)} {number(one.sem)} 2" in words


def test_norm_and_norm_with_commitment_are_what_others_are_compared_with(tmp_path):
    log = make_plays(robots=("norm", "norm-committed", "selfish"), humans=("norm",))
    report = _report(tmp_path, log)
    against = dict.fromkeys(row["against"] for row in report.task_performance["differences"])
    assert set(against) == {"norm", "norm-committed"}
    assert {"differences-1.png", "differences-2.png"} <= {path.name for path in report.figures}


def test_one_robot_alone_has_no_differences_and_one_scene_no_intervals(tmp_path):
    log = make_plays(robots=("defensive",), humans=("norm",), scenes=1)
    report = _report(tmp_path, log)
    assert [path.name for path in report.figures] == ["trial-1.png", "task-performance.png", "humans-1.png"]
    assert report.task_performance["differences"] == []
    assert report.beliefs is None
    words = Page(report.page.read_text()).words
    assert "± –" in words
    assert "there is one scene" in report.warnings[0]
    assert "nan" not in words


def test_one_scene_has_differences_without_intervals(tmp_path):
    report = _report(tmp_path, make_plays(robots=("norm", "bayes"), humans=("norm",), scenes=1))
    words = Page(report.page.read_text()).words
    assert "– to –" in words
    assert np.isnan(report.task_performance["differences"][0]["low"])


def test_unfinished_trials_are_counted_and_said(tmp_path):
    log = make_plays(unfinished=(1, 5))
    report = _report(tmp_path, log)
    (warning,) = report.warnings
    assert warning.startswith("2 of 18 trials were not finished")
    words = Page(report.page.read_text()).words
    assert warning in words
    assert "trials not finished 2" in words


def test_a_log_without_replans_has_its_numbers_and_distances(tmp_path):
    log = make_plays(robots=("norm", "bayes"), humans=("norm",))
    planned = [
        name
        for name, variable in log.variables.items()
        if name.startswith("replan") or {"replan", "plan", "waypoint", "profile", "theta"} & {*variable.dims}
    ]
    report = _report(tmp_path, log.drop_vars(planned))
    assert report.beliefs is None
    assert "trial-1.png" in [path.name for path in report.figures]
    assert "beliefs.png" not in [path.name for path in report.figures]


def test_a_log_of_zarr_has_the_page_of_its_netcdf(tmp_path):
    log = make_plays(robots=("norm",), humans=("norm",))
    write_log(log, tmp_path / "log.zarr")
    one = write_report(tmp_path / "log.zarr", tmp_path / "one")
    assert one.to_json()["task_performance"] == _report(tmp_path, log).to_json()["task_performance"]


def test_an_unsound_log_is_told_its_faults_and_nothing_is_concluded(tmp_path):
    log = make_plays(robots=("norm",), humans=("norm",))
    log["time"].values[3] = 0.0
    write_signed(log, tmp_path / "log.nc")
    report = write_report(tmp_path / "log.nc", tmp_path / "report")
    assert report.figures == ()
    assert report.task_performance is None
    assert report.warnings[0].startswith("the log has ")
    words = Page(report.page.read_text()).words
    assert "The log is not sound: its checks found" in words
    assert "trial scene-0/shared/norm/norm, sample 3" in words


def test_what_a_study_log_says_cannot_become_markup(tmp_path):
    evil = '<script>alert("1")</script>'
    log = make_plays(robots=(evil, "norm"), humans=(evil,), believers=(evil,))
    log.attrs |= {"title": evil, "source": evil, "configuration": evil, evil: evil}
    log["participant"].values[:] = evil
    log["live_model"].values[:] = json.dumps({"model": evil, "parameters": {}})
    text = _report(tmp_path, log).page.read_text()
    assert "<script" not in text
    assert evil in "".join(Page(text).text)


def test_the_same_study_makes_the_same_page(tmp_path, drawn_figures):
    log = make_plays(robots=("bayes",), humans=("norm",))
    one = _report(tmp_path, log).page.read_bytes()
    assert write_report(tmp_path / "log.nc", tmp_path / "again").page.read_bytes() == one


def test_participants_are_chosen_before_anything_is_averaged(tmp_path):
    log = make_plays(robots=("norm", "bayes"))
    report = _report(tmp_path, log, participants=["simulated norm"])
    assert {row["human"] for row in report.task_performance["cells"]} == {"norm"}
    assert {one.human for one in report.beliefs} == {"norm"}
    assert all(name.endswith("/norm") for name in report.trials)
    assert "trials on this page 4" in Page(report.page.read_text()).words
    with pytest.raises(LogError, match="unknown participant 'nobody'; there are 'simulated defensive'"):
        write_report(tmp_path / "log.nc", tmp_path / "other", exclude=["nobody"])
    with pytest.raises(LogError, match="no trial is left"):
        write_report(
            tmp_path / "log.nc",
            tmp_path / "other",
            participants=["simulated norm"],
            exclude=["simulated norm"],
        )
    assert not (tmp_path / "other").exists()


@pytest.mark.parametrize("options", [{"at": [0.3]}, {"min_samples": 4}, {"min_distance": 0.1}])
def test_segments_cannot_be_chosen_where_there_are_none(tmp_path, options):
    log = make_plays(robots=("norm",), humans=("norm",), scenes=1)
    (name,) = options
    with pytest.raises(LogError, match=f"{name} chooses segments with a goal, of which this file has none"):
        _report(tmp_path, log, **options)
    assert os.listdir(tmp_path) == ["log.nc"]


def test_progress_counts_every_figure_of_a_study(tmp_path):
    seen = []
    report = _report(
        tmp_path,
        make_plays(robots=("norm", "bayes"), humans=("norm",)),
        progress=lambda done, total: seen.append((done, total)),
    )
    assert seen == [(i, len(report.figures)) for i in range(1, len(report.figures) + 1)]


def test_trials_of_a_study_are_chosen_by_name_or_by_belief_and_stops(tmp_path):
    log = make_plays(robots=("norm", "bayes"))
    stops = np.zeros(12, int)
    beliefs = read_beliefs(log)
    quiet = choose_plays(beliefs, "human", stops=stops, among=np.ones(12, bool))
    # a trial of the robot whose beliefs are looked at that is not shown for another reason
    stopped = next(trial for trial in np.unique(beliefs.trial) if trial not in {each.index for each in quiet})
    stops[stopped] = 9
    chosen = choose_plays(beliefs, "human", stops=stops, among=np.ones(12, bool))
    whys = [each.why for each in chosen]
    assert whys[0] == "highest mean p(theta = human)"
    assert whys[-1] == "most safety stops: 9"
    assert chosen[-1].index == stopped
    means = {
        int(trial): beliefs.of("human")[beliefs.trial == trial].mean() for trial in np.unique(beliefs.trial)
    }
    assert chosen[0].index == max(means, key=means.get)
    assert chosen[1].index == min(means, key=means.get)
    report = _report(tmp_path, log, trials=["scene-1/shared/norm/norm"])
    assert report.trials == ("scene-1/shared/norm/norm",)
    assert "Chosen by name." in Page(report.page.read_text()).words
    with pytest.raises(LogError, match="unknown trial 't7'; the log has 12"):
        write_report(tmp_path / "log.nc", tmp_path / "other", trials=["t7"])


def test_the_trials_of_bayes_are_shown_where_several_robots_held_a_belief():
    log = make_plays(robots=("bayes-literal", "bayes"))
    chosen = choose_plays(read_beliefs(log), "human", stops=None, among=np.ones(12, bool))
    names = log["trial_id"].values
    assert all("/bayes/" in names[each.index] for each in chosen)
    assert all(each.why.startswith("of bayes: ") for each in chosen)


def test_without_beliefs_and_stops_the_first_trial_is_shown():
    assert [
        (each.index, each.why)
        for each in choose_plays(None, "human", stops=np.zeros(3, int), among=np.array([False, True, True]))
    ] == [(1, "the first in the file")]


def test_what_an_oracle_was_told_is_no_belief(tmp_path):
    log = make_plays(robots=("oracle", "bayes"), believers=("oracle", "bayes"))
    told = np.array(["/oracle/" in name for name in log["trial_id"].values.tolist()])
    log["live_model"].values[told] = ""
    report = _report(tmp_path, log)
    assert {one.robot for one in report.beliefs} == {"bayes"}
    words = Page(report.page.read_text()).words
    assert "bayes against each human" in words
    assert "oracle against each human" not in words


def test_agents_of_other_names_are_told_by_options_or_have_a_page_without_pairs(tmp_path):
    log = make_plays(robots=("norm", "bayes"), humans=("norm",))
    told = _report(tmp_path, log).task_performance
    names = {"robot": "arm", "human": "person"}
    renamed = log.assign_coords(agent=[names[str(name)] for name in log["agent"].values])
    renamed = renamed.assign_coords(theta=[names[str(name)] for name in log["theta"].values])
    renamed["replan_agent"] = (
        "replan",
        np.array([names[str(name)] for name in log["replan_agent"].values], dtype=object),
    )
    report = _report(tmp_path, renamed, robot="arm", human="person")
    assert report.task_performance == told
    assert {one.label for one in report.beliefs} == {"person"}
    alone = write_report(tmp_path / "log.nc", tmp_path / "alone")
    assert alone.task_performance is None
    assert "--robot and --human say" in Page(alone.page.read_text()).words
    with pytest.raises(LogError, match="--robot hand: there is no such agent in the log; there are"):
        write_report(tmp_path / "log.nc", tmp_path / "other", robot="hand")
