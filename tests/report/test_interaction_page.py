import re
from pathlib import Path

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.goals.coupled import GoalCoupled
from ppinfer.report import write_report
from ppinfer.report.interaction_choice import StretchNumbers, choose_stretches, stretch_numbers
from ppinfer.report.interaction_figures import safety_sample
from ppinfer.report.rendering import number
from ppinfer.studies import (
    infer_log_conditional,
    infer_posterior,
    open_posterior,
    read_log,
    score_posterior,
    select_trials,
    write_log,
)
from ppinfer.studies.game_performance import game_performance
from ppinfer.studies.interaction import Stretch, read_interaction, stretches
from ppinfer.studies.storage import write_signed
from ppinfer.testing import example_interaction_log
from ppsim.reaching import GameStudy
from ppsim.study import log_of_study

from .pages import Page

SHIPPED = Path(__file__).parents[2] / "data" / "reaching-small.nc"


@pytest.fixture(scope="module")
def games():
    study = GameStudy(
        games=2, robots=("naive", "influence"), humans=("stubborn", "moving"), duration=6.0, seed=2
    )
    return log_of_study(study, range(study.trials))


def _report(tmp_path, log, **options):
    write_log(log, tmp_path / "log.nc")
    return write_report(tmp_path / "log.nc", tmp_path / "report", **options)


def test_the_page_of_games_has_its_pictures_tables_and_sheet(tmp_path, games, drawn_figures):
    report = _report(tmp_path, games)
    names = [path.name for path in report.figures]
    shown = len([name for name in names if name.startswith("interaction")])
    assert names == [
        *(f"interaction-{n}.png" for n in range(1, shown + 1)),
        "safety.png",
        "calibration.png",
        "game-performance.png",
        "metrics.png",
    ]
    assert 1 <= shown <= 3
    text = report.page.read_text()
    page = Page(text)
    assert page.tags.count("img") == len(report.figures)
    assert "script" not in page.tags
    assert all(re.match(r"#|data:image/png;base64,", address) for address in page.addresses)
    for part in (
        "How well they scored as a team",
        "Chosen by the numbers alone",
        "live, given the robot (live_log_post)",
        "How safe is the robot?",
        "robots naive: 4, influence: 4",
        "belief expected calibration error over all goals",
        "beliefs held live live_log_belief, live_log_post",
        "naive none",
        "influence reacted",
        "where people are predicted, it is the one to use",
        "The log is sound",
        "ppinfer report log.nc -o report --at 0.25 0.5 0.75",
    ):
        assert part in page.words, part
    assert set(report.trials) <= set(games["trial_id"].values)


def test_the_tables_say_what_the_study_says(tmp_path, games):
    report = _report(tmp_path, games)
    performance = game_performance(games)
    assert report.game_performance == {
        "pooled": performance.pooled(),
        "cells": performance.cells(),
        "differences": performance.differences(["naive"]),
    }
    words = Page(report.page.read_text()).words
    for row in performance.cells():
        assert (
            f"{row['robot']} {row['human']} {number(row['score'], 2)} ± {number(row['score_sem'], 2)}"
            in words
        )
    for row in report.conditional_scores:
        belief = f"{row['belief']} " if row["at"] == 0.25 else ""
        assert f"{belief}{100 * row['at']:.4g} % {number(row['accuracy'])}" in words


def test_every_belief_is_scored_on_the_same_segments(tmp_path, games):
    report = _report(tmp_path, games, at=[0.5])
    assert [row["belief"] for row in report.conditional_scores] == [
        "without the robot",
        "given the robot's goal",
        "overall",
        "goal-coupled",
        "live, without the robot (live_log_belief)",
        "live, given the robot (live_log_post)",
    ]
    assert len({row["segments"] for row in report.conditional_scores}) == 1
    plain, _, _, _, live, _ = report.conditional_scores
    assert plain["mean_log_posterior"] == pytest.approx(live["mean_log_posterior"], abs=1e-9)


