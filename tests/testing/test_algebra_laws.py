"""Every law catches an algebra that breaks it, and says where."""

import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings

from ppinfer import Axis, Distribution, Factor, ImpossibleEvidenceError
from ppinfer.distributions import filter_states, forward_filter, smooth_states
from ppinfer.testing import (
    check_batch_equals_loop,
    check_chain_rule,
    check_ignorance,
    check_normalisation,
    check_online_equals_offline,
    check_order_of_evidence,
    check_relabelling,
    check_scale,
    check_smoother,
    factors,
)

GOAL = Axis("goal", ["cup", "bowl", "mug"])
SAMPLE = Axis("sample", 3)
PRIOR = Distribution.from_probabilities([GOAL], [0.5, 0.3, 0.2])
EVIDENCE = [Factor.from_values([GOAL], row) for row in ([0.9, 0.2, 0.1], [0.1, 0.8, 0.1], [0.3, 0.3, 0.4])]
MOVES = [[0.8, 0.2, 0.0], [0.1, 0.6, 0.3], [0.3, 0.3, 0.4]]
MOVE = Distribution.from_probabilities([GOAL, GOAL.rename("next_goal")], MOVES, given=["goal"])
OVER_TIME = Factor.from_values([SAMPLE, GOAL], [[0.9, 0.2, 0.1], [0.1, 0.8, 0.1], [0.3, 0.3, 0.4]])


def unchecked(axes, log_values, like=None):
    """A distribution that may not sum to one, as a broken algebra would make it."""
    kinds = ("random",) * len(axes) if like is None else like._kinds
    return Distribution._sound(tuple(axes), np.array(log_values, dtype=float), kinds)


def with_an_epsilon(prior, likelihood):
    return Factor.from_values(prior.axes, prior.values * likelihood.values + 1e-9).normalize(*prior.random)


def with_forgetting(prior, likelihood):
    return (prior**0.9 * likelihood).normalize(*prior.random)


def in_linear_space(prior, likelihood):
    values = prior.values * likelihood.align(*prior.names).values
    if not values.sum() > 0:
        raise ImpossibleEvidenceError("underflow")
    return Factor.from_values(prior.axes, values / values.sum()).normalize(*prior.random)


def without_normalising(prior, likelihood):
    product = prior * likelihood
    return unchecked(product.axes, product.log_values)


def clipped(prior, likelihood):
    return (prior * Factor(likelihood.axes, np.maximum(likelihood.log_values, -700.0))).normalize(
        *prior.random
    )


def that_rounds(prior, likelihood):
    return prior.update(Factor(likelihood.axes, np.round(likelihood.log_values, 6)))


def that_favours_the_first_label(prior, likelihood):
    bonus = Factor([prior.axes[0]], -0.1 * np.arange(len(prior.axes[0])))
    return prior.update(likelihood * bonus)


def that_normalises_over_the_batch_too(prior, likelihood):
    product = prior * likelihood
    return Factor(product.axes, product.normalize(*product.names).log_values)


def test_the_sound_algebra_keeps_every_law():
    check_normalisation(PRIOR)
    check_order_of_evidence(PRIOR, EVIDENCE)
    check_ignorance(PRIOR)
    check_chain_rule(PRIOR * MOVE, "goal")
    check_relabelling(Distribution.update, "goal", ["mug", "cup", "bowl"], PRIOR, EVIDENCE[0])
    check_batch_equals_loop(Distribution.update, "sample", PRIOR, OVER_TIME)
    check_scale(GOAL)
    check_online_equals_offline(PRIOR, MOVE, OVER_TIME)
    check_smoother(PRIOR, MOVE, OVER_TIME)


def test_a_sum_other_than_one_is_caught_by_cell():
    with pytest.raises(AssertionError, match=r"normalisation: .* sums to .*0\.98"):
        check_normalisation(without_normalising(PRIOR, Factor.from_values([GOAL], [0.98] * 3)))
    batch = Distribution.uniform(GOAL, SAMPLE, batch=["sample"])
    off = batch.log_values.copy()
    off[:, 2] += 1e-11
    with pytest.raises(AssertionError, match="at sample=2, not 1 within 1e-12"):
        check_normalisation(unchecked(batch.axes, off, like=batch))


