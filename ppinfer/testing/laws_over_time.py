"""The laws of filtering and smoothing over time, one function each; see `ppinfer.testing.laws`."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from itertools import product
from typing import TypeAlias

import numpy as np

from ppinfer.distributions import Distribution, Factor, filter_states, smooth_states
from ppinfer.testing.agreement import TOLERANCE, agree, attempt, magnitude_of

Offline: TypeAlias = Callable[..., Distribution]


def check_online_equals_offline(
    prior: Distribution,
    transition: Distribution | None,
    likelihood: Factor,
    *,
    time: str = "sample",
    offline: Offline = filter_states,
    tolerance: float = TOLERANCE,
) -> None:
    """Check that filtering step by step, as a robot would, equals the offline posterior.

    Parameters
    ----------
    prior, transition, likelihood, time
        As `ppinfer.distributions.filter_states` takes them.
    offline : callable
        The filter that is checked, called like `filter_states`.
    tolerance : float
        Relative to the largest log value that went in.

    Examples
    --------
    >>> from ppinfer import Axis
    >>> goal, sample = Axis("goal", 2), Axis("sample", 3)
    >>> likelihood = Factor([sample, goal], [[0.0, -1.0], [-2.0, 0.0], [-1e6, 0.0]])
    >>> check_online_equals_offline(Distribution.uniform(goal), None, likelihood)
    """
    whole = attempt(lambda: offline(prior, transition, likelihood, time=time))
    magnitude = magnitude_of(prior, likelihood) * len(likelihood.axis(time))
    state: Distribution | None = prior
    for step, label in enumerate(likelihood.axis(time).labels):
        arrow = transition if step else None
        state = attempt(partial(_step, state, arrow, likelihood.restrict(**{time: label})))
        if state is None:
            break
        if whole is None:
            continue
        agree(
            f"online = offline: offline at {time}={label!r} (left) and online",
            whole.given(**{time: label}),
            state,
            magnitude,
            tolerance,
        )
    if (state is None) != (whole is None):
        one, other = ("online", "offline") if state is None else ("offline", "online")
        raise AssertionError(f"online = offline: the evidence is impossible {one} but possible {other}")


def check_smoother(
    prior: Distribution,
    transition: Distribution,
    likelihood: Factor,
    *,
    time: str = "sample",
    offline: Offline = smooth_states,
    tolerance: float = TOLERANCE,
) -> None:
    """Check the smoothed posterior against the sum over every path of the state, one by one.

    Parameters
    ----------
    prior : Distribution
        Over one axis, without batches.
    transition, likelihood, time
        As `ppinfer.distributions.smooth_states` takes them; keep labels ** instants below 1e5.
    offline : callable
        The smoother that is checked, called like `smooth_states`.
    tolerance : float
        Relative to the largest log value that went in.

    Examples
    --------
    >>> from ppinfer import Axis
    >>> goal, sample = Axis("goal", 2), Axis("sample", 3)
    >>> stay = Factor.from_values([goal, goal.rename("next_goal")], [[9, 1], [1, 9]]).normalize("next_goal")
    >>> likelihood = Factor([sample, goal], [[0.0, -1.0], [-2.0, 0.0], [-1e6, 0.0]])
    >>> check_smoother(Distribution.uniform(goal), stay, likelihood)
    """
    (axis,), instants = prior.axes, likelihood.axis(time)
    if len(axis) ** len(instants) > 100_000:
        raise ValueError(f"{len(axis)} ** {len(instants)} paths are too many to sum over one by one")
    log_l = likelihood.align(time, axis.name).log_values
    log_t = transition.align(axis.name, f"next_{axis.name}").log_values
    paths = np.array(list(product(range(len(axis)), repeat=len(instants))))
    weights = prior.log_values[paths[:, 0]] + log_l[np.arange(len(instants)), paths].sum(axis=1)
    weights = weights + log_t[paths[:, :-1], paths[:, 1:]].sum(axis=1)
    answer = attempt(lambda: offline(prior, transition, likelihood, time=time))
    if weights.max() == -math.inf or answer is None:
        if answer is not None or weights.max() > -math.inf:
            raise AssertionError("smoother: refused though a path is possible, or not refused though none is")
        return
    table = np.full((len(instants), len(axis)), -math.inf)
    for t, k in product(range(len(instants)), range(len(axis))):
        table[t, k] = np.logaddexp.reduce(weights[paths[:, t] == k] - weights.max(), initial=-math.inf)
    agree(
        "smoother: smoothed (left) and the sum over all paths",
        answer,
        Factor([instants, axis], table).normalize(axis.name),
        magnitude_of(prior, likelihood, transition) * len(instants),
        tolerance,
    )


def _step(state: Distribution | None, transition: Distribution | None, likelihood: Factor) -> Distribution:
    assert state is not None
    return (state if transition is None else state.predict(transition)).update(likelihood)
