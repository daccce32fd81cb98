"""Distributions: kinds of axes, the chain rule, summaries, refusals."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.special import rel_entr
from scipy.stats import chisquare
from scipy.stats import entropy as scipy_entropy

from ppinfer import Axis, AxisError, Distribution, Factor, FactorError, ImpossibleEvidenceError
from ppinfer.testing import check_normalisation, distributions, factors

from .exact import Exact

GOAL = Axis("goal", ["cup", "bowl", "mug"])
MOOD = Axis("mood", ["calm", "brisk"])
TRIAL = Axis("trial", 2)
P = Distribution.from_probabilities([GOAL], [0.5, 0.25, 0.25])
JOINT = Distribution.from_probabilities([GOAL, MOOD], [[0.1, 0.2], [0.0, 0.3], [0.25, 0.15]])


def weights(*shape):
    """Small whole numbers, with some support along the first axis."""
    return arrays(np.int64, shape, elements=st.integers(0, 5)).filter(lambda w: (w.sum(axis=0) > 0).all())


# kinds of axes


@given(distributions())
def test_the_kinds_of_axes_are_told_apart_and_survive_xarray_pickle_and_another_order(p):
    assert set(p.random) | set(p.conditions) | set(p.batch) == set(p.names)
    for again in (
        Distribution.from_xarray(p.to_xarray()),
        pickle.loads(pickle.dumps(p)),
        p.align(*p.names[::-1]),
        p.rename(**{p.names[0]: "other"}).rename(other=p.names[0]),
    ):
        assert again == p
        assert (set(again.random), set(again.conditions), set(again.batch)) == (
            set(p.random),
            set(p.conditions),
            set(p.batch),
        )


def test_the_same_numbers_with_other_kinds_of_axes_are_another_distribution():
    table = np.full((3, 2), 1 / 3)
    given_mood = Distribution.from_probabilities([GOAL, MOOD], table, given=["mood"])
    batch_mood = Distribution.from_probabilities([GOAL, MOOD], table, batch=["mood"])
    assert given_mood != batch_mood
    assert given_mood != Factor(given_mood.axes, given_mood.log_values)


def test_xarray_attributes_can_be_overruled():
    array = Factor(P.axes, P.log_values).to_xarray()
    assert Distribution.from_xarray(array) == P
    table = Distribution.uniform(GOAL, MOOD, given=["mood"]).to_xarray()
    assert Distribution.from_xarray(table, given=[], batch=["mood"]).batch == ("mood",)


def test_the_repr_reads_like_the_field_writes_it():
    p = Distribution.uniform(GOAL, MOOD, TRIAL, given=["mood"], batch=["trial"])
    assert repr(p) == "Distribution p(goal | mood; trial): goal 3, mood 2, trial 2"
    assert "0.3333" in p._repr_html_()


def test_a_distribution_needs_a_random_axis_and_no_axis_of_two_kinds_unknown():
    with pytest.raises(AxisError, match="at least one random axis"):
        Distribution([GOAL], np.zeros(3), given=["goal"])
    with pytest.raises(AxisError, match="named twice"):
        Distribution([GOAL, MOOD], np.zeros((3, 2)), given=["mood"], batch=["mood"])
    with pytest.raises(AxisError, match="no axis 'gaol'"):
        Distribution.uniform(GOAL, batch=["gaol"])


def test_sums_other_than_one_are_refused_by_cell():
    with pytest.raises(FactorError, match=r"sum to 0\.9, not 1, at all labels together"):
        Distribution.from_probabilities([GOAL], [0.5, 0.2, 0.2])
    with pytest.raises(FactorError, match=r"sum to 1\.1, not 1, at trial=1"):
        Distribution.from_probabilities([MOOD, TRIAL], [[0.5, 0.5], [0.5, 0.6]], batch=["trial"])
    with pytest.raises(FactorError, match="sum to 0, not 1"):
        Distribution([GOAL], [-math.inf] * 3)
    with pytest.raises(FactorError, match="nan at goal='cup'"):
        Distribution([GOAL], [math.nan, 0.0, 0.0])


def test_rounding_in_the_input_is_scaled_away():
    p = Distribution.from_probabilities([GOAL], [0.5, 0.25, 0.25 + 5e-10])
    check_normalisation(p)


# products


@given(weights(3, 2), weights(2))
def test_a_conditional_times_its_condition_is_the_exact_joint(a, b):
    conditional = Factor.from_values([GOAL, MOOD], a).normalize("goal")
    prior = Factor.from_values([MOOD], b).normalize("mood")
    joint = conditional * prior
    assert isinstance(joint, Distribution)
    assert set(joint.random) == {"goal", "mood"}
    check_normalisation(joint)
    exact = Exact.of([GOAL, MOOD], a).normalize("goal") * Exact.of([MOOD], b).normalize("mood")
    assert exact.agrees_with(joint)
    assert exact.agrees_with(prior * conditional)
    assert exact.sum("mood").agrees_with(joint.marginal("goal"))


def test_independent_distributions_multiply_to_a_joint():
    joint = P * Distribution.uniform(MOOD)
    assert isinstance(joint, Distribution)
    assert joint.random == ("goal", "mood")


def test_conditions_that_nothing_draws_stay_conditions_and_batches_stay_batches():
    x = Distribution.uniform(GOAL, MOOD, TRIAL, given=["mood"], batch=["trial"])
    y = Distribution.uniform(Axis("plan", 2), GOAL, given=["goal"])
    product = x * y
    assert isinstance(product, Distribution)
    assert set(product.random) == {"goal", "plan"}
    assert (product.conditions, product.batch) == (("mood",), ("trial",))


def test_experts_over_the_same_axis_multiply_to_a_factor_that_needs_normalising():
    product = P * P
    assert not isinstance(product, Distribution)
    assert product.normalize("goal").prob(goal="cup") == pytest.approx(0.25 / 0.375)


def test_conditioning_in_a_circle_multiplies_to_a_factor():
    there = Distribution.uniform(GOAL, MOOD, given=["mood"])
    back = Distribution.uniform(GOAL, MOOD, given=["goal"])
    assert not isinstance(there * back, Distribution)


def test_a_distribution_times_a_factor_is_a_factor():
    assert type(P * Factor([GOAL], np.zeros(3))) is Factor
    assert type(P / P) is Factor
    assert type(P**2) is Factor


# conditioning


@given(weights(6), st.data())
def test_conditionals_agree_with_rational_arithmetic_or_name_the_impossible_condition(w, data):
    joint = Factor.from_values([GOAL, MOOD], w.reshape(3, 2)).normalize("goal", "mood")
    exact = Exact.of([GOAL, MOOD], w.reshape(3, 2))
    marginal = w.reshape(3, 2).sum(axis=0)
    if (marginal == 0).any():
        label = MOOD.labels[int(np.argmin(marginal))]
        with pytest.raises(ImpossibleEvidenceError, match=f"probability zero.*mood='{label}'"):
            joint.given("mood")
        with pytest.raises(ImpossibleEvidenceError, match=f"on mood='{label}' has probability zero"):
            joint.given(mood=label)
        return
    conditional = joint.given("mood")
    assert conditional.conditions == ("mood",)
    assert exact.normalize("goal").agrees_with(conditional)
    label = data.draw(st.sampled_from(MOOD.labels))
    assert joint.given(mood=label).allclose(conditional.given(mood=label))


def test_labels_of_conditions_and_batches_are_picked():
    p = Distribution.uniform(GOAL, MOOD, TRIAL, given=["mood"], batch=["trial"])
    assert p.given(mood="calm", trial=1) == Distribution.uniform(GOAL)
    assert p.restrict(trial=1) == Distribution.uniform(GOAL, MOOD, given=["mood"])
    assert isinstance(p.restrict(trial=[0]), Distribution)
    assert type(p.restrict(goal=["cup"])) is Factor


def test_conditioning_on_everything_or_on_conditions_is_refused():
    with pytest.raises(AxisError, match="nothing to be uncertain about"):
        JOINT.given("goal", mood="calm")
    with pytest.raises(AxisError, match="'mood' is given here, not random"):
        JOINT.given("mood").given("mood")
    with pytest.raises(AxisError, match="at least one random axis"):
        JOINT.marginal()


# updating and predicting


@given(distributions(), st.data())
def test_a_posterior_sums_to_one_whatever_the_evidence_or_names_where_it_cannot(p, data):
    likelihood = data.draw(factors([*p.axes, Axis("moment", 2)]))
    if ((p * likelihood).sum(*p.random).log_values == -math.inf).any():
        with pytest.raises(ImpossibleEvidenceError, match=r"is possible at .*moment="):
            p.update(likelihood)
        return
    posterior = p.update(likelihood)
    check_normalisation(posterior)
    assert posterior.batch == (*p.batch, "moment")
    assert (posterior.random, posterior.conditions) == (p.random, p.conditions)


def test_impossible_evidence_names_the_cell_and_what_was_asked():
    likelihood = Factor.from_values([GOAL, TRIAL], [[1, 0], [1, 0], [1, 0]])
    with pytest.raises(ImpossibleEvidenceError, match="over goal is possible at trial=1"):
        P.update(likelihood)
    with pytest.raises(ImpossibleEvidenceError, match="over goal is possible: every"):
        P.update(Factor.from_mask([GOAL], [False] * 3))


def test_evidence_of_other_labels_is_refused():
    with pytest.raises(AxisError, match="only on the right 'jar'"):
        P.update(Factor([Axis("goal", ["cup", "bowl", "jar"])], np.zeros(3)))


def test_predicting_moves_one_axis_and_leaves_the_others():
    stay = Factor.from_values([MOOD, MOOD.rename("next_mood")], [[3, 1], [1, 1]]).normalize("next_mood")
    later = JOINT.predict(stay)
    assert later.random == ("goal", "mood")
    assert later.marginal("goal").allclose(JOINT.marginal("goal"))
    expected = JOINT.values @ np.array([[0.75, 0.25], [0.5, 0.5]])
    assert np.allclose(later.values, expected, atol=1e-15)


def test_predicting_keeps_batches_and_takes_on_conditions():
    now = Distribution.uniform(MOOD, TRIAL, batch=["trial"])
    table = np.ones((2, 3, 2))
    move = Factor.from_values([MOOD, GOAL, MOOD.rename("next_mood")], table).normalize("next_mood")
    later = now.predict(move)
    assert later.names == ("mood", "trial", "goal")
    assert (later.random, later.batch, later.conditions) == (("mood",), ("trial",), ("goal",))


def test_what_is_no_transition_is_refused_with_the_names_expected():
    with pytest.raises(AxisError, match="random in 'next_<axis>' and given '<axis>'"):
        P.predict(P.rename(goal="plan"))
    shorter = Axis("next_goal", ["cup", "bowl"])
    with pytest.raises(AxisError, match="must carry the same labels"):
        P.predict(Distribution.uniform(GOAL, shorter, given=["goal"]))


# summaries


@given(distributions())
def test_every_label_has_its_probability_and_together_they_have_one(p):
    name = p.random[0]
    axis = p.axis(name)
    singles = [np.asarray(p.prob(**{name: label})) for label in axis.labels]
    assert np.allclose(sum(singles), 1.0, atol=1e-12)
    assert np.allclose(p.prob(**{name: list(axis.labels)}), 1.0, atol=1e-12)
    assert np.allclose(singles, np.moveaxis(p.expect(np.eye(len(axis)), name), -1, 0), atol=1e-15)


@given(distributions())
def test_the_mode_is_nowhere_less_probable_than_another_label(p):
    mode = p.mode()
    assert tuple(mode) == p.random
    if p.random == p.names:
        assert p.restrict(**mode).log_values == p.log_values.max()
    else:
        rest = [axis for axis in p.axes if axis.name not in p.random]
        best = p.max(*p.random)
        for index in np.ndindex(*(len(axis) for axis in rest)):
            cell = {axis.name: axis.labels[i] for axis, i in zip(rest, index, strict=True)}
            labels = {name: found[index] for name, found in mode.items()}
            assert p.restrict(**cell, **labels) == best.restrict(**cell)


@given(distributions())
def test_entropies_are_scipys(p):
    over = tuple(p.names.index(name) for name in p.random)
    rest = [i for i in range(len(p.axes)) if i not in over]
    table = p.values.transpose([*over, *rest]).reshape(-1, *(p.shape[i] for i in rest))
    assert np.allclose(p.entropy(), scipy_entropy(table, axis=0), atol=1e-13)


@given(distributions([GOAL, TRIAL], batch=["trial"]), distributions([GOAL], batch=[]))
def test_divergences_are_scipys_and_never_negative(p, q):
    found = p.divergence(q)
    assert (found >= 0.0).all()
    # SciPy has only the probabilities, which underflow where their logs do not
    if (p.log_values[np.isfinite(p.log_values)] > -700).all() and (q.log_values > -700).all():
        assert np.allclose(found, rel_entr(p.values, q.values[:, None]).sum(axis=0), atol=1e-12)
    lacking = ((p.log_values > -math.inf) & (q.log_values[:, None] == -math.inf)).any(axis=0)
    assert np.array_equal(np.isinf(found), lacking)


def test_divergence_from_itself_is_zero_and_of_a_tiny_change_is_tiny_but_not_zero():
    near = P.update(Factor([GOAL], [1e-6, 0.0, 0.0]))
    assert P.divergence(P) == 0.0
    # to second order: half the variance of the change, here 1e-12 p (1 - p) / 2
    assert P.divergence(near) == pytest.approx(0.125e-12, rel=1e-3)
    with pytest.raises(AxisError, match="same random axes"):
        P.divergence(JOINT)


def test_expectations_of_functions_mappings_and_arrays_agree():
    rank = {"cup": 1.0, "bowl": 2.0, "mug": 4.0}
    expected = 0.5 + 0.5 + 1.0
    assert P.expect(rank) == expected
    assert P.expect(rank.get) == expected
    assert P.expect([1.0, 2.0, 4.0]) == expected
    assert JOINT.expect(lambda goal, mood: rank[goal] * (mood == "calm"), "goal", "mood") == pytest.approx(
        1.1
    )
    assert np.allclose(JOINT.given("mood").expect(rank, "goal"), [1.1 / 0.35, 1.4 / 0.65])


def test_the_expected_position_is_an_array():
    positions = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 8.0]])
    assert P.expect(positions).tolist() == [1.0, 2.0]
    batch = Distribution.uniform(GOAL, TRIAL, batch=["trial"])
    assert batch.expect(positions).shape == (2, 2)


def test_an_infinite_cost_counts_only_where_it_is_possible():
    certain = Distribution.from_probabilities([GOAL], [0.5, 0.5, 0.0])
    assert certain.expect([1.0, 3.0, math.inf]) == 2.0
    assert P.expect([1.0, 3.0, math.inf]) == math.inf
    assert P.expect([1.0, 3.0, -math.inf]) == -math.inf
    with pytest.raises(FactorError, match=r"\+inf at goal='mug' and -inf at goal='cup' are both possible"):
        P.expect([-math.inf, 1.0, math.inf])


def test_expectations_refuse_what_they_cannot_average():
    with pytest.raises(FactorError, match="no value for 'mug'"):
        P.expect({"cup": 1.0, "bowl": 2.0})
    with pytest.raises(FactorError, match="NaN at goal='bowl'"):
        P.expect([1.0, math.nan, 2.0])
    with pytest.raises(FactorError, match=r"shape \(2,\), but must lead with the axes \(goal 3\)"):
        P.expect([1.0, 2.0])
    with pytest.raises(AxisError, match="say which"):
        JOINT.expect([1.0, 2.0, 3.0])
    with pytest.raises(AxisError, match="one axis, not of 2"):
        JOINT.expect({}, "goal", "mood")


@pytest.mark.parametrize("shape", [(1,), (9,)])
def test_draws_have_the_frequencies_of_the_distribution(shape):
    trials = Axis("trial", shape[0])
    p = (
        Factor(JOINT.axes, JOINT.log_values)
        .align("goal", "mood", trials)
        .normalize("goal", "mood", batch=["trial"])
    )
    draws = p.sample(np.random.default_rng(3), 20_000 // shape[0])
    assert draws["goal"].shape == (20_000 // shape[0], *shape)
    counts = [[np.sum((draws["goal"] == g) & (draws["mood"] == m)) for m in MOOD.labels] for g in GOAL.labels]
    possible = JOINT.values > 0
    assert np.asarray(counts)[~possible].sum() == 0
    observed = np.asarray(counts)[possible]
    assert chisquare(observed, observed.sum() * JOINT.values[possible]).pvalue > 0.001


@given(distributions(), st.integers(0, 2**32))
def test_what_is_drawn_is_always_possible_and_the_same_seed_draws_the_same(p, seed):
    draws = p.sample(np.random.default_rng(seed), (2, 3))
    again = p.sample(np.random.default_rng(seed), (2, 3))
    rest = tuple(len(axis) for axis in p.axes if axis.name not in p.random)
    for name in p.random:
        assert draws[name].shape == (2, 3, *rest)
        assert np.array_equal(draws[name], again[name])
        axis = p.axis(name)
        possible = [
            label for label in axis.labels if np.any(p.restrict(**{name: label}).log_values > -math.inf)
        ]
        assert set(np.unique(draws[name]).tolist()) <= set(possible)


def test_a_single_draw_is_of_plain_labels():
    draw = Distribution.from_probabilities([GOAL, TRIAL], [[0, 0], [0, 1], [0, 0]]).sample(
        np.random.default_rng(0)
    )
    assert draw == {"goal": "bowl", "trial": 1}
    assert type(draw["trial"]) is int


@pytest.mark.parametrize("evidence", [[1.0, 2.0], np.ones(2), None])
def test_evidence_that_is_no_factor_is_refused_with_how_to_make_one(evidence):
    prior = Distribution.uniform(Axis("goal", ["cup", "bowl"]))
    with pytest.raises((FactorError, TypeError), match=r"Factor|type"):
        prior.update(evidence)