def test_the_coupled_models_row_is_what_inferring_with_it_scores(tmp_path, games):
    report = _report(tmp_path, games, at=[0.5])
    infer_posterior(tmp_path / "log.nc", tmp_path / "post.nc", GoalCoupled(), restart="goals")
    (scored,) = score_posterior(open_posterior(tmp_path / "post.nc", load=True), at=[0.5]).overall
    (row,) = [row for row in report.conditional_scores if row["belief"] == "goal-coupled"]
    assert row["mean_log_posterior"] == pytest.approx(scored.mean_log_posterior, abs=1e-9)


def test_the_beliefs_of_a_robot_of_ones_own_are_said_to_be_in_the_log_alone(tmp_path, games):
    log = games.copy(deep=True)
    log["controller"] = log["controller"].copy(
        data=np.where(log["controller"] == "naive", "m:Mine", log["controller"]).astype(object)
    )
    words = Page(_report(tmp_path, log).page.read_text()).words
    assert "How m:Mine took the human to react is not in the log" in words


def test_a_log_without_scores_or_live_beliefs_has_the_rest(tmp_path):
    report = _report(tmp_path, example_interaction_log())
    assert report.game_performance is None
    assert [path.name for path in report.figures][-2:] == ["safety.png", "calibration.png"]
    assert len(report.conditional_scores) == 12
    words = Page(report.page.read_text()).words
    assert "scored as a team" not in words
    assert "The log holds no live beliefs." in words


def test_the_shipped_log_makes_the_page_it_always_made(tmp_path):
    report = write_report(SHIPPED, tmp_path / "report")
    assert report.trials == ("p3-0", "p6-3")
    assert report.warnings == ()
    told = {
        row["belief"]: round(row["mean_log_posterior"], 2)
        for row in report.conditional_scores
        if row["at"] == 0.5
    }
    assert told == {
        "without the robot": -2.54,
        "given the robot's goal": -3.16,
        "overall": -1.87,
        "goal-coupled": -0.76,
    }


def test_named_trials_are_shown_and_unknown_ones_refused(tmp_path, games):
    name = str(games["trial_id"].values[3])
    assert _report(tmp_path, games, trials=[name]).trials == (name,)
    with pytest.raises(LogError, match="unknown trial 'nope'; the log has 8"):
        write_report(tmp_path / "log.nc", tmp_path / "other", trials=["nope"])
    assert not (tmp_path / "other").exists()


def test_participants_that_are_left_out_count_nowhere(tmp_path, games):
    report = _report(tmp_path, games, exclude=["simulated moving"])
    assert {row["human"] for row in report.game_performance["cells"]} == {"stubborn"}
    assert all(name.endswith("/stubborn") for name in report.trials)
    with pytest.raises(LogError, match="unknown participant 'nobody'"):
        write_report(tmp_path / "log.nc", tmp_path / "other", participants=["nobody"])


def test_without_segments_nothing_is_scored_and_that_is_said(tmp_path):
    log = example_interaction_log()
    log = log.isel(segment=slice(0, 0))
    report = _report(tmp_path, log)
    assert report.conditional_scores == ()
    assert "no belief can be scored" in report.warnings[0]
    assert len(report.trials) == 1


def test_an_unsound_log_has_its_faults_and_nothing_else(tmp_path):
    log = example_interaction_log()
    log["time"].values[5] = -1.0
    write_signed(log, tmp_path / "log.nc")
    report = write_report(tmp_path / "log.nc", tmp_path / "report")
    assert report.figures == ()
    words = Page(report.page.read_text()).words
    assert "The log is not sound: its checks found 1 fault" in words
    assert "sample 5, column time 1" in words


def test_text_from_a_log_is_text_on_the_page_and_in_pictures(tmp_path, drawn_figures):
    log = example_interaction_log(trials=1)
    log["trial_id"] = ("trial", np.array(["<script>alert(1)</script> $x^{"], dtype=object))
    log = log.assign_coords(goal=["<b>0</b>", "$1", "_2"])
    log["true_goal"] = ("segment", np.array(["$1", "<b>0</b>"], dtype=object))
    log.attrs["title"] = "<img src=x> $"
    page = Page(_report(tmp_path, log).page.read_text())
    assert "script" not in page.tags
    assert "b" not in {tag for tag in page.tags if tag == "b"}
    assert "<script>alert(1)</script>" in page.words
    assert "<img src=x> $" in page.words


