"""Pictures of metrics: what is drawn is what was measured."""

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.plots import plot_learning_effects, plot_metric_by_condition
from ppinfer.studies.metrics import trial_metrics
from ppinfer.testing import example_team_log


@pytest.fixture(scope="module")
def metrics():
    return trial_metrics(example_team_log(participants=5, rounds=3))


def test_learning_effects_are_one_line_a_condition_with_the_means_by_round(metrics):
    ax, other = plot_learning_effects(metrics, ["score", "human_path_length"])
    rows = [row for row in metrics.learning() if row.metric == "score"]
    lines = ax.get_lines()
    assert len(lines) == len(rows) == 2
    for line, row in zip(lines, rows, strict=True):
        np.testing.assert_allclose(line.get_ydata(), [one.mean for one in row.rounds])
        np.testing.assert_allclose(np.round(line.get_xdata()), [0, 1, 2])
    bars = ax.collections[0].get_segments()
    first = rows[0].rounds[0]
    np.testing.assert_allclose(bars[0][:, 1], [first.mean - first.sem, first.mean + first.sem])
    assert ax.get_xlabel() == "round"
    assert other.get_ylabel() == "human path length [m]"


def test_a_line_for_everybody_needs_no_legend_and_conditions_have_one(metrics):
    (alone,) = plot_learning_effects(metrics, ["score"], by=None)
    assert not alone.figure.legends
    (ax,) = plot_learning_effects(metrics, ["score"])
    assert [text.get_text() for text in ax.figure.legends[0].get_texts()] == ["c0", "c1"]


def test_metrics_by_condition_join_each_participants_means(metrics):
    (ax,) = plot_metric_by_condition(metrics, ["score"])
    people, labels, means = metrics.participant_means("score")
    drawn = [line.get_ydata() for line in ax.get_lines()]
    np.testing.assert_allclose(drawn[: len(people)], means)
    over_people = [row.mean for row in metrics.by("condition") if row.metric == "score"]
    np.testing.assert_allclose(np.concatenate(drawn[len(people) :]), over_people)
    assert [text.get_text() for text in ax.get_xticklabels()] == list(labels)


def test_a_few_metrics_are_drawn_unless_others_are_asked_for(metrics):
    assert len(plot_metric_by_condition(metrics, resamples=50)) == 4
    names = list(metrics.names[:6])
    assert len(plot_metric_by_condition(metrics, names, resamples=50)) == 6
    with pytest.raises(LogError, match="there is no metric 'joy'"):
        plot_learning_effects(metrics, ["joy"])
    with pytest.raises(LogError, match="2 panels are drawn; 1 axes were given"):
        plot_learning_effects(metrics, names[:2], axes=plot_learning_effects(metrics, names[:1]))


def test_what_a_log_calls_things_is_drawn_as_text():
    log = example_team_log()
    log["condition"] = ("trial", np.array(["_hidden $x^$", "<b>" + "long " * 20] * 6, dtype=object))
    metrics = trial_metrics(log, names=["score"])
    for plot in (plot_learning_effects, plot_metric_by_condition):
        (ax,) = plot(metrics)
        ax.figure.canvas.draw()
    (ax,) = plot_learning_effects(metrics)
    shown = [text.get_text() for text in ax.figure.legends[0].get_texts()]
    assert "_hidden $x^$" in shown
    assert max(map(len, shown)) <= 32
