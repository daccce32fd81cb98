"""How teams did in the reaching game: first scores that never came, and rows that name what differs."""

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.studies.game_performance import GAME_METRICS, GamePerformance, game_performance
from ppinfer.studies.performance import PairedPerformance
from ppinfer.studies.task_performance import TaskPerformance
from ppinfer.testing import example_log
from ppsim.reaching import GameStudy
from ppsim.study import log_of_study


def performance(goals):
    """Return two robots with one human in four games; score and collisions grow with the game."""
    values = np.arange(8.0)[:, None] + np.arange(6.0)
    return GamePerformance(
        values,
        robot=np.array(["naive", "influence"] * 4),
        human=np.array(["stubborn"] * 8),
        scene=np.repeat(np.arange(4), 2),
        goals=np.array(goals),
    )


def test_rows_name_the_number_of_goals_only_where_there_are_several():
    one, two = performance([3] * 8), performance([3, 3, 5, 5] * 2)
    for rows in (one.pooled(), one.cells(), one.differences()):
        assert all("goals" not in row for row in rows)
    assert [(row["robot"], row["goals"]) for row in two.pooled()] == [
        ("naive", 3),
        ("influence", 3),
        ("naive", 5),
        ("influence", 5),
    ]
    assert {row["goals"] for row in two.differences()} == {3, 5}
    assert all(row["pairs"] == 2 for row in two.differences())


def test_differences_are_paired_by_game_and_told_for_every_metric():
    told = performance([3] * 8).differences(["naive"], resamples=200)
    assert [row["metric"] for row in told] == list(GAME_METRICS)
    assert {row["robot"] for row in told} == {"influence"}
    for row in told:
        assert (row["mean"], row["low"], row["high"], row["pairs"]) == (1.0, 1.0, 1.0, 4)


def test_a_game_without_a_score_counts_with_its_length():
    study = GameStudy(games=2, robots=("naive",), humans=("moving",), duration=0.5, seed=1)
    one = game_performance(log_of_study(study, range(2)))
    by_name = dict(zip(GAME_METRICS, one.values.T, strict=True))
    np.testing.assert_allclose(by_name["first_score_s"], 0.4)
    np.testing.assert_array_equal(by_name["scoreless"], 1.0)
    np.testing.assert_array_equal(by_name["score"], 0.0)


def test_a_log_of_something_else_is_refused_with_what_it_lacks():
    with pytest.raises(LogError, match=r"the log has no team_score, collisions, .*'ppsim reach' logs them"):
        game_performance(example_log(participants=1, trials=1))
    log = log_of_study(GameStudy(robots=("naive",), humans=("moving",), duration=0.5), range(1))
    with pytest.raises(LogError, match="there is no agent 'drone' in the log; there are human, robot"):
        game_performance(log, robot="drone")


def test_games_that_cannot_be_paired_are_refused():
    one = performance([3] * 8)
    twice = GamePerformance(one.values, one.robot, one.human, np.zeros(8, np.int64), one.goals)
    with pytest.raises(LogError, match="number the games of joined studies apart"):
        twice.differences()


def test_both_worlds_are_summed_up_by_one_implementation():
    for name in ("pooled", "cells", "_difference", "_pairs"):
        assert getattr(TaskPerformance, name) is getattr(PairedPerformance, name)
        assert getattr(GamePerformance, name) is getattr(PairedPerformance, name)
