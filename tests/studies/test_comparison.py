import math
import random

import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.studies.comparison import compare_posteriors
from ppinfer.studies.scores import score_posterior

from .posteriors import make_posterior

PEOPLE = tuple(f"p{i % 7}" for i in range(30))


def _pair(*, sharper=0.1, people=PEOPLE, seed=0):
    one = make_posterior(row_sizes=(30,) * len(people), participants=people, seed=seed)
    other = one.copy(deep=True)
    rng = np.random.default_rng(seed + 100)
    logits = other["log_posterior"].values * (1 + sharper) + rng.normal(
        scale=0.5, size=one["log_posterior"].shape
    )
    other["log_posterior"].values[:] = logits - np.log(np.exp(logits).sum(axis=1, keepdims=True))
    return {"one": one, "other": other}


def test_differences_are_those_of_the_scores():
    pair = _pair()
    comparison = compare_posteriors(pair, at=[0.25, 0.5], min_samples=5, resamples=100)
    scores = {
        name: score_posterior(each, at=[0.25, 0.5], min_samples=5).overall for name, each in pair.items()
    }
    for i, difference in enumerate(comparison.differences):
        assert (difference.name, difference.against, difference.at) == ("other", "one", [0.25, 0.5][i])
        for field in ("accuracy", "mean_log_posterior"):
            expected = getattr(scores["other"][i], field) - getattr(scores["one"][i], field)
            assert getattr(difference, field) == pytest.approx(expected, abs=1e-12)
            assert getattr(difference, f"{field}_low") <= expected <= getattr(difference, f"{field}_high")


def test_intervals_agree_with_a_plain_resampling_of_participants():
    pair = _pair()
    (difference,) = compare_posteriors(pair, at=[0.5], resamples=20_000).differences
    scored = [score_posterior(each, at=[0.5]).segments for each in pair.values()]
    gap = (scored[1]["log_posterior"] - scored[0]["log_posterior"]).values[0]
    people = scored[0]["participant"].values
    by_person = {name: gap[people == name] for name in sorted(set(people))}
    draw = random.Random(1)
    means = []
    for _ in range(5000):
        chosen = np.concatenate([by_person[draw.choice(list(by_person))] for _ in by_person])
        means.append(chosen.mean())
    low, high = np.percentile(means, [2.5, 97.5])
    width = high - low
    assert difference.mean_log_posterior_low == pytest.approx(low, abs=0.05 * width)
    assert difference.mean_log_posterior_high == pytest.approx(high, abs=0.05 * width)


def test_a_posterior_does_not_differ_from_itself():
    one = make_posterior()
    for difference in compare_posteriors({"a": one, "b": one}, resamples=50).differences:
        assert difference.accuracy == difference.accuracy_low == difference.accuracy_high == 0
        assert difference.mean_log_posterior == difference.mean_log_posterior_high == 0


def test_the_seed_decides_the_intervals():
    pair = _pair()
    assert compare_posteriors(pair, seed=4) == compare_posteriors(pair, seed=4)
    assert compare_posteriors(pair, seed=4) != compare_posteriors(pair, seed=5)


def test_the_order_of_trials_and_goals_does_not_matter():
    pair = _pair(people=PEOPLE[:8])
    shuffled = pair["other"].isel(goal=[2, 0, 1])
    order = np.random.default_rng(0).permutation(shuffled.sizes["segment"])
    shuffled = shuffled.isel(segment=order)
    assert compare_posteriors(pair) == compare_posteriors(pair | {"other": shuffled})


def test_different_segments_are_refused_unless_only_common_ones_are_asked_for():
    pair = _pair()
    pair["other"] = pair["other"].isel(segment=slice(0, 50))
    with pytest.raises(
        LogError, match=r"other lacks 10 of the 60 segments of one, such as trial 't25', samples \[0, 15\)"
    ):
        compare_posteriors(pair)
    with pytest.raises(LogError, match="other lacks 10 of the 60 segments of one"):
        compare_posteriors({"other": pair["other"], "one": pair["one"]})
    comparison = compare_posteriors(pair, common_only=True, resamples=50)
    assert comparison.differences[0].segments == 50
    assert comparison.left_out["not_in_every_posterior"] == 10


def test_different_true_goals_are_refused_naming_the_segment():
    pair = _pair()
    labels = pair["other"]["true_goal"].values
    labels[3] = "0" if labels[3] != "0" else "1"
    with pytest.raises(
        LogError, match=r"trial 't1', samples \[15, 30\): the true goal is '\d' in one and '\d' in other"
    ):
        compare_posteriors(pair, common_only=True)


def test_different_agents_are_refused():
    pair = _pair()
    pair["other"].attrs["agent"] = "robot"
    with pytest.raises(LogError, match="one is about agent 'human' and other about 'robot'"):
        compare_posteriors(pair)


def test_one_posterior_is_not_a_comparison():
    with pytest.raises(LogError, match="at least two posteriors"):
        compare_posteriors({"a": make_posterior()})


def test_impossible_true_goals_leave_the_log_difference_undefined_and_are_counted():
    pair = _pair()
    goals = pair["one"]["goal"].values
    wrong = [int(goal == pair["one"]["true_goal"].values[0]) for goal in goals]
    pair["other"]["log_posterior"].values[:15] = np.log(
        1 - np.array(wrong) + 0.0, where=np.array(wrong) == 0, out=np.full(3, -np.inf)
    ) - np.log(2)
    comparison = compare_posteriors(pair, at=[0.5], resamples=50)
    (difference,) = comparison.differences
    assert difference.impossible == 1
    assert difference.mean_log_posterior == -math.inf
    assert math.isnan(difference.mean_log_posterior_low)
    assert math.isfinite(difference.accuracy_low)
    assert "the true goal of 1 of 60 segments has probability zero" in comparison.warnings[0]


def test_one_participant_has_no_interval_and_says_so():
    comparison = compare_posteriors(_pair(people=("p",) * 6), resamples=50)
    assert math.isnan(comparison.differences[0].accuracy_low)
    assert comparison.warnings == ["one participant only: no intervals over participants"]
