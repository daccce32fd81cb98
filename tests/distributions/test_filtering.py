"""Filters and smoothers: the sum over all paths, steps one by one, chains of rows, extremes, refusals."""

import math
from itertools import product
from unittest import mock

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ppinfer import Axis, AxisError, Distribution, Factor, FactorError, ImpossibleEvidenceError
from ppinfer.distributions import filter_states, forward_filter, smooth, smooth_states
from ppinfer.testing import (
    axes,
    check_batch_equals_loop,
    check_normalisation,
    check_online_equals_offline,
    check_relabelling,
    check_smoother,
    distributions,
    factors,
    log_weights,
    relabellings,
    transitions,
)

GOAL = Axis("goal", ["cup", "bowl"])


@st.composite
def ragged_problems(draw, zeros=True):
    """Rows, chains of rows, several transitions or none: the arguments of the filter by name."""
    k = draw(st.integers(1, 3))
    sizes = draw(st.lists(st.integers(1, 3), min_size=1, max_size=4))
    logs = log_weights(zeros=zeros)
    problem = {
        "log_likelihood": draw(arrays(np.float64, (sum(sizes), k), elements=logs)),
        "row_size": np.array(sizes),
        "log_prior": draw(arrays(np.float64, (len(sizes), k), elements=logs)),
    }
    if draw(st.booleans()):
        count = draw(st.integers(1, 2))
        axis = Axis("goal", k)
        tables = [
            draw(transitions(axis, zeros=zeros)).align("goal", "next_goal").log_values for _ in range(count)
        ]
        problem["log_transition"] = np.array(tables)
        problem["which_transition"] = draw(arrays(np.int64, len(sizes), elements=st.integers(0, count - 1)))
    if draw(st.booleans()):
        flags = draw(arrays(np.bool_, len(sizes)))
        flags[0] = False
        problem["continues"] = flags
    return problem


def path_posteriors(
    log_likelihood, row_size, log_prior, log_transition=None, which_transition=None, continues=None
):
    """The filtered and smoothed posterior, from every path of every chain; None where there is none."""
    k = log_likelihood.shape[1]
    rows = np.repeat(np.arange(len(row_size)), row_size)
    starts = np.flatnonzero(np.diff(rows, prepend=-1))
    fresh = [s for s in starts if continues is None or not continues[rows[s]]]
    filtered, smoothed = np.empty_like(log_likelihood), np.empty_like(log_likelihood)
    identity = np.where(np.eye(k, dtype=bool), 0.0, -math.inf)
    for start, stop in zip(fresh, [*fresh[1:], len(rows)], strict=True):
        for end in range(start + 1, stop + 1):
            paths = np.array(list(product(range(k), repeat=end - start)))
            weights = log_prior[rows[start], paths[:, 0]]
            for t in range(start, end):
                weights = weights + log_likelihood[t, paths[:, t - start]]
                if t > start:
                    table = identity if log_transition is None else log_transition[which_transition[rows[t]]]
                    weights = weights + table[paths[:, t - start - 1], paths[:, t - start]]
            if weights.max() == -math.inf:
                return None, end - 1
            weights = weights - weights.max()
            weights = weights - np.log(np.exp(weights).sum())
            posterior = np.array(
                [
                    [np.logaddexp.reduce(weights[paths[:, i] == j], initial=-math.inf) for j in range(k)]
                    for i in range(end - start)
                ]
            )
            filtered[end - 1] = posterior[-1]
        smoothed[start:stop] = posterior
    return filtered, smoothed


def logs(probabilities):
    with np.errstate(divide="ignore"):
        return np.log(probabilities)


def agree(found, expected):
    assert np.array_equal(found == -math.inf, expected == -math.inf)
    finite = expected > -math.inf
    # logs of 1e6, summed over a few samples, keep ten digits
    assert np.allclose(found[finite], expected[finite], rtol=1e-12, atol=2e-8)
    assert np.abs(np.exp(found).sum(axis=1) - 1.0).max() <= 1e-12


@given(ragged_problems())
def test_filter_and_smoother_are_the_sums_over_all_paths(problem):
    filtered, smoothed = path_posteriors(**problem)
    if filtered is None:
        for scan in (forward_filter, smooth):
            with pytest.raises(ImpossibleEvidenceError, match=f"possible at the sample {smoothed}:"):
                scan(**problem, describe=lambda sample: f"the sample {sample}")
        return
    agree(forward_filter(**problem), filtered)
    agree(smooth(**problem), smoothed)


