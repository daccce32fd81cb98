"""Beliefs that a log holds, as posteriors."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ppinfer.errors import LogError
from ppinfer.studies import score_posterior, write_log
from ppinfer.studies.logged_beliefs import belief_variables, write_logged_belief
from ppinfer.studies.posterior import open_posterior
from ppinfer.testing import example_log


def with_belief(values, name="logged_belief"):
    """Return a log of four trials of twenty samples, three goals, with a belief of these values."""
    log = example_log(participants=2, trials=2)
    log[name] = (("sample", "goal"), np.broadcast_to(values, (log.sizes["sample"], 3)).copy())
    return log


def written(log, folder, belief="belief"):
    write_log(log, folder / "log.nc")
    done = write_logged_belief(folder / "log.nc", folder / "post.nc", belief, block_samples=30)
    with open_posterior(folder / "post.nc", load=True, verify=True) as posterior:
        return done, posterior


def test_a_logged_belief_is_a_posterior_with_the_trials_and_segments(tmp_path):
    done, posterior = written(with_belief([0.5, 0.3, 0.2]), tmp_path)
    assert_allclose(np.exp(posterior["log_posterior"].values), np.tile([0.5, 0.3, 0.2], (80, 1)))
    assert (done.variable, done.zeros, done.normalised) == ("logged_belief", 0, 0)
    assert (done.inference.trials, done.inference.segments) == (4, 4)
    assert posterior.attrs["model"] == "logged logged_belief"
    assert len(score_posterior(posterior).overall) == 3


def test_what_does_not_sum_to_one_is_normalised_and_counted(tmp_path):
    done, posterior = written(with_belief([0.6, 0.3, 0.3]), tmp_path)
    assert done.normalised == 80
    assert_allclose(np.exp(posterior["log_posterior"].values[0]), [0.5, 0.25, 0.25])


def test_zeros_stay_zeros_and_are_counted(tmp_path):
    done, posterior = written(with_belief([1.0, 0.0, 0.0]), tmp_path)
    assert done.zeros == 160
    assert (posterior["log_posterior"].values[:, 1:] == -np.inf).all()


def test_logarithms_are_told_by_their_name(tmp_path):
    log = with_belief(np.log([0.5, 0.3, 0.2]), "live_log_belief")
    done, posterior = written(log, tmp_path)
    assert done.variable == "live_log_belief"
    assert_allclose(posterior["log_posterior"].values[7], np.log([0.5, 0.3, 0.2]))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ([0.5, np.nan, 0.5], "sample 0: logged_belief is not a number"),
        ([0.5, -0.5, 1.0], "is negative"),
        ([0.0, 0.0, 0.0], "is zero for every goal that is present"),
    ],
)
def test_what_is_no_belief_is_refused_and_nothing_is_written(values, message, tmp_path):
    with pytest.raises(LogError, match=message):
        written(with_belief(values), tmp_path)
    assert not (tmp_path / "post.nc").exists()


def test_an_absent_goal_must_not_be_believed_in(tmp_path):
    log = with_belief([0.5, 0.3, 0.2])
    present = np.ones((4, 3), dtype=np.int8)
    unpursued = "2" if log["true_goal"].values[3] != "2" else "1"
    present[3, int(unpursued)] = 0
    log["goal_present"] = (("trial", "goal"), present)
    log["goal_position"].values[3, int(unpursued)] = np.nan
    with pytest.raises(LogError, match="above zero for a goal that is absent"):
        written(log, tmp_path)


def test_an_unknown_belief_is_answered_with_those_there_are(tmp_path):
    log = with_belief([0.5, 0.3, 0.2])
    assert belief_variables(log) == ["logged_belief"]
    with pytest.raises(LogError, match=r"no belief 'beleif': .*did you mean 'belief'"):
        written(log, tmp_path, "beleif")
    with pytest.raises(LogError, match="holds none"):
        written(example_log(), tmp_path)
