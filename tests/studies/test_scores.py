import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppinfer.errors import LogError
from ppinfer.studies.posterior import open_posterior, write_posterior
from ppinfer.studies.resampling import mean_and_cluster_se
from ppinfer.studies.scores import score_posterior, scored_sample

from .posteriors import make_posterior

SHARES = (0.25, 0.5, 0.75)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(
    "options", [{}, {"min_samples": 13}, {"min_distance": 4.0}, {"participants": ["p1", "p3"]}]
)
def test_scores_equal_a_plain_loop_over_segments(seed, options):
    posterior = make_posterior(seed=seed)
    scores = score_posterior(posterior, at=SHARES, **options)
    for score in scores.overall:
        expected = _literal(posterior, score.at, **options)
        correct, logs, people = (np.array(column) for column in zip(*expected, strict=True))
        assert score.segments == len(expected)
        assert score.participants == len(set(people))
        assert score.accuracy == pytest.approx(correct.mean(), abs=1e-12)
        assert score.mean_log_posterior == pytest.approx(logs.mean(), abs=1e-12)
        assert score.accuracy_se == pytest.approx(_literal_se(correct, people), abs=1e-12)
        assert score.mean_log_posterior_se == pytest.approx(_literal_se(logs, people), abs=1e-12)
    kept = len(scores.segments["segment"])
    assert sum(scores.left_out.values()) == posterior.sizes["segment"] - kept


def test_scores_of_a_file_equal_scores_in_memory(tmp_path):
    posterior = make_posterior(moving_goals=True)
    write_posterior(posterior, tmp_path / "p.nc")
    with open_posterior(tmp_path / "p.nc") as lazy:
        assert (
            score_posterior(lazy, min_distance=2).overall
            == score_posterior(posterior, min_distance=2).overall
        )


def test_participants_scores_average_to_the_whole():
    scores = score_posterior(make_posterior(), at=[0.5])
    assert {each.participant for each in scores.by_participant} == {"p1", "p2", "p3"}
    total = sum(each.accuracy * each.segments for each in scores.by_participant)
    assert total / scores.overall[0].segments == pytest.approx(scores.overall[0].accuracy)


def test_a_tie_of_k_goals_counts_one_kth():
    posterior = make_posterior(goals=("a", "b", "c", "d"))
    posterior["log_posterior"].values[:] = np.log([1 / 4] * 4)
    assert score_posterior(posterior, at=[0.5]).overall[0].accuracy == pytest.approx(0.25)


def test_an_impossible_true_goal_is_reported_and_never_dropped():
    posterior = make_posterior(goals=("a", "b"))
    posterior["true_goal"].values[:] = "a"
    posterior["true_goal"].values[2] = "b"
    posterior["log_posterior"].values[:] = [0.0, -np.inf]
    scores = score_posterior(posterior, at=[0.5])
    score = scores.overall[0]
    assert (score.mean_log_posterior, score.impossible, score.segments) == (-math.inf, 1, 8)
    assert math.isnan(score.mean_log_posterior_se)
    assert score.accuracy == 7 / 8
    assert scores.warnings == [
        "at 0.5: the true goal of 1 of 8 segments has probability zero, so the mean log posterior is -inf"
    ]


def test_one_participant_has_no_standard_error_and_says_so():
    scores = score_posterior(make_posterior(), participants=["p2"])
    assert math.isnan(scores.overall[0].accuracy_se)
    assert scores.warnings == ["one participant only: no standard errors over participants"]


def test_short_and_unlabelled_segments_are_counted_by_reason():
    posterior = make_posterior()
    posterior["true_goal"].values[0] = ""
    posterior["segment_stop"].values[3] = posterior["segment_start"].values[3] + 2
    scores = score_posterior(posterior, exclude=["p3"])
    assert scores.left_out == {"participant": 2, "true_goal_unknown": 1, "shorter_than_3_samples": 1}
    assert scores.overall[0].segments == 4