@given(ragged_problems(zeros=False))
@example(  # plain numbers do for the second row, not for the first
    {
        "log_likelihood": np.array([[-640.0, 0.0], [0.0, 0.0]]),
        "row_size": np.array([1, 1]),
        "log_prior": np.full((2, 2), -28.6875),
        "log_transition": np.full((1, 2, 2), np.log(0.5)),
        "which_transition": np.array([0, 0]),
    }
)
def test_rows_one_at_a_time_give_to_the_bit_what_all_rows_give(problem):
    problem = dict(problem)
    problem.pop("continues", None)
    which = problem.pop("which_transition", None)
    for scan in (forward_filter, smooth):
        whole = scan(**problem, which_transition=which)
        start = 0
        for row, size in enumerate(problem["row_size"]):
            alone = scan(
                problem["log_likelihood"][start : start + size],
                [size],
                problem["log_prior"][row : row + 1],
                problem.get("log_transition"),
                None if which is None else which[row : row + 1],
            )
            assert np.array_equal(whole[start : start + size], alone)
            start += size


@given(ragged_problems(zeros=False))
def test_a_row_cut_in_two_that_continues_is_the_row_in_one_piece(problem):
    problem.pop("continues", None)
    sizes = problem["row_size"]
    cut = np.array([part for size in sizes for part in ([size] if size == 1 else [1, size - 1])])
    origin = np.array([row for row, size in enumerate(sizes) for _ in range(1 if size == 1 else 2)])
    pieces = {
        "log_likelihood": problem["log_likelihood"],
        "row_size": cut,
        "log_prior": problem["log_prior"][origin],
        "log_transition": problem.get("log_transition"),
        "continues": np.diff(origin, prepend=-1) == 0,
    }
    if "which_transition" in problem:
        pieces["which_transition"] = problem["which_transition"][origin]
    # the prior of a row that continues is not looked at
    pieces["log_prior"][pieces["continues"]] = math.nan
    for scan in (forward_filter, smooth):
        assert np.array_equal(scan(**pieces), scan(**problem))


@given(ragged_problems())
def test_read_only_and_listed_inputs_give_the_same(problem):
    frozen = {name: value.copy() for name, value in problem.items()}
    for array in frozen.values():
        array.flags.writeable = False
    listed = {name: value.tolist() for name, value in problem.items()}
    try:
        expected = forward_filter(**problem)
    except ImpossibleEvidenceError:
        return
    assert np.array_equal(forward_filter(**frozen), expected)
    assert np.array_equal(forward_filter(**listed), expected)
    assert np.array_equal(smooth(**frozen), smooth(**problem))


@given(ragged_problems())
def test_plain_numbers_where_they_do_give_what_logs_give(problem):
    try:
        found = forward_filter(**problem)
    except ImpossibleEvidenceError:
        return
    with mock.patch("ppinfer.distributions.filtering._filtered_plainly", return_value=None):
        agree(found, forward_filter(**problem))


def test_plain_numbers_are_enough_for_likely_goals_and_absent_ones():
    log_likelihood = np.random.default_rng(0).normal(scale=20.0, size=(1000, 3))
    log_likelihood[:, 2] = -np.inf
    stay = logs([[[0.9, 0.1, 0.0], [0.2, 0.8, 0.0], [0.0, 0.0, 1.0]]])
    problem = log_likelihood, [400, 600], logs([[0.5, 0.5, 0.0]] * 2), stay
    with mock.patch("ppinfer.distributions.scans.forward_kernel", None):
        found = forward_filter(*problem)
    with mock.patch("ppinfer.distributions.filtering._filtered_plainly", return_value=None):
        expected = forward_filter(*problem)
    assert np.allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_weights_of_minus_a_million_and_of_a_trillionth_both_survive_ten_thousand_samples():
    log_likelihood = np.tile([-1e6, -1e6 - 1e-9], (10_000, 1))
    exact = log_likelihood[0, 0] - log_likelihood[0, 1]  # what floating point holds of 1e-9 there
    log_p = forward_filter(log_likelihood, [10_000], np.zeros((1, 2)))
    odds = log_p[:, 0] - log_p[:, 1]
    assert np.allclose(odds, exact * np.arange(1, 10_001), rtol=1e-9)
    fine = forward_filter(np.tile([0.0, -1e-12], (10_000, 1)), [10_000], np.zeros((1, 2)))
    assert np.allclose(fine[:, 0] - fine[:, 1], 1e-12 * np.arange(1, 10_001), rtol=1e-12, atol=1e-15)


