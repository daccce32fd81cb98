"""What holds of every metric, whatever it measures."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer.errors import LogError
from ppinfer.studies import select_trials
from ppinfer.studies.metrics import METRICS, Metric, trial_metrics
from ppinfer.testing import check_metric, example_team_log

SHARES = [name for name in METRICS if name.endswith("_share")]


@pytest.mark.parametrize("name", METRICS)
def test_every_registered_metric_passes_the_conformance_test(name):
    check_metric(METRICS[name])


@settings(max_examples=20)
@given(seed=st.integers(0, 10_000), scale=st.sampled_from([0.25, 4.0, 1024.0]))
def test_scaling_positions_scales_paths_and_speeds_and_no_share(seed, scale):
    log = example_team_log(seed=seed, participants=2)
    far = log.assign(position=log["position"] * scale)
    here, there = (trial_metrics(one, idle="motion") for one in (log, far))
    for name in here.names:
        expected = here.values_of(name)
        if name.endswith(("path_length", "mean_speed")):
            expected = expected * scale
        np.testing.assert_allclose(there.values_of(name), expected, rtol=1e-12, err_msg=name)


@settings(max_examples=20)
@given(seed=st.integers(0, 10_000), flags=st.booleans())
def test_idle_active_and_unseen_are_all_there_is_and_nothing_is_more_concurrent_than_active(seed, flags):
    found = trial_metrics(example_team_log(seed=seed), names=SHARES, idle="flags" if flags else "motion")
    of = {name: found.values_of(name) for name in SHARES}
    for name, values in of.items():
        known = values[~np.isnan(values)]
        assert ((known >= 0) & (known <= 1 + 1e-12)).all(), name
    for role in ("robot", "human"):
        whole = of[f"{role}_idle_share"] + of[f"{role}_active_share"] + of[f"{role}_unseen_share"]
        np.testing.assert_allclose(whole[~np.isnan(whole)], 1.0, rtol=1e-12)
    least = np.fmin(of["robot_active_share"], of["human_active_share"])
    assert (np.isnan(least) | (of["concurrent_share"] <= least + 1e-12)).all()


def test_two_studies_joined_have_the_metrics_of_each():
    log = example_team_log(participants=3, seed=8)
    parts = [select_trials(log, range(5)), select_trials(log, range(5, log.sizes["trial"]))]
    options = {
        "idle": "motion",
        "idle_speed": 0.5,
        "names": ["score", "concurrent_share", "robot_path_length"],
    }
    joined = np.concatenate([trial_metrics(part, **options).values for part in parts])
    np.testing.assert_array_equal(joined, trial_metrics(log, **options).values)


@pytest.mark.parametrize(
    ("measure", "told"),
    [
        (lambda trials: np.arange(trials.row_size.size, dtype=float), "in another order of trials"),
        (lambda trials: trials.duration + trials.row_size.size, "a trial by itself"),
        (lambda trials: trials.began, "when the clock starts"),
        (
            lambda trials: trials.duration * len(trials.idle.speed),
            "does not say that it reads flags of waiting",
        ),
        (lambda trials: np.divide(1.0, np.zeros(trials.row_size.size)), "infinite"),
    ],
)
@pytest.mark.filterwarnings("ignore:divide by zero:RuntimeWarning")
def test_the_conformance_test_finds_what_breaks_the_laws(measure, told):
    with pytest.raises(AssertionError, match=told):
        check_metric(Metric("broken", "", "breaks a law", measure))


def test_the_conformance_test_finds_a_need_that_is_none():
    with pytest.raises(AssertionError, match="says that it needs stops, and gives values without"):
        check_metric(
            _Forgiving("broken", "", "needs nothing", lambda trials: trials.duration, needs=("stops",))
        )


class _Forgiving(Metric):
    def missing(self, log, roles):
        return ""


def test_a_metric_of_another_shape_is_refused():
    wrong = Metric("wrong", "", "a value a sample", lambda trials: trials.elapsed)
    with pytest.raises(LogError, match=r"gives values of shape \(\d+,\); expected one a trial, \(12,\)"):
        trial_metrics(example_team_log(), names=[wrong])
