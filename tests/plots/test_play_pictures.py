from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex

from ppinfer.errors import LogError
from ppinfer.plots import (
    mean_beliefs,
    plot_against_personalities,
    plot_belief_by_human,
    plot_hand_distance,
    plot_paired_differences,
    plot_personality,
    plot_task_performance,
    read_beliefs,
)
from ppinfer.plots.personality import read_personality_trial, theta_colour
from ppinfer.plots.replan_beliefs import SHARES
from ppinfer.studies.task_performance import task_performance

from .plays import HUMANS, ROBOTS, make_plays

METRICS = ("total_s", "robot_s", "human_s", "stops")


@pytest.fixture(scope="module")
def log():
    return make_plays(plan_sets=("shared", "independent"), unfinished=(4,))


@pytest.fixture(scope="module")
def performance(log):
    return task_performance(log)


def dots_of(ax):
    """Return the dots of a panel by the label of their series."""
    return {line.get_label(): line for line in ax.lines if not line.get_label().startswith("_")}


def names_of(ax):
    """Return the names of the rows, from top to bottom."""
    assert ax.yaxis_inverted()
    return [label.get_text() for label in ax.get_yticklabels()]


def whiskers_of(ax, series):
    """Return the whiskers of a series as rows of (from, to)."""
    return np.array([segment[:, 0] for segment in ax.collections[series].get_segments()])


def test_every_picture_of_plays_labels_its_axes_and_draws(log, performance):
    pictures = [
        *plot_task_performance(performance),
        *plot_against_personalities(performance, "bayes"),
        *plot_paired_differences(performance.differences(["norm"], resamples=50)),
        *plot_belief_by_human(mean_beliefs(read_beliefs(log))),
        plot_personality(log, "scene-0/shared/bayes/selfish"),
        plot_hand_distance(log, 0),
    ]
    for ax in pictures:
        assert ax.get_xlabel()
        assert ax.figure.axes[0].get_ylabel()
        assert ax.figure.canvas.manager is None  # no global state holds on to it
    for figure in {ax.figure for ax in pictures}:
        figure.canvas.draw()
    assert [ax.get_xlabel() for ax in pictures[:4]] == [
        "total time [s]",
        "robot's time [s]",
        "human's time [s]",
        "safety stops a trial",
    ]


@pytest.mark.parametrize(("whiskers", "reach"), [("sem", 1.0), ("95%", 1.959964)])
def test_the_dots_of_robots_are_the_numbers_of_the_table(performance, whiskers, reach):
    axes = plot_task_performance(performance, whiskers=whiskers)
    assert names_of(axes[0]) == list(ROBOTS)
    for ax, metric in zip(axes, METRICS, strict=True):
        for series, plan_sets in enumerate(("shared", "independent")):
            rows = [row for row in performance.pooled() if row["plan_sets"] == plan_sets]
            mean = np.array([row[metric] for row in rows])
            error = reach * np.array([row[f"{metric}_sem"] for row in rows])
            np.testing.assert_array_equal(dots_of(ax)[f"{plan_sets} plan sets"].get_xdata(), mean)
            np.testing.assert_allclose(whiskers_of(ax, series), np.column_stack([mean - error, mean + error]))


def test_plan_sets_stand_side_by_side_in_the_row_of_their_robot(performance):
    ax = plot_task_performance(performance)[0]
    shared, independent = (dots_of(ax)[f"{name} plan sets"] for name in ("shared", "independent"))
    for dots in (shared, independent):
        np.testing.assert_array_equal(np.round(dots.get_ydata()), np.arange(len(ROBOTS)))
    assert (shared.get_ydata() < independent.get_ydata()).all()
    assert shared.get_color() != independent.get_color()
    assert shared.get_marker() != independent.get_marker()


def test_panels_of_seconds_have_one_scale_and_counts_begin_at_zero(performance):
    *times, stops = plot_task_performance(performance)
    assert len({ax.get_xlim() for ax in times}) == 1
    low, high = stops.get_xlim()
    assert -0.05 * high < low < 0


def test_the_dots_of_one_robot_against_each_human_are_its_cells(performance):
    axes = plot_against_personalities(performance, "bayes")
    assert names_of(axes[0]) == list(HUMANS)
    for ax, metric in zip(axes, METRICS, strict=True):
        for plan_sets in ("shared", "independent"):
            cells = [
                row[metric]
                for row in performance.cells()
                if (row["robot"], row["plan_sets"]) == ("bayes", plan_sets)
            ]
            np.testing.assert_array_equal(dots_of(ax)[f"{plan_sets} plan sets"].get_xdata(), cells)