def test_a_hypothesis_may_be_a_million_nats_behind_and_come_back():
    stay = np.log([[[0.9, 0.1], [0.1, 0.9]]])
    log_likelihood = np.array([[0.0, -1e6], [0.0, -1e6], [-1e6, 0.0], [-1e6, 0.0]])
    still = forward_filter(log_likelihood, [4], np.zeros((1, 2)))
    assert np.allclose(still[-1], [math.log(0.5)] * 2)
    moved = smooth(log_likelihood, [4], np.zeros((1, 2)), stay)
    assert (np.argmax(moved, axis=1) == [0, 0, 1, 1]).all()
    assert np.isfinite(moved).all()


@given(axes("goal", max_size=3), st.integers(1, 4), st.data())
def test_states_filtered_offline_are_those_filtered_step_by_step(goal, length, data):
    extra = [Axis("trial", 2)] if data.draw(st.booleans()) else []
    prior = data.draw(distributions([goal, *extra], batch=[axis.name for axis in extra]))
    transition = data.draw(st.one_of(st.none(), transitions(goal)))
    likelihood = data.draw(factors(data.draw(st.permutations([goal, Axis("sample", length), *extra]))))
    check_online_equals_offline(prior, transition, likelihood)


@given(axes("goal", max_size=3), st.integers(1, 4), st.data())
def test_states_smoothed_are_the_sums_over_all_paths(goal, length, data):
    prior = data.draw(distributions([goal], batch=[]))
    likelihood = data.draw(factors([Axis("sample", length), goal]))
    check_smoother(prior, data.draw(transitions(goal)), likelihood)


@given(st.data(), st.sampled_from([filter_states, smooth_states]))
def test_trials_side_by_side_are_the_trials_one_by_one_even_with_transitions_of_their_own(data, scan):
    goal, trial = Axis("goal", 2), Axis("trial", 3)
    prior = data.draw(distributions([goal], batch=[]))
    arrow = [goal.rename("next_goal"), goal, trial]
    transition = data.draw(distributions(arrow, given=["goal"], batch=["trial"], zeros=False))
    likelihood = data.draw(factors([trial, Axis("sample", 3), goal], zeros=False))
    check_batch_equals_loop(scan, "trial", prior, transition, likelihood)


@given(axes("goal", max_size=3), st.data())
def test_permuted_goals_permute_the_filtered_posterior(goal, data):
    prior = data.draw(distributions([goal], batch=[]))
    likelihood = data.draw(factors([Axis("sample", 3), goal]))
    labels = data.draw(relabellings(goal))
    check_relabelling(lambda p, f: filter_states(p, None, f), "goal", labels, prior, likelihood)


@given(st.data())
def test_a_state_of_two_axes_of_which_one_moves_is_filtered_and_smoothed_jointly(data):
    mood = Axis("mood", 2)
    prior = data.draw(distributions([GOAL, mood], batch=[], zeros=False))
    stay = data.draw(transitions(GOAL, zeros=False))
    likelihood = data.draw(factors([Axis("sample", 3), mood, GOAL], zeros=False))
    check_online_equals_offline(prior, stay, likelihood)
    smoothed = smooth_states(prior, stay, likelihood)
    check_normalisation(smoothed)
    # what does not move has one posterior, whenever one looks back at it
    moods = smoothed.marginal("mood")
    assert moods.given(sample=0).allclose(moods.given(sample=2), atol=1e-6)


def test_the_kinds_of_axes_of_a_filtered_state_are_told_apart():
    prior = Distribution.uniform(GOAL, Axis("trial", 2), Axis("mood", 3), batch=["trial"], given=["mood"])
    found = filter_states(prior, None, Factor([Axis("sample", 4), GOAL], np.zeros((4, 2))))
    assert found.names == ("trial", "mood", "sample", "goal")
    assert (found.random, found.conditions, found.batch) == (("goal",), ("mood",), ("trial", "sample"))


