"""Means by group, paired differences, learning, and the way to analyses of variance."""

import itertools
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from ppinfer.errors import LogError
from ppinfer.studies import select_trials
from ppinfer.studies.metrics import TrialMetrics, trial_metrics
from ppinfer.studies.metrics.over_participants import over_participants
from ppinfer.studies.metrics.summaries import MetricFacts
from ppinfer.testing import example_team_log


def table(rows, *, rounds=True):
    """Return metrics of rows (participant, condition, round, value)."""
    people, conditions, when, values = zip(*rows, strict=True)
    columns = {
        "trial_id": np.array([f"t{index}" for index in range(len(rows))], dtype=object),
        "participant": np.array(people, dtype=object),
        "condition": np.array(conditions, dtype=object),
    }
    if rounds:
        columns["round"] = np.array(when, np.int64)
    return TrialMetrics(np.array(values, float)[:, None], (MetricFacts("m", "s", "made up"),), columns)


ROWS = [
    ("ann", "near", 0, 1.0),
    ("ann", "near", 1, 3.0),
    ("ann", "far", 0, 10.0),
    ("bob", "near", 0, 4.0),
    ("bob", "far", 0, 7.0),
    ("bob", "far", 1, np.nan),
    ("cem", "near", 0, 6.0),
]


def test_a_participant_counts_once_however_many_trials_it_has():
    near = next(row for row in table(ROWS).by("condition") if row.group == "near")
    assert near.mean == pytest.approx((2 + 4 + 6) / 3)
    assert near.sem == pytest.approx(np.std([2, 4, 6], ddof=1) / np.sqrt(3))
    assert (near.participants, near.trials) == (3, 4)
    assert 2 <= near.low <= near.mean <= near.high <= 6


def test_trials_without_a_value_are_no_part_of_anything():
    far = next(row for row in table(ROWS).by("condition") if row.group == "far")
    assert (far.mean, far.participants, far.trials) == (8.5, 2, 2)


def test_differences_are_paired_over_participants_who_were_in_both():
    (row,) = table(ROWS).differences("condition")
    assert (row.a, row.b, row.participants) == ("far", "near", 2)
    differences = [10 - 2, 7 - 4]
    assert row.mean == pytest.approx(np.mean(differences))
    assert row.sem == pytest.approx(np.std(differences, ddof=1) / np.sqrt(2))
    assert (row.low, row.high) == (3.0, 8.0)


def test_groups_without_a_common_participant_are_not_compared():
    assert table(ROWS).differences("participant") == []
    assert "no participant is in two groups" in table(ROWS).to_json("participant")["warnings"][-1]


def test_one_participant_has_means_and_no_errors():
    alone = table(ROWS[:3])
    for row in (*alone.by("condition"), *alone.differences("condition")):
        assert np.isfinite(row.mean)
        assert np.isnan([row.sem, row.low, row.high]).all()
    assert np.isnan(alone.learning()[1].p)


@settings(max_examples=20)
@given(st.lists(st.lists(st.integers(-5, 5), min_size=2, max_size=4), min_size=2, max_size=4))
def test_the_bootstrap_agrees_with_all_resamples_there_are(people):
    means = np.array([np.mean(values) for values in people])
    every = [np.mean(draw) for draw in itertools.product(means, repeat=len(means))]
    found = over_participants(means[:, None], resamples=4000, seed=1)
    low, high = np.quantile(every, [0.025, 0.975], method="inverted_cdf")
    # quantiles of few distinct values jump: what was drawn lies within what can be
    assert min(every) <= found.low[0] <= found.mean[0] + 1e-12
    assert found.mean[0] - 1e-12 <= found.high[0] <= max(every)
    below, above = (
        np.mean(np.array(every) < found.low[0] - 1e-9),
        np.mean(np.array(every) > found.high[0] + 1e-9),
    )
    assert below <= 0.05 and above <= 0.05, (low, high)  # noqa: PT018


def test_the_bootstrap_is_repeatable_and_has_its_seed():
    metrics = trial_metrics(example_team_log(participants=8), names=["robot_path_length"])
    one, again, other = (metrics.by("condition", seed=seed) for seed in (1, 1, 2))
    assert one == again
    assert one[0].low != other[0].low
    assert one[0].mean == other[0].mean


@settings(max_examples=10)
@given(seed=st.integers(0, 1000))
def test_the_order_of_trials_changes_no_summary_over_rounds(seed):
    log = example_team_log(seed=3, participants=4)
    order = np.random.default_rng(seed).permutation(log.sizes["trial"])
    names = ["score", "human_path_length", "functional_delay"]
    here, there = (trial_metrics(one, names=names) for one in (log, select_trials(log, order)))
    for told in ("by", "differences", "learning"):
        for one, other in zip(
            getattr(here, told)("condition"), getattr(there, told)("condition"), strict=True
        ):
            np.testing.assert_allclose(_numbers(one), _numbers(other), rtol=1e-9)


def _numbers(row):
    return [value for value in vars(row).values() if isinstance(value, float | int)]


def test_a_slope_that_everybody_has_is_found_and_its_test_is_students():
    rng = np.random.default_rng(0)
    own = {f"p{person}": 2.0 + 0.3 * rng.normal() for person in range(7)}
    rows = [
        (person, condition, when, 5.0 + (slope if condition == "new" else 0.0) * when)
        for person, slope in own.items()
        for condition in ("new", "old")
        for when in range(4)
    ]
    new, old = table(rows).learning("condition")
    expected = stats.ttest_1samp(list(own.values()), 0.0)
    assert new.slope == pytest.approx(np.mean(list(own.values())))
    assert (new.t, new.p, new.df) == (pytest.approx(expected.statistic), pytest.approx(expected.pvalue), 6)
    interval = expected.confidence_interval(0.95)
    assert (new.low, new.high) == (pytest.approx(interval.low), pytest.approx(interval.high))
    assert [row.mean for row in new.rounds] == pytest.approx([5 + new.slope * when for when in range(4)])
    assert (old.slope, old.participants) == (pytest.approx(0.0), 7)