def test_differences_are_drawn_with_their_intervals_beside_a_line_at_zero(performance):
    differences = performance.differences(["norm"], resamples=50)
    axes = plot_paired_differences(differences, metrics=("total_s", "stops"))
    assert names_of(axes[0]) == ["defensive", "bayes"]
    for ax, metric in zip(axes, ("total_s", "stops"), strict=True):
        rows = [row for row in differences if row["metric"] == metric and row["plan_sets"] == "shared"]
        np.testing.assert_array_equal(
            dots_of(ax)["shared plan sets"].get_xdata(), [row["mean"] for row in rows]
        )
        np.testing.assert_array_equal(whiskers_of(ax, 0), [[row["low"], row["high"]] for row in rows])
        assert [line.get_xdata() for line in ax.lines if line.get_label().startswith("_")] == [[0.0, 0.0]]


def test_with_one_scene_there_are_dots_without_whiskers():
    performance = task_performance(make_plays(scenes=1))
    for axes in (
        plot_task_performance(performance),
        plot_paired_differences(performance.differences(["norm"], resamples=20)),
    ):
        for ax in axes:
            assert len(whiskers_of(ax, 0)) == 0
            assert np.isfinite(dots_of(ax)["shared plan sets"].get_xdata()).all()
        axes[0].figure.canvas.draw()


def test_one_robot_with_one_human_is_drawn():
    performance = task_performance(make_plays(robots=("bayes",), humans=("norm",)))
    axes = plot_task_performance(performance)
    assert names_of(axes[0]) == ["bayes"]
    axes[0].figure.canvas.draw()
    assert names_of(plot_against_personalities(performance, "bayes")[0]) == ["norm"]


def test_a_robot_that_was_not_played_with_some_plan_sets_has_no_dot_there():
    one = task_performance(make_plays(plan_sets=("shared", "independent")))
    kept = (one.robot != "norm") | (one.plan_sets == "shared")
    some = replace(
        one,
        **{name: getattr(one, name)[kept] for name in ("values", "robot", "human", "plan_sets", "scene")},
    )
    dots = dots_of(plot_task_performance(some)[0])
    assert len(dots["shared plan sets"].get_xdata()) == 3
    assert len(dots["independent plan sets"].get_xdata()) == 2


def test_pictures_of_unknown_metrics_robots_and_baselines_are_refused(performance):
    with pytest.raises(LogError, match="unknown metric 'speed'; name some of total_s"):
        plot_task_performance(performance, metrics=("speed",))
    with pytest.raises(LogError, match="there is no robot 'oracle'; there are defensive, norm, bayes"):
        plot_against_personalities(performance, "oracle")
    with pytest.raises(
        LogError, match="no difference in total_s from 'oracle'; there are differences from norm"
    ):
        plot_paired_differences(performance.differences(["norm"], resamples=5), "oracle")
    with pytest.raises(LogError, match="4 panels are drawn; 1 axes were given"):
        plot_task_performance(performance, axes=plot_task_performance(performance)[:1])


def test_beliefs_are_those_of_the_robot_at_replans_at_which_it_held_one(log):
    beliefs = read_beliefs(log)
    assert {beliefs.robot[trial] for trial in beliefs.trial} == {"bayes"}
    held = ~np.isnan(log["live_log_posterior"].values[:, 0])
    np.testing.assert_array_equal(beliefs.probability, np.exp(log["live_log_posterior"].values[held]))
    np.testing.assert_array_equal(beliefs.time, log["replan_time"].values[held])


def test_a_mean_belief_is_the_mean_over_trials_of_the_mean_over_replans(log):
    (found,) = [
        one for one in mean_beliefs(read_beliefs(log)) if (one.human, one.plan_sets) == ("selfish", "shared")
    ]
    starts = np.concatenate([[0], np.cumsum(log["replan_row_size"].values)])
    expected = []
    for trial in np.flatnonzero(
        [name.endswith("shared/bayes/selfish") for name in log["trial_id"].values.tolist()]
    ):
        logs = log["live_log_posterior"].values[starts[trial] : starts[trial + 1], 0]
        expected.append(np.exp(logs[~np.isnan(logs)]))
    assert found.trials == 2
    assert found.mean == pytest.approx(np.mean([one.mean() for one in expected]))
    # each scene has one of these trials
    assert found.sem == pytest.approx(np.std([one.mean() for one in expected], ddof=1) / np.sqrt(2))
    # replans are equally far apart: the belief at a share is that of the last replan until then
    at = np.minimum((SHARES * 4 + 1e-6).astype(int), 4)
    np.testing.assert_allclose(found.curve, np.mean([one[at] for one in expected], axis=0))


def test_mean_beliefs_do_not_depend_on_how_many_trials_lie_in_front(log):
    beliefs = read_beliefs(log)
    alone = beliefs.among(beliefs.human == "norm")
    for one, other in zip(
        mean_beliefs(alone), [each for each in mean_beliefs(beliefs) if each.human == "norm"], strict=True
    ):
        np.testing.assert_array_equal(one.curve, other.curve)


