"""Metrics by condition, what changes over rounds, and whether conditions differ."""

import re

import numpy as np
import pytest

from ppinfer.report import write_report
from ppinfer.report.sections.condition_tests import _holm
from ppinfer.report.sections.metrics import Measured
from ppinfer.studies import open_log, score_posterior, write_log, write_posterior
from ppinfer.studies.metrics import TrialMetrics, trial_metrics
from ppinfer.studies.metrics.summaries import MetricFacts
from ppinfer.studies.statistics import analyse

from ..studies.posteriors import make_posterior
from .logs import reaches
from .pages import Page


def _report(tmp_path, log, **options):
    write_log(log, tmp_path / "log.nc")
    return write_report(tmp_path / "log.nc", tmp_path / "report", **options)


def _words(report):
    return Page(report.page.read_text()).words


def test_metrics_are_those_of_the_log(tmp_path):
    report = _report(tmp_path, reaches(goals=()))
    with open_log(tmp_path / "log.nc") as log:
        rows = trial_metrics(log).by("condition")
    told = report.to_json()["metrics"]
    assert told["by"] == "condition"
    assert [(row["metric"], row["group"], row["mean"], row["sem"]) for row in told["groups"]] == [
        (row.metric, row.group, row.mean, row.sem) for row in rows
    ]
    assert {"metrics.png", "learning.png"} <= {path.name for path in report.figures}
    assert "Over rounds: do people change with practice?" in _words(report)


def test_conditions_are_compared_as_an_analysis_of_variance_does_and_p_is_adjusted_over_metrics(tmp_path):
    report = _report(tmp_path, reaches(conditions=("a", "b", "c"), goals=(), participants=tuple("pqrst")))
    with open_log(tmp_path / "log.nc") as log:
        metrics = trial_metrics(log)
    told = report.to_json()["tests"]
    assert [row["dv"] for row in told["anova"]] + told["notes"][0].rstrip(".").split(": ")[1].split(
        ", "
    ) != []
    for row in told["anova"]:
        (effect,) = analyse([metrics.measures(row["dv"])]).anova
        assert row["F"] == pytest.approx(effect.F)
        assert row["p_gg"] == pytest.approx(effect.p_gg)
    p = [row["p_gg"] for row in told["anova"]]
    ranked = sorted(range(len(p)), key=p.__getitem__)
    expected, largest = {}, 0.0
    for rank, at in enumerate(ranked):
        largest = max(largest, min(1.0, (len(p) - rank) * p[at]))
        expected[at] = largest
    assert [row["p_over_metrics"] for row in told["anova"]] == pytest.approx(
        [expected[at] for at in range(len(p))]
    )
    assert len(told["posthoc"]) == 3 * len(told["anova"])


def test_undefined_p_values_count_for_nothing_in_holms_method():
    np.testing.assert_allclose(_holm(np.array([0.01, np.nan, 0.04, 0.03])), [0.03, np.nan, 0.06, 0.06])


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"participants": ("p1",)}, "There is one participant only."),
        ({"conditions": ("a",)}, "There is one condition only."),
    ],
)
def test_where_nothing_can_be_compared_the_page_says_why(tmp_path, options, why):
    report = _report(tmp_path, reaches(goals=(), **options))
    assert report.tests.why_none == why
    assert f"Nothing is tested. {why}" in _words(report)


def test_without_a_standard_error_a_mean_keeps_its_figures(tmp_path):
    report = _report(tmp_path, reaches(goals=(), participants=("p1",), conditions=("a",)))
    (row,) = (row for row in report.to_json()["metrics"]["groups"] if row["metric"] == "human_path_length")
    assert np.isnan(row["sem"])
    shown = re.search(r"human_path_length \[m\] (\S+) ", _words(report)).group(1)
    assert float(shown) == pytest.approx(row["mean"], rel=1e-3)
    assert "± –" not in _words(report)


def test_participants_who_met_one_condition_cannot_be_compared_within(tmp_path):
    log = reaches(goals=(), conditions=("a", "b"), rounds=1)
    log = log.assign(participant=("trial", np.array([f"q{at}" for at in range(6)], dtype=object)))
    report = _report(tmp_path, log)
    assert report.tests.why_none.startswith("6 of 6 participants met one condition only")


def test_a_participant_who_lacks_a_condition_is_left_out_and_named(tmp_path):
    log = reaches(goals=(), conditions=("a", "b", "c"), rounds=1, participants=("p1", "p2", "p3", "p4"))
    conditions = log["condition"].values.copy()
    conditions[2] = "a"
    report = _report(tmp_path, log.assign(condition=("trial", conditions)))
    assert all(row["subjects"] == 3 for row in report.to_json()["tests"]["anova"])
    assert "1 of 4 subjects dropped for missing cells: 'p1'" in _words(report)


def test_the_metrics_of_a_posterior_are_its_scores_in_every_trial(tmp_path):
    posterior = make_posterior(row_sizes=(30,) * 8, participants=("p1", "p1", "p2", "p2") * 2)
    posterior["condition"] = ("trial", np.array(["a", "b"] * 4, dtype=object))
    write_posterior(posterior, tmp_path / "post.nc")
    report = write_report(tmp_path / "post.nc", tmp_path / "report")
    told = report.to_json()
    segments = score_posterior(posterior, at=[0.5]).segments
    trial = posterior["segment_trial"].values[segments["segment"].values]
    for name, variable in (("accuracy", "correct"), ("log_posterior", "log_posterior")):
        values = segments[variable].values[0].astype(float)
        of_trial = np.array([values[trial == at].mean() for at in range(8)])
        expected = np.mean([of_trial[[0, 4]].mean(), of_trial[[2, 6]].mean()])
        (row,) = (row for row in told["metrics"]["groups"] if row["metric"] == name and row["group"] == "a")
        assert row["mean"] == pytest.approx(expected)
    assert [row["dv"] for row in told["tests"]["anova"]] == ["accuracy", "log_posterior"]


def test_controllers_are_compared_where_there_is_one_condition():
    columns = {
        "trial_id": np.array(["0", "1"]),
        "participant": np.array(["p", "p"]),
        "condition": np.array(["c", "c"]),
        "robot_controller": np.array(["naive", "new"]),
    }
    metrics = TrialMetrics(np.array([[1.0], [2.0]]), (MetricFacts("m", "s", "is"),), columns)
    assert Measured.of(metrics).by == "robot_controller"
    alone = TrialMetrics(
        np.array([[1.0], [2.0]]), metrics.metrics, {**columns, "robot_controller": np.array(["x", "x"])}
    )
    assert Measured.of(alone).by == "condition"
