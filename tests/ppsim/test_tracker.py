import numpy as np
import pytest

from ppinfer.errors import ModelError
from ppsim.errors import SimulationError
from ppsim.reaching import Tracker

TRUTH = np.zeros((4000, 2, 2))


def track(**options):
    return Tracker(**options).track(TRUTH, 10.0, np.random.default_rng(0))


def test_a_perfect_tracker_sees_the_truth():
    position, observed = track()
    np.testing.assert_array_equal(position, TRUTH)
    assert observed.all()


def test_noise_and_shares_are_as_asked_for():
    position, observed = track(noise=0.02, dropouts=0.1, outliers=0.05)
    assert np.isnan(position).all(axis=-1).mean() == pytest.approx(0.1, abs=0.01)
    np.testing.assert_array_equal(np.isnan(position).any(axis=-1), ~observed)
    far = np.abs(position[observed]).max(axis=-1) > 0.2
    assert far.mean() == pytest.approx(0.05, abs=0.01)
    assert position[observed][~far].std() == pytest.approx(0.02, rel=0.05)


def test_one_option_does_not_change_what_another_one_does():
    noisy, _ = track(noise=0.02)
    both, observed = track(noise=0.02, dropouts=0.3)
    np.testing.assert_array_equal(both[observed], noisy[observed])


def test_impossible_trackers_are_refused():
    with pytest.raises(SimulationError, match="noise"):
        Tracker(noise=-1.0)
    with pytest.raises(ModelError, match="outliers"):
        Tracker(outliers=1.1)