def test_a_nan_is_caught_by_cell():
    with pytest.raises(AssertionError, match="holds nan at goal='bowl'"):
        check_normalisation(unchecked([GOAL], [0.0, math.nan, -math.inf]))


@pytest.mark.parametrize("update", [with_an_epsilon, with_forgetting])
def test_evidence_whose_order_matters_is_caught(update):
    with pytest.raises(AssertionError, match=r"order of evidence: updates in .* differ at goal='cup'"):
        check_order_of_evidence(PRIOR, EVIDENCE, update=update)


def test_contradictions_that_depend_on_the_order_are_caught():
    cup, bowl = (Factor.from_mask([GOAL], mask) for mask in ([True, False, False], [False, True, False]))

    def once_bitten(prior, likelihood):
        """Refuse evidence that is zero from the start; quietly reset where it contradicts the past."""
        try:
            return prior.update(likelihood)
        except ImpossibleEvidenceError:
            if (likelihood.log_values == -math.inf).all():
                raise
            return PRIOR

    with pytest.raises(AssertionError, match="impossible by the product but possible in the order given"):
        check_order_of_evidence(PRIOR, [cup, bowl], update=once_bitten)


@pytest.mark.parametrize(
    "update", [with_an_epsilon, with_forgetting, in_linear_space, that_favours_the_first_label]
)
def test_ignorance_that_teaches_something_is_caught(update):
    with pytest.raises((AssertionError, ImpossibleEvidenceError), match=r"ignorance: .*constant|underflow"):
        check_ignorance(PRIOR, update=update)


@pytest.mark.parametrize("update", [with_an_epsilon, clipped, that_rounds])
def test_scales_that_are_lost_are_caught_with_both_numbers(update):
    with pytest.raises(
        AssertionError, match=r"scale: log likelihoods .* of 'goal': the log odds of 'bowl' against 'cup'"
    ):
        check_scale(GOAL, update=update)


def test_underflow_is_caught():
    with pytest.raises((AssertionError, ImpossibleEvidenceError)):
        check_scale(GOAL, update=in_linear_space)


class TheWrongMarginal(Distribution):
    """Takes the largest instead of the sum."""

    __slots__ = ()

    def marginal(self, *keep):
        return self.max(*(name for name in self.random if name not in keep)).normalize(*keep)


class TheWrongConditional(Distribution):
    """Conditions without normalising anew."""

    __slots__ = ()

    def given(self, *names, **labels):
        kinds = tuple(
            "given" if name in names else kind for name, kind in zip(self.names, self._kinds, strict=True)
        )
        return Distribution._sound(self.axes, self.log_values.copy(), kinds)


class TheTimidConditional(Distribution):
    """Refuses conditions that are possible."""

    __slots__ = ()

    def given(self, *names, **labels):
        raise ImpossibleEvidenceError("no")


@pytest.mark.parametrize(
    ("broken", "says"),
    [
        (
            TheWrongMarginal,
            r"chain rule: the marginal \(left\) and the sum of the joint differ at goal='cup'",
        ),
        (TheWrongConditional, "normalisation"),
        (TheTimidConditional, "chain rule: the conditional is refused although"),
    ],
)
def test_marginals_and_conditionals_that_disagree_with_the_joint_are_caught(broken, says):
    joint = PRIOR * MOVE
    with pytest.raises(AssertionError, match=says):
        check_chain_rule(broken(joint.axes, joint.log_values), "goal")


def test_an_answer_that_depends_on_the_order_of_labels_is_caught():
    with pytest.raises(AssertionError, match="relabelling: the answer for 'goal' relabelled"):
        check_relabelling(that_favours_the_first_label, "goal", ["mug", "cup", "bowl"], PRIOR, EVIDENCE[0])


def test_a_batch_that_leaks_into_itself_is_caught_at_its_label():
    with pytest.raises(
        AssertionError, match=r"batch = loop: the batch at sample=0 \(left\) and the loop differ"
    ):
        check_batch_equals_loop(that_normalises_over_the_batch_too, "sample", PRIOR, OVER_TIME)