def test_impossible_evidence_names_the_trial_and_the_sample():
    values = np.ones((2, 3, 2))
    values[1, 2] = 0.0
    likelihood = Factor.from_values([Axis("trial", ["a", "b"]), Axis("sample", 3), GOAL], values)
    for scan in (filter_states, smooth_states):
        with pytest.raises(ImpossibleEvidenceError, match="possible at trial='b', sample=2:"):
            scan(Distribution.uniform(GOAL), None, likelihood)


def test_what_cannot_be_filtered_is_refused():
    sample = Axis("sample", 2)
    flat = Factor([sample, GOAL], np.zeros((2, 2)))
    with pytest.raises(AxisError, match="prior has the time axis 'sample'"):
        filter_states(Distribution.uniform(GOAL, sample, batch=["sample"]), None, flat)
    with pytest.raises(AxisError, match="no axis 'time' here"):
        filter_states(Distribution.uniform(GOAL), None, flat, time="time")
    with pytest.raises(AxisError, match="no transition of"):
        filter_states(Distribution.uniform(GOAL), Distribution.uniform(GOAL), flat)
    with pytest.raises(AxisError, match="another order"):
        filter_states(Distribution.uniform(Axis("goal", ["bowl", "cup"])), None, flat)


FLAT = {"log_likelihood": np.zeros((4, 2)), "row_size": [3, 1], "log_prior": np.zeros((2, 2))}
STAY = np.log([[[0.9, 0.1], [0.1, 0.9]]])


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"log_likelihood": np.zeros(4)}, r"shape \(sample, hypothesis\), got \(4,\)"),
        ({"row_size": [3, 2]}, "add up to 5 samples over 2 rows, but log_likelihood has 4"),
        ({"row_size": [4, 0]}, "row 1 has no samples"),
        ({"row_size": [5, -1]}, "row 1 has a negative size"),
        ({"log_prior": np.zeros((2, 3))}, r"\(row, hypothesis\) = \(2, 2\), got \(2, 3\)"),
        ({"log_prior": [[0.0, 0.0], [0.0, math.nan]]}, "log_prior is nan in row 1, hypothesis 1"),
        ({"log_prior": [[math.inf, 0.0], [0.0, 0.0]]}, "log_prior is inf in row 0, hypothesis 0"),
        ({"log_transition": np.zeros((2, 2))}, r"shape \(transition, 2, 2\), got \(2, 2\)"),
        (
            {"log_transition": np.zeros((1, 2, 2))},
            "transition 0 from hypothesis 0: its probabilities sum to 2",
        ),
        ({"log_transition": np.full((1, 2, 2), math.nan)}, "sum to nan, not 1"),
        ({"log_transition": np.concatenate([STAY, STAY])}, "which_transition must say"),
        ({"log_transition": STAY, "which_transition": [0, 1]}, "row 1 is 1, but there are 1"),
        ({"log_transition": STAY, "which_transition": [0]}, "must be 2 integers"),
        ({"which_transition": [0, 0]}, "give log_transition"),
        ({"continues": [True, False]}, "row 0 cannot continue"),
        ({"continues": [0, 1]}, "array of bool"),
        (
            {"log_likelihood": [[0, 0], [0, 0], [0, 0], [0, math.nan]]},
            "nan at row 1, sample 0 of that row, hypothesis 1",
        ),
        ({"log_likelihood": [[0, 0], [0, math.inf], [0, 0], [0, 0]]}, "inf at row 0, sample 1 of that row"),
    ],
)
def test_inputs_that_do_not_fit_are_refused_with_what_and_where(changed, says):
    for scan in (forward_filter, smooth):
        with pytest.raises(FactorError, match=says):
            scan(**(FLAT | changed))


def test_evidence_that_contradicts_the_past_names_row_and_sample():
    log_likelihood = np.array([[0.0, 0.0], [0.0, -math.inf], [-math.inf, 0.0], [0.0, 0.0]])
    with pytest.raises(ImpossibleEvidenceError, match="possible at row 0, sample 2 of that row"):
        forward_filter(log_likelihood, [3, 1], np.zeros((2, 2)))
    # a transition makes the same evidence possible
    assert np.isfinite(forward_filter(log_likelihood, [3, 1], np.zeros((2, 2)), STAY)[2, 1])