def test_a_dropout_at_the_start_is_measured_from_the_first_seen_position():
    posterior = make_posterior()
    posterior["position"].values[:] = 0.0
    posterior["observed"].values[:] = 1
    posterior["goal_position"].values[:] = [3.0, 4.0]
    posterior["observed"].values[:2] = 0
    posterior["position"].values[:2] = np.nan
    posterior["position"].values[2] = [3.0, 3.0]
    scores = score_posterior(posterior, min_distance=2)
    assert scores.left_out["below_min_distance"] == 1
    assert 0 not in scores.segments["segment"].values
    posterior["observed"].values[:15] = 0
    posterior["position"].values[:15] = np.nan
    assert score_posterior(posterior, min_distance=2).left_out["distance_unknown"] == 1


def test_unknown_participants_are_named():
    with pytest.raises(LogError, match="unknown participants 'p8', 'p9'; the posterior has 'p1', 'p2', 'p3'"):
        score_posterior(make_posterior(), participants=["p9", "p1"], exclude=["p8"])


def test_nothing_left_to_score_says_why():
    with pytest.raises(
        LogError, match=r"no segment can be scored: 8 segments left out \(below min samples: 8\)"
    ):
        score_posterior(make_posterior(), min_samples=1000)
    with pytest.raises(LogError, match="the posterior has no segments"):
        score_posterior(make_posterior(segments_per_trial=0))


@pytest.mark.parametrize("at", [[0.0], [1.5], [-0.1], [float("nan")], []])
def test_shares_out_of_range_are_refused(at):
    with pytest.raises(LogError, match="shares of the path seen"):
        score_posterior(make_posterior(), at=at)


def test_a_nan_posterior_is_refused_naming_the_sample():
    posterior = make_posterior()
    posterior["log_posterior"].values[:] = np.nan
    with pytest.raises(LogError, match="log_posterior of sample 3 is NaN"):
        score_posterior(posterior, at=[0.25])


@given(length=st.integers(3, 10_000), percent=st.integers(1, 100))
def test_the_scored_sample_follows_exact_arithmetic(length, percent):
    expected = max(3, -(-percent * length // 100)) - 1
    assert scored_sample(np.array([length]), np.array([percent / 100]))[0, 0] == expected
    assert 2 <= expected < length


@given(st.lists(st.floats(-100, 100), min_size=2, max_size=30))
def test_with_one_segment_a_participant_the_standard_error_is_the_plain_one(values):
    x = np.array(values)
    _, se = mean_and_cluster_se(x, np.arange(len(x)), len(x))
    assert se == pytest.approx(x.std(ddof=1) / math.sqrt(len(x)), rel=1e-9, abs=1e-9)


def _literal(posterior, at, min_samples=0, min_distance=0.0, participants=None):
    goals = posterior["goal"].values.tolist()
    starts = np.concatenate([[0], np.cumsum(posterior["row_size"].values)])
    out = []
    for i in range(posterior.sizes["segment"]):
        trial = int(posterior["segment_trial"].values[i])
        start, stop = int(posterior["segment_start"].values[i]), int(posterior["segment_stop"].values[i])
        person = posterior["participant"].values[trial]
        true = goals.index(posterior["true_goal"].values[i])
        length = stop - start
        first = int(starts[trial]) + start
        seen = next(k for k in range(first, first + length) if posterior["observed"].values[k])
        distance = math.dist(
            posterior["position"].values[seen], posterior["goal_position"].values[trial, true]
        )
        if length < max(3, min_samples) or distance < min_distance:
            continue
        if participants is not None and person not in participants:
            continue
        row = posterior["log_posterior"].values[first + max(3, math.ceil(at * length)) - 1]
        best = [g for g in range(len(goals)) if row[g] == max(row)]
        out.append(((true in best) / len(best), row[true], person))
    return out


def _literal_se(values, people):
    mean = sum(values) / len(values)
    groups = sorted(set(people))
    squares = sum(sum(v - mean for v, p in zip(values, people, strict=True) if p == g) ** 2 for g in groups)
    return math.sqrt(len(groups) / (len(groups) - 1) * squares) / len(values)