def offline(log_transition=None, prior=None, scan=forward_filter):
    """A filter over one axis with its parts exchanged for broken ones."""

    def states(p, transition, likelihood, *, time):
        log_t = transition.align("goal", "next_goal").log_values[None]
        log_p = scan(
            likelihood.align(time, "goal").log_values,
            [len(likelihood.axis(time))],
            (p if prior is None else prior(p)).log_values[None],
            log_t if log_transition is None else log_transition(log_t),
        )
        return Distribution([likelihood.axis(time), p.axis("goal")], log_p, batch=[time])

    return states


def transposed(log_t):
    turned = np.exp(log_t).transpose(0, 2, 1)
    with np.errstate(divide="ignore"):
        return np.log(turned / turned.sum(axis=2, keepdims=True))


def backwards(*arguments):
    return forward_filter(arguments[0][::-1], *arguments[1:])[::-1]


def forgetful(log_likelihood, row_size, log_prior, log_transition):
    return forward_filter(
        log_likelihood, [1] * len(log_likelihood), np.repeat(log_prior, len(log_likelihood), axis=0)
    )


@pytest.mark.parametrize(
    "broken",
    [
        offline(log_transition=transposed),
        offline(log_transition=lambda log_t: None),
        offline(prior=lambda p: p.predict(MOVE)),
        offline(scan=backwards),
        offline(scan=forgetful),
        smooth_states,
    ],
    ids=[
        "transposed",
        "no transition",
        "moves before the first sample",
        "backwards",
        "forgetful",
        "a smoother",
    ],
)
def test_filters_that_are_not_the_steps_one_by_one_are_caught(broken):
    with pytest.raises(AssertionError, match="online = offline: offline at sample="):
        check_online_equals_offline(PRIOR, MOVE, OVER_TIME, offline=broken)


@pytest.mark.parametrize(
    "broken", [filter_states, offline(log_transition=transposed)], ids=["a filter", "transposed"]
)
def test_smoothers_that_are_not_the_sum_over_paths_are_caught(broken):
    with pytest.raises(AssertionError, match="smoother: smoothed"):
        check_smoother(PRIOR, MOVE, OVER_TIME, offline=broken)


def test_a_filter_that_swallows_a_contradiction_is_caught():
    contradiction = Factor.from_values([SAMPLE, GOAL], [[1, 0, 0], [0, 1, 0], [1, 1, 1]])

    def unmoved(prior, transition, likelihood, *, time):
        return Distribution.uniform(likelihood.axis(time), GOAL, batch=[time])

    with pytest.raises(AssertionError, match="online = offline"):
        check_online_equals_offline(Distribution.uniform(GOAL), None, contradiction, offline=unmoved)


def test_a_counter_example_is_shrunk_to_its_simplest():
    @settings(print_blob=False)
    @given(factors([Axis("goal", 2)], zeros=False), factors([Axis("goal", 2)], zeros=False))
    def holds(one, other):
        check_order_of_evidence(Distribution.uniform(Axis("goal", 2)), [one, other], update=with_forgetting)

    with pytest.raises(AssertionError, match="order of evidence") as error:
        holds()
    assert any("one=" in note for note in error.value.__notes__)


def test_laws_come_without_hypothesis_and_strategies_say_what_to_install():
    code = """
import sys
sys.modules["hypothesis"] = None
import ppinfer.testing
ppinfer.testing.check_scale
try:
    ppinfer.testing.axes
except ImportError as error:
    print(error)
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "pip install 'ppinfer[test]'" in run.stdout


def test_a_law_on_too_many_paths_or_too_few_labels_is_refused():
    with pytest.raises(ValueError, match="too many"):
        check_smoother(PRIOR, MOVE, Factor([Axis("sample", 30), GOAL], np.zeros((30, 3))))
    with pytest.raises(ValueError, match="at least two"):
        check_scale(Axis("goal", 1))


def test_what_the_testing_package_lists_it_has():
    import ppinfer.testing

    assert all(hasattr(ppinfer.testing, name) for name in ppinfer.testing.__all__)
    with pytest.raises(AttributeError, match="no attribute 'check_nothing'"):
        ppinfer.testing.check_nothing  # noqa: B018
