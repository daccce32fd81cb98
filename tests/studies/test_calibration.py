import math

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.studies.calibration import calibrate_posterior
from ppinfer.studies.posterior import open_posterior, write_posterior
from ppinfer.studies.scores import score_posterior

from .posteriors import make_posterior


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("bins", [1, 4, 10])
def test_the_calibration_error_equals_a_plain_loop_over_samples(seed, bins):
    posterior = make_posterior(seed=seed)
    calibration = calibrate_posterior(posterior, bins=bins, resamples=10)
    top, every = _literal(posterior)
    for reliability, cells in ((calibration.top_label, top), (calibration.one_vs_rest, every)):
        error, table = _literal_bins(cells, bins)
        assert reliability.expected_calibration_error == pytest.approx(error, abs=1e-12)
        for b, (weight, predicted, observed) in enumerate(table):
            assert reliability.weight[b] == pytest.approx(weight, abs=1e-12)
            if weight:
                assert reliability.predicted[b] == pytest.approx(predicted, abs=1e-12)
                assert reliability.observed[b] == pytest.approx(observed, abs=1e-12)


def test_a_posterior_that_tells_the_truth_has_a_small_error():
    rng = np.random.default_rng(1)
    posterior = make_posterior(
        row_sizes=(20,) * 2000, participants=("p",) * 1000 + ("q",) * 1000, segments_per_trial=1
    )
    probability = rng.dirichlet(np.ones(3), size=2000)
    posterior["log_posterior"].values[:] = np.repeat(np.log(probability), 20, axis=0)
    true = (rng.random((2000, 1)) > probability.cumsum(axis=1)).sum(axis=1)
    posterior["true_goal"].values[:] = posterior["goal"].values[true]
    calibration = calibrate_posterior(posterior, at=[0.5], resamples=10)
    assert calibration.expected_calibration_error < 0.04
    assert calibration.one_vs_rest.expected_calibration_error < 0.03
    assert calibration.by_share[0.5].expected_calibration_error < 0.04


def test_a_posterior_that_overstates_has_the_error_it_overstates_by():
    posterior = make_posterior(
        goals=("a", "b"), row_sizes=(10,) * 4, participants=("p",) * 4, segments_per_trial=1
    )
    posterior["log_posterior"].values[:] = np.log([0.95, 0.05])
    posterior["true_goal"].values[:] = ["a", "a", "b", "a"]
    assert calibrate_posterior(posterior).expected_calibration_error == pytest.approx(0.2)


def test_long_segments_weigh_no_more_than_short_ones():
    posterior = make_posterior(
        goals=("a", "b"), row_sizes=(1000, 10), participants=("p", "q"), segments_per_trial=1
    )
    posterior["log_posterior"].values[:] = np.log([0.75, 0.25])
    posterior["true_goal"].values[:] = ["a", "b"]
    assert calibrate_posterior(posterior).expected_calibration_error == pytest.approx(0.25)


def test_certainty_and_its_opposite_fall_into_the_outer_bins():
    posterior = make_posterior(goals=("a", "b"))
    posterior["log_posterior"].values[:] = [0.0, -np.inf]
    posterior["true_goal"].values[:] = "b"
    calibration = calibrate_posterior(posterior, bins=5, resamples=10)
    assert calibration.expected_calibration_error == 1
    assert calibration.top_label.weight.tolist() == [0, 0, 0, 0, 1]
    assert calibration.one_vs_rest.weight.tolist() == [0.5, 0, 0, 0, 0.5]


def test_absent_goals_are_no_predictions():
    posterior = make_posterior(goals=("a", "b"))
    posterior["log_posterior"].values[:] = [0.0, -np.inf]
    posterior["true_goal"].values[:] = "a"
    assert calibrate_posterior(posterior, bins=5).one_vs_rest.weight.tolist() == [0, 0, 0, 0, 1]


def test_reading_in_blocks_changes_nothing(tmp_path, monkeypatch):
    posterior = make_posterior()
    write_posterior(posterior, tmp_path / "p.nc")
    whole = calibrate_posterior(posterior)
    monkeypatch.setattr(
        "ppinfer.studies.segment_selection.segment_blocks.__kwdefaults__", {"max_samples": 16}
    )
    with open_posterior(tmp_path / "p.nc") as lazy:
        blocks = calibrate_posterior(lazy)
    assert blocks.expected_calibration_error == pytest.approx(whole.expected_calibration_error, abs=1e-14)
    np.testing.assert_allclose(blocks.top_label.high, whole.top_label.high, atol=1e-12)


def test_bands_hold_the_curve_and_repeat_with_the_seed():
    posterior = make_posterior(row_sizes=(30,) * 40, participants=tuple(f"p{i % 8}" for i in range(40)))
    one, two = (calibrate_posterior(posterior, seed=3).top_label for _ in range(2))
    np.testing.assert_array_equal(one.low, two.low)
    used = one.weight > 0.02
    assert (one.low[used] <= one.observed[used] + 1e-12).all()
    assert (one.high[used] >= one.observed[used] - 1e-12).all()


def test_by_share_uses_the_scored_samples():
    posterior = make_posterior()
    calibration = calibrate_posterior(posterior, at=[0.5], bins=1)
    score = score_posterior(posterior, at=[0.5])
    expected = abs(score.overall[0].accuracy - float(score.segments["confidence"].mean()))
    assert calibration.by_share[0.5].expected_calibration_error == pytest.approx(expected)


def test_one_participant_has_no_band():
    calibration = calibrate_posterior(make_posterior(), participants=["p1"])
    assert np.isnan(calibration.top_label.low).all()
    assert calibration.participants == 1


def test_no_bins_are_refused():
    with pytest.raises(LogError, match="bins is 0"):
        calibrate_posterior(make_posterior(), bins=0)


def _literal(posterior):
    goals = posterior["goal"].values.tolist()
    starts = np.concatenate([[0], np.cumsum(posterior["row_size"].values)])
    top, every = [], []
    for i in range(posterior.sizes["segment"]):
        first = int(starts[int(posterior["segment_trial"].values[i])])
        start, stop = int(posterior["segment_start"].values[i]), int(posterior["segment_stop"].values[i])
        true = goals.index(posterior["true_goal"].values[i])
        for k in range(first + start, first + stop):
            p = [math.exp(value) for value in posterior["log_posterior"].values[k]]
            top.append((max(p), float(p.index(max(p)) == true), 1 / (stop - start)))
            every += [(p[g], float(g == true), 1 / (stop - start) / len(p)) for g in range(len(p))]
    return top, every


def _literal_bins(cells, bins):
    total = sum(weight for _, _, weight in cells)
    table = []
    for b in range(bins):
        inside = [cell for cell in cells if b / bins < cell[0] <= (b + 1) / bins]
        weight = sum(cell[2] for cell in inside)
        means = [sum(cell[i] * cell[2] for cell in inside) / weight if weight else 0.0 for i in (0, 1)]
        table.append((weight / total, *means))
    return sum(weight * abs(observed - predicted) for weight, predicted, observed in table), table
