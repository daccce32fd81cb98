"""The shipped logs and the real study: what was counted while they were made, and what their papers say."""

import csv
from pathlib import Path

import numpy as np
import pytest

from ppinfer.studies import open_log, read_reaching_study, task_performance
from ppinfer.studies.game_performance import GAME_METRICS, game_performance
from ppinfer.studies.metrics import trial_metrics
from ppinfer.studies.task_performance import METRICS as TASK_METRICS

from ..logs import study_data

DATA = Path(__file__).parents[3] / "data"
ROBOTS = ("baseline", "baseline_belief", "cbp")


def shipped(name):
    """Return a shipped log in memory, or skip where it is not there."""
    if not (DATA / name).exists():
        pytest.skip(f"needs data/{name}")
    return open_log(DATA / name, load=True)


@pytest.fixture(scope="module")
def study():
    folder = study_data("reaching-study")
    return folder, trial_metrics(read_reaching_study(folder))


def test_the_arms_log_has_the_task_performance_that_the_simulation_compares():
    log = shipped("arms-small.nc")
    np.testing.assert_allclose(
        trial_metrics(log, names=TASK_METRICS).values, task_performance(log).values, rtol=1e-12
    )
    found = trial_metrics(log)
    assert found.values_of("stops").sum() == 9
    assert found.rounds_are("condition") == "order"


def test_the_games_log_has_the_game_performance_that_the_simulation_counted():
    log = shipped("reach-games-small.nc")
    expected = game_performance(log).values
    np.testing.assert_allclose(trial_metrics(log, names=GAME_METRICS).values, expected, rtol=1e-12)
    # counted again from what is logged at each sample, without the counts of the simulation
    counts = ["collisions", "human_goal_changes", "robot_goal_changes", "first_score_s"]
    bare = log.drop_vars(counts)
    again = trial_metrics(bare, names=counts)
    np.testing.assert_allclose(again.values, trial_metrics(log, names=counts).values, rtol=1e-12)


def test_the_reaching_log_has_the_scores_of_its_samples_and_episodes_of_collision():
    log = shipped("reaching-small.nc")
    found = trial_metrics(log)
    ends = np.cumsum(log["row_size"].values)[:-1]
    scored = [2 * part.sum() for part in np.split(log["scored"].values, ends)]
    assert found.values_of("score").tolist() == scored
    episodes = [(np.diff(part, prepend=0) == 1).sum() for part in np.split(log["collision"].values, ends)]
    assert found.values_of("collisions").tolist() == episodes
    assert found.values_of("scoreless").sum() == 1
    assert [row.participants for row in found.by("condition")] == [6] * len(found.names)


def test_the_real_study_has_the_scores_and_collisions_of_its_table(study):
    folder, found = study
    with (folder / "trials.csv").open(newline="") as file:
        rows = {
            f"user{row['user_id']}_{row['robot_type']}_{row['game_idx']}": row for row in csv.DictReader(file)
        }
    listed = [rows[name] for name in found.trial_id]
    assert found.values_of("score").tolist() == [float(row["team_score"]) for row in listed]
    # the table holds the loop's own count, the samples its flags: they tell of the same episodes
    assert found.values_of("collisions").tolist() == [float(row["n_collisions"]) for row in listed]
    minutes = found.values_of("duration_s") / 60
    np.testing.assert_allclose(
        found.values_of("human_picks_per_minute") * minutes, [float(row["n_h"]) for row in listed], rtol=1e-9
    )


def test_the_real_study_has_its_mean_scores_by_robot(study):
    _, found = study
    rows = {(row.metric, row.group): row for row in found.by("condition")}
    means = [rows["score", robot].mean for robot in ROBOTS]
    assert means == pytest.approx([19.0909, 15.0455, 16.9545], abs=1e-4)
    assert [rows["score", robot].sem for robot in ROBOTS] == pytest.approx([0.398, 0.290, 0.384], abs=1e-3)
    assert {row.participants for row in rows.values()} == {11}
    differences = {(row.a, row.b): row for row in found.differences() if row.metric == "score"}
    reactive = differences["baseline", "baseline_belief"]
    assert reactive.mean == pytest.approx(means[0] - means[1])
    assert reactive.low > 0


def test_in_the_real_study_waiting_flags_are_not_believed_and_learning_is_by_round(study):
    _, found = study
    assert found.provenance["options"]["idle"]["from"] == "motion"
    assert "is_robot_waiting never changes" in found.warnings[0]
    assert found.rounds_are("condition") == "round"
    score = {row.group: row for row in found.learning("condition") if row.metric == "score"}
    assert [row.round for row in score["cbp"].rounds] == [0, 1, 2, 3]
    by_hand = [
        found.values_of("score")[(found.condition == "cbp") & (found.round == at)].mean() for at in range(4)
    ]
    assert [row.mean for row in score["cbp"].rounds] == pytest.approx(by_hand)