def test_the_lines_of_beliefs_are_the_mean_beliefs(log):
    beliefs = mean_beliefs(read_beliefs(log))
    axes = plot_belief_by_human(beliefs)
    assert [ax.get_title(loc="left") for ax in axes] == [
        "bayes (shared plan sets)",
        "bayes (independent plan sets)",
    ]
    for one in beliefs:
        ax = axes[("shared", "independent").index(one.plan_sets)]
        (line,) = [each for each in ax.lines if each.get_label() == f"{one.human}: {one.mean:.2f}"]
        np.testing.assert_array_equal(line.get_ydata(), one.curve)


def test_a_log_without_beliefs_says_how_to_infer_them():
    log = make_plays(robots=("norm",), scenes=1)
    assert len(read_beliefs(log).trial) == 0
    assert mean_beliefs(read_beliefs(log)) == []
    with pytest.raises(LogError, match="there is no belief to draw"):
        plot_belief_by_human([])
    with pytest.raises(LogError, match="ppinfer infer LOG"):
        read_beliefs(log.drop_vars(["live_log_posterior", "theta"]))
    with pytest.raises(LogError, match="theta has no label 'fair'; it has human, robot"):
        mean_beliefs(read_beliefs(log), "fair")


def test_the_bands_of_a_trial_are_its_posterior_from_replan_to_replan(log):
    trial = "scene-0/shared/bayes/selfish"
    data = read_personality_trial(log, trial)
    ax = plot_personality(log, trial)
    (line,) = [each for each in ax.lines if each.get_drawstyle() == "steps-post"]
    np.testing.assert_array_equal(line.get_xdata()[:-1], data.replan_time)
    np.testing.assert_allclose(line.get_ydata()[:-1], data.probability[:, data.theta.index("human")])
    itself = ax.collections[0]
    assert itself.get_label() == "human favours itself"
    assert to_hex(itself.get_facecolor()[0]).upper() == theta_colour("human", 0)
    assert ax.get_title(loc="left") == f"trial {trial}: robot bayes, human selfish"


def test_safety_stops_and_the_ends_of_tasks_are_marked_when_they_were(log):
    index = int(
        np.flatnonzero((log["stops"].values > 0) & np.isfinite(log["finish_time"].values).all(axis=1))[0]
    )
    ax = plot_personality(log, index)
    (stops,) = [line for line in ax.lines if line.get_label().startswith("safety stop")]
    assert len(stops.get_xdata()) == log["stops"].values[index]
    ends = {line.get_xdata()[0] for line in ax.lines if line.get_linestyle() == "--"}
    assert ends == set(log["finish_time"].values[index].tolist())
    assert {text.get_text() for text in ax.texts} == {"human done", "robot done"}


def test_whoever_did_not_finish_has_no_end(log):
    ax = plot_personality(log, 4)
    assert [text.get_text() for text in ax.texts] == ["human done"]


def test_a_trial_without_belief_is_drawn_white(log):
    ax = plot_personality(log, "scene-0/shared/norm/selfish")
    ax.figure.canvas.draw()
    (line,) = [each for each in ax.lines if each.get_drawstyle() == "steps-post"]
    assert np.isnan(np.asarray(line.get_ydata(), float)).all()


def test_the_distance_of_hands_is_that_of_the_log(log):
    ax = plot_hand_distance(log, 1)
    size = int(log["row_size"].values[0])
    hands = log["end_effector"].values[size : 2 * size]
    np.testing.assert_allclose(ax.lines[0].get_ydata(), np.hypot(*(hands[:, 0] - hands[:, 1]).T))
    with pytest.raises(LogError, match="does not say where hands are"):
        plot_hand_distance(log.drop_vars("end_effector"), 1)
    with pytest.raises(LogError, match="there is no agent 'person' in the log; there are human, robot"):
        plot_hand_distance(log, 1, human="person")


def test_unknown_trials_of_a_log_are_refused_by_name(log):
    with pytest.raises(LogError, match="unknown trial 't9'; the log has 36: 'scene-0/shared/defensive"):
        plot_personality(log, "t9")


@pytest.mark.filterwarnings("ignore:Glyph")
@pytest.mark.parametrize("name", ["$x^{$", "<script>", "my_pack.polite:VeryPolite$$aaaaaaaaaaaa", "名前"])
def test_names_of_policies_are_text_and_never_mathematics(name):
    log = make_plays(robots=(name, "norm"), humans=(name,), scenes=2, believers=(name,))
    performance = task_performance(log)
    for picture in (
        plot_task_performance(performance),
        plot_against_personalities(performance, name),
        plot_paired_differences(performance.differences([name], resamples=5), name),
        plot_belief_by_human(mean_beliefs(read_beliefs(log))),
        (plot_personality(log, 0),),
    ):
        picture[0].figure.canvas.draw()
