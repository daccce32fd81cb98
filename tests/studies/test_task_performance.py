import numpy as np
import pytest
from numpy.testing import assert_allclose

from ppinfer.errors import LogError
from ppinfer.studies.task_performance import METRICS, TaskPerformance, task_performance
from ppinfer.testing.example_plays import example_planned_log


def performance(values, robot, *, human=None, plan_sets=None, scene=None):
    trials = len(values)
    return TaskPerformance(
        np.asarray(values, float),
        robot=np.array(robot),
        human=np.array(["norm"] * trials if human is None else human),
        plan_sets=np.array(["shared"] * trials if plan_sets is None else plan_sets),
        scene=np.arange(trials) if scene is None else np.array(scene),
    )


def study(rng, scenes=40, robots=("norm", "bayes", "selfish"), humans=("norm", "selfish")):
    """Return a study whose trials share what their scene is like."""
    cells = [(scene, human, robot) for scene in range(scenes) for human in humans for robot in robots]
    ease = rng.normal(size=scenes)
    values = np.array([ease[scene] + robots.index(robot) + rng.normal(size=6) for scene, _, robot in cells])
    scene, human, robot = zip(*cells, strict=True)
    return performance(values, robot, human=human, scene=scene)


def test_means_are_those_of_the_trials_and_errors_those_of_the_scenes():
    one = study(np.random.default_rng(0))
    row = next(row for row in one.pooled() if row["robot"] == "bayes")
    here = one.values[one.robot == "bayes"]
    by_scene = here.reshape(40, 2, 6).mean(axis=1)
    for at, metric in enumerate(METRICS):
        assert_allclose(row[metric], here[:, at].mean())
        assert_allclose(row[f"{metric}_sem"], by_scene[:, at].std(ddof=1) / np.sqrt(40))
    assert row["trials"] == 80


def test_cells_are_the_pooled_trials_of_one_human():
    one = study(np.random.default_rng(1))
    cells = [row for row in one.cells() if row["robot"] == "norm"]
    assert [row["human"] for row in cells] == ["norm", "selfish"]
    pooled = next(row for row in one.pooled() if row["robot"] == "norm")
    assert_allclose(np.mean([row["total_s"] for row in cells]), pooled["total_s"])


def test_differences_are_paired_by_scene_and_human_in_any_order_of_trials():
    one = study(np.random.default_rng(2))
    order = np.random.default_rng(3).permutation(len(one.values))
    shuffled = TaskPerformance(
        *(getattr(one, name)[order] for name in ("values", "robot", "human", "plan_sets", "scene"))
    )
    told = {(row["robot"], row["against"], row["metric"]): row for row in one.differences(resamples=2000)}
    again = {
        (row["robot"], row["against"], row["metric"]): row for row in shuffled.differences(resamples=2000)
    }
    assert told.keys() == again.keys()
    for key, row in told.items():
        assert_allclose(row["mean"], again[key]["mean"])
    row = told["bayes", "norm", "stops"]
    by_hand = one.values[one.robot == "bayes", 3] - one.values[one.robot == "norm", 3]
    assert_allclose(row["mean"], by_hand.mean())
    assert row["pairs"] == 80
    opposite = told["norm", "bayes", "stops"]
    assert_allclose([opposite["low"], opposite["high"]], [-row["high"], -row["low"]])


def test_the_interval_covers_the_true_difference_as_often_as_it_says():
    rng = np.random.default_rng(4)
    covered = 0
    for _ in range(200):
        one = study(rng, scenes=30, robots=("norm", "bayes"))
        row = one.differences(["norm"], resamples=400)[0]
        covered += row["low"] <= 1.0 <= row["high"]
    assert 0.88 <= covered / 200 <= 0.99


def test_trials_without_a_partner_are_left_out_of_differences():
    one = performance(np.arange(18.0).reshape(3, 6), ["norm", "bayes", "bayes"], scene=[0, 0, 1])
    rows = one.differences(["norm"])
    assert {row["pairs"] for row in rows} == {1}
    assert {row["mean"] for row in rows} == {6.0}
    # one scene says nothing of how scenes differ
    assert all(np.isnan([row["low"], row["high"]]).all() for row in rows)


def test_plan_sets_are_never_compared_with_one_another():
    one = performance(
        np.zeros((4, 6)),
        ["norm", "bayes", "norm", "bayes"],
        plan_sets=["shared", "shared", "independent", "independent"],
        scene=[0, 0, 0, 0],
    )
    assert {row["plan_sets"] for row in one.differences()} == {"shared", "independent"}
    assert {row["pairs"] for row in one.differences()} == {1}


def test_a_log_says_how_its_trials_went():
    log = example_planned_log()
    told = task_performance(log)
    assert told.values.shape == (log.sizes["trial"], len(METRICS))
    finish = log["finish_time"].values
    done = np.isfinite(finish).all(axis=1)
    assert_allclose(told.values[done, 0], finish[done].max(axis=1))
    assert told.values[:, 5].tolist() == (~done).astype(float).tolist()


def test_who_did_not_finish_counts_with_the_length_of_the_trial():
    log = example_planned_log().copy(deep=True)
    robot = log["agent"].values.tolist().index("robot")
    log["finish_time"].values[0, robot] = np.nan
    log["finish_time"].values[0, 1 - robot] = 0.2
    told = task_performance(log)
    length = log["time"].values[log["row_size"].values[0] - 1] - log["time"].values[0]
    assert_allclose(told.values[0, :3], [length, length, 0.2])
    assert told.values[0, 5] == 1.0


def test_a_log_of_something_else_is_refused():
    with pytest.raises(LogError, match="the log has no finish_time, stops"):
        task_performance(example_planned_log().drop_vars(["finish_time", "stops"]))
    with pytest.raises(LogError, match="no agent 'dog' in the log; there are"):
        task_performance(example_planned_log(), robot="dog")


def test_trials_that_repeat_cannot_be_paired():
    one = performance(np.zeros((3, 6)), ["norm", "bayes", "bayes"], scene=[0, 0, 0])
    with pytest.raises(LogError, match="'bayes' met the same human in the same scene more than once"):
        one.differences()
