"""The laws of the algebra, on 1 to 4 axes with batches, extreme weights, zeros and permuted labels."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppinfer import Axis, Distribution, Factor
from ppinfer.testing import (
    axes,
    axis_sets,
    check_batch_equals_loop,
    check_chain_rule,
    check_ignorance,
    check_normalisation,
    check_order_of_evidence,
    check_relabelling,
    check_scale,
    distributions,
    factors,
    relabellings,
    transitions,
)


@st.composite
def likelihoods(draw, p):
    """Evidence about some axes of a distribution, perhaps with an axis of its own."""
    some = [axis for axis in p.axes if draw(st.booleans())]
    if draw(st.booleans()):
        some.append(Axis("moment", 2))
    return draw(factors(some))


@given(distributions(), st.data())
def test_every_way_to_make_a_distribution_is_normalised(p, data):
    check_normalisation(p)
    for name in p.random:
        check_normalisation(p.marginal(name))
    transition = data.draw(transitions(p.axis(p.random[0])))
    check_normalisation(p.predict(transition))


@given(st.data(), distributions())
def test_the_order_of_evidence_does_not_matter(data, p):
    count = data.draw(st.integers(1, 4))
    check_order_of_evidence(p, [data.draw(likelihoods(p)) for _ in range(count)])


@given(distributions())
def test_a_constant_likelihood_changes_nothing(p):
    check_ignorance(p)


@given(axis_sets(min_axes=2), st.data())
def test_the_joint_is_the_marginal_times_the_conditional(some, data):
    kinds = data.draw(st.sampled_from([[], [some[-1].name] if len(some) > 2 else []]))
    joint = data.draw(distributions(some, batch=kinds))
    names = data.draw(st.sets(st.sampled_from(joint.random), min_size=1, max_size=len(joint.random) - 1))
    check_chain_rule(joint, *sorted(names))


@given(distributions(), st.data())
def test_permuted_labels_permute_the_posterior_and_nothing_else(p, data):
    axis = data.draw(st.sampled_from(p.axes))
    labels = data.draw(relabellings(axis))
    check_relabelling(Distribution.update, axis.name, labels, p, data.draw(likelihoods(p)))


@given(distributions(zeros=False), st.data())
def test_permuted_labels_permute_marginals_and_conditionals(p, data):
    axis = data.draw(st.sampled_from(p.axes))
    labels = data.draw(relabellings(axis))
    check_relabelling(lambda q: q.marginal(q.random[0]), p.random[0], data.draw(relabellings(p.axes[0])), p)
    if len(p.random) > 1:
        check_relabelling(lambda q: q.given(q.random[1]), axis.name, labels, p)


@given(distributions(), st.data())
def test_a_batch_is_what_a_loop_gives(p, data):
    likelihood = data.draw(factors([*p.axes, Axis("moment", 3)]))
    check_batch_equals_loop(Distribution.update, "moment", p, likelihood)
    for name in p.batch:
        check_batch_equals_loop(Distribution.update, name, p, data.draw(likelihoods(p)))
        check_batch_equals_loop(lambda q: q.marginal(q.random[0]), name, p)


@given(axes(min_size=2))
def test_log_likelihoods_of_every_scale_survive(axis):
    check_scale(axis)


@given(factors(zeros=False), st.sampled_from([-1e6, 1e6, -1e-12]))
def test_normalising_does_not_depend_on_the_scale(f, constant):
    shifted = Factor(f.axes, f.log_values + constant)
    exact = Factor(f.axes, shifted.log_values - constant)  # what rounding leaves of the differences
    normal = shifted.normalize(*f.names)
    check_normalisation(normal)
    assert normal.allclose(exact.normalize(*f.names), atol=1e-9)


def test_a_million_labels_normalise_to_the_last_digits():
    f = Factor([Axis("sample", 10**6)], -np.linspace(0, 50, 10**6) - 1e6)
    p = f.normalize("sample")
    check_normalisation(p)
    assert abs(math.fsum(p.values) - 1.0) < 1e-12
