"""Array programs over all trials give what loops over trials and samples give."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer.studies.metrics import METRICS, trial_metrics
from ppinfer.testing import example_team_log

from .literal import literal_metrics


@settings(max_examples=25)
@given(
    seed=st.integers(0, 10_000),
    samples=st.integers(1, 14),
    participants=st.integers(1, 3),
    speed=st.sampled_from([0.0, 0.25, 0.5, 2.0]),
)
def test_every_metric_equals_its_definition_written_out(seed, samples, participants, speed):
    log = example_team_log(participants=participants, samples=samples, seed=seed)
    for flags in (False, True):
        idle = {"idle": "flags"} if flags else {"idle": "motion", "idle_speed": speed}
        found = trial_metrics(log, **idle)
        expected = literal_metrics(log, speed=speed, flags=flags)
        assert set(expected) == set(METRICS)
        for name in METRICS:
            if name in found.not_available:
                assert np.isnan(expected[name]).all(), name
                continue
            np.testing.assert_allclose(found.values_of(name), expected[name], rtol=1e-12, err_msg=name)


@pytest.mark.parametrize("block_samples", [1, 7, 1000])
def test_blocks_of_any_size_give_the_same(block_samples):
    log = example_team_log(participants=2, samples=9, seed=3)
    whole, parts = (trial_metrics(log, block_samples=size) for size in (10**6, block_samples))
    np.testing.assert_array_equal(parts.values, whole.values)
    assert parts.provenance == whole.provenance
