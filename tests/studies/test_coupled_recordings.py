"""What goal-coupled reaches on people beside a robot, where PPINFER_DATA points to them."""

from __future__ import annotations

import pytest

from ppinfer.goals import GoalCoupled
from ppinfer.studies import compare_posteriors, fit_study, infer_log, read_reaching_study, score_posterior
from ppinfer.studies.logged_beliefs import write_logged_belief
from ppinfer.studies.posterior import open_posterior
from ppinfer.studies.storage import write_log

from .logs import study_data

# accuracy and mean log posterior after a quarter, half and three quarters of each approach
FLOORS = ((0.81, -0.50), (0.905, -0.26), (0.97, -0.08))
APPROACHES = {"min_samples": 8, "min_distance": 2.0}


@pytest.fixture(scope="module")
def reaching():
    return read_reaching_study(study_data("reaching-study"))


def test_people_are_predicted_as_they_come(reaching):
    scores = score_posterior(infer_log(reaching, GoalCoupled()), **APPROACHES).overall
    for score, (accuracy, log_posterior) in zip(scores, FLOORS, strict=True):
        assert score.accuracy >= accuracy
        assert score.mean_log_posterior >= log_posterior


def test_four_people_tell_what_the_others_will_do(reaching):
    people = list(dict.fromkeys(reaching["participant"].values.astype(str)))
    fitted = fit_study(reaching, GoalCoupled(), participants=people[:4], folds=0).fit
    assert fitted.converged
    others = score_posterior(infer_log(reaching, fitted.model), exclude=people[:4], **APPROACHES).overall
    for score, (accuracy, log_posterior) in zip(others, FLOORS, strict=True):
        assert score.accuracy >= accuracy
        assert score.mean_log_posterior >= log_posterior


def test_it_is_ahead_of_what_the_robot_believed_live_and_of_motion_alone(reaching, tmp_path):
    write_log(reaching, tmp_path / "log.nc")
    done = write_logged_belief(tmp_path / "log.nc", tmp_path / "live.nc", "belief_robot")
    assert (done.zeros, done.normalised > 0) == (0, True)
    with open_posterior(tmp_path / "live.nc", load=True, verify=True) as live:
        posteriors = {
            "live": live,
            "alone": infer_log(reaching, GoalCoupled().without("lead", "partner")),
            "coupled": infer_log(reaching, GoalCoupled()),
        }
    for other in ("live", "alone"):
        pair = {name: posteriors[name] for name in (other, "coupled")}
        differences = compare_posteriors(pair, resamples=2000, **APPROACHES).differences
        assert all(difference.mean_log_posterior_low > 0 for difference in differences)