def test_slopes_that_differ_by_rounding_only_do_not_differ():
    base = np.random.default_rng(0).normal(size=6)
    rows = [
        (f"p{person}", condition, when, start + slope * when)
        for person, start in enumerate(base)
        for condition, slope in (("new", 0.1), ("old", 0.0))
        for when in range(3 + person % 4)
    ]
    new, old = table(rows).learning("condition")
    assert (new.slope, new.sem, new.t, new.p) == (pytest.approx(0.1), 0.0, np.inf, 0.0)
    assert (new.low, new.high) == (new.slope, new.slope)
    assert (old.slope, old.sem) == (0.0, 0.0)
    assert np.isnan([old.t, old.p]).all()


@settings(max_examples=30)
@given(st.lists(st.tuples(st.integers(0, 5), st.floats(-100, 100)), min_size=2, max_size=8))
def test_a_participants_slope_is_that_of_least_squares(points):
    when, values = zip(*points, strict=True)
    (row,) = table([("ann", "one", one, value) for one, value in points]).learning(over="round")
    if len(set(when)) < 2:
        assert np.isnan(row.slope)
    else:
        assert row.slope == pytest.approx(np.polyfit(when, values, 1)[0], abs=1e-7)


def test_rounds_are_the_order_of_trials_where_there_are_none_or_one_in_each_condition():
    rows = [(person, condition, block, float(trial)) for person in ("ann", "bob")
            for block, condition in enumerate(("near", "far")) for trial in range(3)]  # fmt: skip
    for metrics in (table(rows), table(rows, rounds=False)):
        assert metrics.rounds_are("condition") == "order"
        far, near = metrics.learning("condition")
        assert [row.round for row in far.rounds] == [0, 1, 2]
        assert (far.slope, near.slope) == (pytest.approx(1.0), pytest.approx(1.0))
    assert table(rows).rounds_are(None) == "round"


def test_rounds_that_are_unknown_are_left_out_and_text_is_no_round():
    metrics = table([*ROWS, ("ann", "near", -1, 99.0)])
    near = next(row for row in metrics.learning() if row.group == "near")
    assert [row.round for row in near.rounds] == [0, 1]
    with pytest.raises(LogError, match="'condition' is text"):
        metrics.learning(over="condition")


@pytest.mark.parametrize("ask", ["by", "differences", "learning"])
def test_a_column_that_is_not_there_is_told_with_those_that_are(ask):
    with pytest.raises(
        LogError, match=r"cannot be grouped by 'robot'.*trial_id, participant, condition, round"
    ):
        getattr(table(ROWS), ask)("robot")


def test_a_metric_that_is_not_there_is_told():
    with pytest.raises(LogError, match="there is no metric 'speed'; there are m"):
        table(ROWS).values_of("speed")
    lacking = trial_metrics(example_team_log().drop_vars("stops"))
    with pytest.raises(LogError, match="cannot give the metric 'stops': the log has no stops"):
        lacking.values_of("stops")


def test_measures_are_participants_by_conditions_for_analyses_of_variance():
    measures = table(ROWS).measures("m")
    assert (measures.dv, measures.subjects, measures.factors) == ("m", ("ann", "bob", "cem"), ("condition",))
    assert measures.levels == (("far", "near"),)
    np.testing.assert_array_equal(measures.values, [[10.0, 2.0], [7.0, 4.0], [np.nan, 6.0]])


def test_measures_are_in_the_order_of_names_whoever_lacks_a_condition():
    rows = [("ann", "near", 0, 1.0), ("bob", "near", 0, 2.0), ("bob", "far", 0, 3.0), ("bob", "far", 1, 5.0)]
    measures = table(rows[::-1]).measures("m")
    assert (measures.subjects, measures.levels) == (("ann", "bob"), (("far", "near"),))
    np.testing.assert_array_equal(measures.values, [[np.nan, 1.0], [4.0, 2.0]])
    assert measures.notes == ("'m': mean of several trials taken in 1 cells (up to 2 trials)",)


def test_measures_may_have_several_factors():
    measures = trial_metrics(example_team_log(), names=["score"]).measures("score", ["condition", "round"])
    assert measures.values.shape == (3, 2, 2)


def test_json_and_html_hold_the_same_and_what_comes_from_a_log_is_text():
    metrics = table([("<script>", "=cmd()", 0, 1.0), ("bob", "=cmd()", 1, 3.0)])
    found = metrics.to_json("condition", learning_by="condition")
    assert found["groups"][0]["mean"] == 2.0
    assert found["trials"][0] == {
        "trial_id": "t0", "participant": "<script>", "condition": "=cmd()", "round": 0, "values": {"m": 1.0},
    }  # fmt: skip
    assert json.dumps(found["learning"][0]["rounds"])
    assert "<script>" not in metrics._repr_html_()
    assert "2 trials of 2 participants" in metrics._repr_html_()


def test_differences_of_very_many_groups_are_left_out_of_the_json_and_said_to_be():
    metrics = table([("ann", f"c{index:02}", 0, 1.0) for index in range(20)])
    found = metrics.to_json("condition", resamples=10)
    assert found["differences"] == []
    assert "more than 12 values" in found["warnings"][-1]
    many = table([("ann", f"c{index}", 0, 1.0) for index in range(1001)])
    with pytest.raises(LogError, match="1,001 values"):
        many.by("condition")
