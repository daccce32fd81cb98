"""Filtering and smoothing over time, of a state with named axes."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ppinfer.distributions.axis import Axis, cell_name
from ppinfer.distributions.distribution import Distribution
from ppinfer.distributions.factor import Factor
from ppinfer.distributions.filtering import forward_filter, smooth
from ppinfer.distributions.kinds import moving_axes
from ppinfer.distributions.layout import Kinds
from ppinfer.errors import AxisError


def filter_states(
    prior: Distribution, transition: Distribution | None, likelihood: Factor, *, time: str = "sample"
) -> Distribution:
    """Return the posterior of a state at each instant, given the evidence so far.

    The first instant multiplies the prior by its likelihood; before each later one the state moves
    (`predict`).

    Parameters
    ----------
    prior : Distribution
        Of the state: its random axes, together.
    transition : Distribution or None
        Random in ``next_goal`` and given ``goal`` for each axis ``goal`` of the state that changes; None if
        none does.
    likelihood : Factor
        Over `time` and axes of the state; other axes (trials) are independent copies.
    time : str
        The likelihood's axis that is time.

    Returns
    -------
    Distribution
        Over the state, with batch axes: the copies, then `time`.

    Raises
    ------
    AxisError
        If an axis is missing, carries other labels, or the prior or transition depends on time.
    ImpossibleEvidenceError
        If nothing is possible at an instant; the message names it.

    Examples
    --------
    >>> goal, sample = Axis("goal", ["cup", "bowl"]), Axis("sample", 2)
    >>> likelihood = Factor.from_values([sample, goal], [[0.8, 0.2], [0.8, 0.2]])
    >>> filter_states(Distribution.uniform(goal), None, likelihood).prob(goal="cup").round(4)
    array([0.8   , 0.9412])
    """
    return _over_time(forward_filter, prior, transition, likelihood, time)


def smooth_states(
    prior: Distribution, transition: Distribution | None, likelihood: Factor, *, time: str = "sample"
) -> Distribution:
    """Return the posterior of a state at each instant, given all the evidence, later evidence included.

    Parameters
    ----------
    prior, transition, likelihood, time
        As `filter_states` takes them.

    Examples
    --------
    >>> goal, sample = Axis("goal", ["cup", "bowl"]), Axis("sample", 2)
    >>> likelihood = Factor.from_values([sample, goal], [[0.5, 0.5], [0.8, 0.2]])
    >>> smooth_states(Distribution.uniform(goal), None, likelihood).prob(goal="cup").round(4)
    array([0.8, 0.8])
    """
    return _over_time(smooth, prior, transition, likelihood, time)


def _over_time(
    scan: Callable[..., np.ndarray],
    prior: Distribution,
    transition: Distribution | None,
    likelihood: Factor,
    time: str,
) -> Distribution:
    """Lay distributions out as rows for a scan, and its result as a distribution again."""
    instants = likelihood.axis(time)
    for name, factor in (("prior", prior), ("transition", transition)):
        if factor is not None and time in factor.names:
            raise AxisError(f"the {name} has the time axis {time!r}; only the likelihood may")
    state = [axis for axis in prior.axes if axis.name in prior.random]
    apart = {axis.name: axis for axis in prior.axes if axis.name not in prior.random}
    apart |= {axis.name: axis for axis in likelihood.axes if axis.name not in (time, *prior.random)} | apart
    matrices = None
    if transition is not None:
        moved = moving_axes(transition, prior)
        matrices = _matrices(transition, moved, state)
        inside = {axis.name for axis in state} | {f"next_{axis.name}" for axis in state}
        apart |= {axis.name: axis for axis in matrices.axes if axis.name not in inside} | apart
    copies, size = list(apart.values()), math.prod(len(axis) for axis in state)
    evidence = likelihood.align(*copies, instants, *state).log_values
    rows = math.prod(len(axis) for axis in copies)
    log_transition, which = None, None
    if matrices is not None:
        changing = [axis for axis in copies if axis.name in matrices.names]
        onto = copies if changing else []
        arrow = [*state, *(axis.rename(f"next_{axis.name}") for axis in state)]
        log_transition = matrices.align(*onto, *arrow).log_values.reshape(-1, size, size)
        which = np.arange(rows) if changing else np.zeros(rows, dtype=np.int64)
    cells = (*copies, instants)
    lengths = tuple(len(axis) for axis in cells)
    log_posterior = scan(
        evidence.reshape(-1, size),
        np.full(rows, len(instants)),
        prior.align(*copies, *state).log_values.reshape(rows, size),
        log_transition,
        which,
        describe=lambda sample: cell_name(cells, [int(i) for i in np.unravel_index(sample, lengths)]),
    )
    given = {*prior.conditions, *(transition.conditions if transition is not None else ())}
    kinds: Kinds = tuple("given" if axis.name in given else "batch" for axis in cells)
    axes = (*cells, *state)
    random: Kinds = tuple("random" for _ in state)
    shape = tuple(len(axis) for axis in axes)
    return Distribution._sound(axes, log_posterior.reshape(shape), kinds + random)


def _matrices(transition: Distribution, moved: list[str], state: list[Axis]) -> Factor:
    """Return the transition of the whole state: axes that do not move stay where they are."""
    whole: Factor = Factor(transition.axes, transition.log_values)
    for axis in state:
        if axis.name not in moved:
            still = np.eye(len(axis), dtype=np.bool_)
            whole = whole * Factor.from_mask([axis, axis.rename(f"next_{axis.name}")], still)
    return whole