def test_agents_of_other_names_are_the_robot_and_the_human_that_they_are_said_to_be(tmp_path):
    log = example_interaction_log()
    told = _report(tmp_path, log).conditional_scores
    renamed = log.assign_coords(
        agent=["walker" if name == "human" else "cart" for name in log["agent"].values]
    )
    renamed["segment_agent"] = ("segment", np.array(["walker"] * log.sizes["segment"], dtype=object))
    report = _report(tmp_path, renamed, robot="cart", human="walker")
    assert [row["mean_log_posterior"] for row in report.conditional_scores] == [
        row["mean_log_posterior"] for row in told
    ]
    words = Page(report.page.read_text()).words
    assert "A walker and a cart among goals" in words
    assert "given the cart's goal" in words
    assert "--robot cart --human walker" in words


def test_a_model_that_is_asked_for_is_scored_beside_the_beliefs(tmp_path):
    report = _report(tmp_path, example_interaction_log(), model="nearest", at=[0.5])
    assert [row["belief"] for row in report.conditional_scores][-1] == "nearest at its defaults"


def test_stretches_are_chosen_by_difference_gain_and_loss_and_each_once():
    row = [Stretch(0, 10 * n, 10 * n + 10) for n in range(5)]
    numbers = StretchNumbers(
        tuple(row), np.array([0.1, 0.9, 0.2, 0.3, 1.0]), np.array([0.5, -0.4, -0.1, np.nan, np.nan])
    )
    everything = np.ones(5, dtype=bool)
    chosen = choose_stretches(numbers, everything, whole=everything)
    assert [each.stretch for each in chosen] == [row[1], row[0]]
    assert chosen[0].why == "the robot makes most difference: 0.90 on average"
    unknown = StretchNumbers(tuple(row), numbers.difference, np.full(5, np.nan))
    assert [each.stretch for each in choose_stretches(unknown, everything, whole=everything)] == [row[4]]
    short = choose_stretches(unknown, everything, whole=np.arange(5) == 2)
    assert [each.stretch for each in short] == [row[2]]
    assert choose_stretches(unknown, ~everything, whole=everything) == []


def test_the_numbers_of_a_stretch_are_means_over_its_samples():
    row = [Stretch(0, 0, 2), Stretch(0, 2, 5)]
    belief = np.tile([0.5, 0.5], (5, 1))
    given = np.array([[0.5, 0.5], [0.9, 0.1], [0.1, 0.9], [0.1, 0.9], [0.1, 0.9]])
    numbers = stretch_numbers(row, belief, given, np.array([0, 0, -1, 1, 0]))
    np.testing.assert_allclose(numbers.difference, [0.2, 0.4])
    np.testing.assert_allclose(numbers.gain, [0.2, 0.0], atol=1e-12)


def test_the_moment_of_safety_is_a_second_before_they_come_near_whatever_a_tracker_jumps():
    log = example_interaction_log(trials=1)
    position = log["position"].values
    position[:, 0], position[:, 1] = 0.0, 0.0
    position[:20, 1, 0] = np.linspace(8.0, 0.0, 20)
    position[4, 1] = 0.0
    one = read_interaction(log, infer_log_conditional(log), stretches(log, "human")[0])
    near = float(one.time[safety_sample(one)])
    assert 0.7 <= near <= 1.0
    assert one.closest == 4


def test_a_trial_by_itself_is_read_as_it_is_in_the_whole_log(games):
    whole = infer_log_conditional(games)
    one = infer_log_conditional(select_trials(games, [2]))
    first = int(games["row_size"].values[:2].sum())
    here = slice(first, first + one.sizes["sample"])
    np.testing.assert_allclose(one["log_post"].values, whole["log_post"].values[here], atol=1e-12)


def test_the_shipped_games_hold_live_what_is_inferred_of_them():
    path = SHIPPED.with_name("reach-games-small.nc")
    log = read_log(path)
    beliefs = infer_log_conditional(log)
    for inferred, live in (
        ("log_belief", "live_log_belief"),
        ("log_mental_model", "live_log_mental_model"),
        ("log_given", "live_log_post"),
    ):
        np.testing.assert_allclose(np.exp(beliefs[inferred].values), np.exp(log[live].values), atol=1e-10)
