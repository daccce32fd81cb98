"""The laws of the algebra, one function each, to be called on one's own objects.

Each takes objects, returns nothing, and raises an `AssertionError` that names the law, the cell and both
numbers. They know no test runner; under Hypothesis they yield a shrunk counter-example. Where an operation of
one's own takes the place of the library's (``update=``, ``offline=``), it is that operation which is held to
the law.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from typing import TypeAlias

import numpy as np

from ppinfer.distributions import Axis, Distribution, Factor
from ppinfer.distributions.axis import Label
from ppinfer.testing.agreement import TOLERANCE, agree, at_cell, attempt, magnitude_of

Update: TypeAlias = Callable[[Distribution, Factor], Distribution]


def check_normalisation(distribution: Distribution, *, tolerance: float = 1e-12) -> None:
    """Check that a distribution sums to one over its random axes in every cell, and holds no NaN.

    Parameters
    ----------
    distribution : Distribution
        What is checked.
    tolerance : float
        How far from one a sum may be.

    Examples
    --------
    >>> check_normalisation(Distribution.uniform(Axis("goal", 3)))
    """
    axes = distribution.axes
    values = np.exp(distribution.log_values)
    for index in np.argwhere(~(distribution.log_values < math.inf)):
        raise AssertionError(
            f"normalisation: {distribution!r} holds {values[tuple(index)]} at {at_cell(axes, index)}"
        )
    over = tuple(i for i, axis in enumerate(axes) if axis.name in distribution.random)
    rest = [axis for axis in axes if axis.name not in distribution.random]
    sums = values.sum(axis=over)
    for index in np.argwhere(~(np.abs(sums - 1.0) <= tolerance)):
        cell = f" at {at_cell(rest, index)}" if rest else ""
        raise AssertionError(
            f"normalisation: {distribution!r} sums to {sums[tuple(index)]!r}{cell}, not 1 within {tolerance}"
        )


def check_order_of_evidence(
    prior: Distribution,
    likelihoods: Sequence[Factor],
    *,
    update: Update = Distribution.update,
    tolerance: float = TOLERANCE,
) -> None:
    """Check that updates commute, and that one update by the product equals them one by one.

    Evidence that is impossible must be so in every order.

    Parameters
    ----------
    prior : Distribution
        Before the evidence.
    likelihoods : sequence of Factor
        At least one.
    update : callable
        The operation that is checked.
    tolerance : float
        Relative to the largest log value.

    Examples
    --------
    >>> goal = Axis("goal", ["cup", "bowl"])
    >>> evidence = [Factor([goal], [-1e6, -1e6 - 1]), Factor([goal], [0.0, 1e-12])]
    >>> check_order_of_evidence(Distribution.uniform(goal), evidence)
    """

    def one_by_one(order: Sequence[Factor]) -> Distribution:
        posterior = prior
        for likelihood in order:
            posterior = update(posterior, likelihood)
        return posterior

    whole = likelihoods[0]
    for likelihood in likelihoods[1:]:
        whole = whole * likelihood
    magnitude = magnitude_of(prior, *likelihoods)
    answers = {
        "in the order given": attempt(lambda: one_by_one(likelihoods)),
        "in reverse": attempt(lambda: one_by_one(likelihoods[::-1])),
        "by the product": attempt(lambda: update(prior, whole)),
    }
    reference = answers.pop("by the product")
    for how, answer in answers.items():
        if (answer is None) != (reference is None):
            raise AssertionError(
                f"order of evidence: impossible {how if answer is None else 'by the product'} "
                f"but possible {'by the product' if answer is None else how}"
            )
        if answer is not None and reference is not None:
            agree(
                f"order of evidence: updates {how} (left) and by the product",
                answer,
                reference,
                magnitude,
                tolerance,
            )


def check_ignorance(
    prior: Distribution,
    *,
    constants: Sequence[float] = (-1e6, -1e-12, 0.0, 3.0),
    update: Update = Distribution.update,
    tolerance: float = TOLERANCE,
) -> None:
    """Check that a constant likelihood changes nothing.

    Parameters
    ----------
    prior : Distribution
        Before the evidence.
    constants : sequence of float
        Log likelihoods that do not depend on the hypothesis.
    update : callable
        The operation that is checked.
    tolerance : float
        Relative to the largest log value.

    Examples
    --------
    >>> check_ignorance(Distribution.uniform(Axis("goal", 3)))
    """
    axes = [axis for axis in prior.axes if axis.name in prior.random]
    for constant in constants:
        flat = Factor(axes, np.full([len(axis) for axis in axes], constant))
        agree(
            f"ignorance: the posterior after a constant log likelihood of {constant} (left) and the prior",
            update(prior, flat),
            prior,
            max(magnitude_of(prior), abs(constant)),
            tolerance,
        )


def check_chain_rule(joint: Distribution, *names: str, tolerance: float = TOLERANCE) -> None:
    """Check that the joint is the marginal times the conditional, as a whole and at a label.

    Parameters
    ----------
    joint : Distribution
        With at least one random axis that is not named.
    *names : str
        The random axes to condition on.
    tolerance : float
        Relative to the largest log value.

    Examples
    --------
    >>> check_chain_rule(Distribution.uniform(Axis("x", 2), Axis("y", 3)), "y")
    """
    magnitude = magnitude_of(joint)
    marginal = joint.marginal(*names)
    check_normalisation(marginal)
    summed = joint.sum(*(name for name in joint.random if name not in names))
    agree("chain rule: the marginal (left) and the sum of the joint", marginal, summed, magnitude, tolerance)
    conditional = attempt(lambda: joint.given(*names))
    if conditional is None:
        if not (marginal.log_values == -math.inf).any():
            raise AssertionError(
                "chain rule: the conditional is refused although every condition is possible"
            )
        return
    check_normalisation(conditional)
    agree(
        "chain rule: marginal times conditional (left) and the joint",
        marginal * conditional,
        joint,
        magnitude,
        tolerance,
    )
    labels = {name: joint.axis(name).labels[-1] for name in names}
    agree(
        f"chain rule: given({labels}) (left) and the conditional there",
        joint.given(**labels),
        conditional.given(**labels),
        magnitude,
        tolerance,
    )


def check_relabelling(
    operation: Callable[..., Factor],
    axis: str,
    labels: Sequence[Label],
    *factors: Factor,
    tolerance: float = TOLERANCE,
) -> None:
    """Check that permuting the labels of an axis permutes the answer and nothing else.

    Parameters
    ----------
    operation : callable
        From the factors to a factor.
    axis : str
        The axis whose labels are permuted.
    labels : sequence of labels
        All labels of that axis, in another order.
    *factors : Factor
        What the operation takes.
    tolerance : float
        Relative to the largest log value.

    Examples
    --------
    >>> goal = Axis("goal", ["cup", "bowl", "mug"])
    >>> likelihood = Factor.from_values([goal], [1.0, 2.0, 3.0])
    >>> check_relabelling(
    ...     Distribution.update, "goal", ["mug", "cup", "bowl"], Distribution.uniform(goal), likelihood
    ... )
    """
    answer = attempt(lambda: operation(*factors))
    relabelled = attempt(lambda: operation(*(_relabelled(factor, axis, labels) for factor in factors)))
    if answer is None or relabelled is None:
        if answer is not relabelled:
            raise AssertionError(f"relabelling: impossible in one order of the labels of {axis!r} only")
        return
    agree(
        f"relabelling: the answer for {axis!r} relabelled (left) and the answer, relabelled",
        relabelled,
        answer.restrict(**{axis: labels}),
        magnitude_of(*factors),
        tolerance,
    )


def check_batch_equals_loop(
    operation: Callable[..., Factor], axis: str, *factors: Factor, tolerance: float = TOLERANCE
) -> None:
    """Check that a batch axis gives what a Python loop over it gives.

    Parameters
    ----------
    operation : callable
        From the factors to a factor that still has the axis.
    axis : str
        The batch axis; at least one factor has it.
    *factors : Factor
        What the operation takes.
    tolerance : float
        Relative to the largest log value.

    Examples
    --------
    >>> goal, trial = Axis("goal", 2), Axis("trial", 3)
    >>> likelihood = Factor([goal, trial], [[0.0, -1.0, -2.0], [0.0, -1e6, 0.0]])
    >>> check_batch_equals_loop(Distribution.update, "trial", Distribution.uniform(goal), likelihood)
    """
    batch = next(f.axis(axis) for f in factors if axis in f.names)
    answer = attempt(lambda: operation(*factors))
    rows = [[_at_label(factor, axis, label) for factor in factors] for label in batch.labels]
    singles = [attempt(partial(operation, *row)) for row in rows]
    if answer is None:
        if all(single is not None for single in singles):
            raise AssertionError(f"batch = loop: refused as a batch over {axis!r}, but not in the loop")
        return
    for label, single in zip(batch.labels, singles, strict=True):
        if single is None:
            raise AssertionError(
                f"batch = loop: impossible at {axis}={label!r} in the loop, but not in the batch"
            )
        agree(
            f"batch = loop: the batch at {axis}={label!r} (left) and the loop",
            answer.restrict(**{axis: label}),
            single,
            magnitude_of(*factors),
            tolerance,
        )


def check_scale(axis: Axis, *, update: Update = Distribution.update) -> None:
    """Check that log likelihoods of -1e6 and of -1e-12 both survive, on top of any constant.

    Parameters
    ----------
    axis : Axis
        Hypotheses, at least two.
    update : callable
        The operation that is checked.

    Examples
    --------
    >>> check_scale(Axis("goal", ["cup", "bowl"]))
    """
    if len(axis) < 2:
        raise ValueError("check_scale needs an axis of at least two labels")
    prior = Distribution.uniform(axis)
    for step, constant in product((1e6, 1.0, 1e-12), (0.0, -1e6)):
        log_likelihood = constant - step * np.arange(float(len(axis)))
        # the differences that floating point can hold at this constant
        expected = log_likelihood[1:] - log_likelihood[0]
        log_p = update(prior, Factor([axis], log_likelihood)).align(axis).log_values
        with np.errstate(invalid="ignore"):
            found = log_p[1:] - log_p[0]
        allowed = 8 * np.finfo(float).eps * np.maximum(1.0 + math.log(len(axis)), np.abs(expected))
        wrong = ~(np.abs(found - expected) <= allowed)
        if wrong.any():
            label = int(np.argmax(wrong))
            raise AssertionError(
                f"scale: log likelihoods {constant} - {step} k of {axis.name!r}: the log odds of "
                f"{axis.labels[label + 1]!r} against {axis.labels[0]!r} are {float(found[label])!r}, "
                f"not {float(expected[label])!r}"
            )


def _relabelled(factor: Factor, axis: str, labels: Sequence[Label]) -> Factor:
    """Reorder the labels of a factor that has the axis, keeping a distribution one."""
    if axis not in factor.names:
        return factor
    picked = factor.restrict(**{axis: labels})
    if isinstance(factor, Distribution):
        return Distribution(picked.axes, picked.log_values, given=factor.conditions, batch=factor.batch)
    return picked


def _at_label(factor: Factor, axis: str, label: Label) -> Factor:
    """Pick one label of a factor that has the axis."""
    return factor.restrict(**{axis: label}) if axis in factor.names else factor
