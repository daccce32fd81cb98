"""The algebra: axes, factors, distributions, ragged rows, and filtering and smoothing over time.

Everything is a non-negative function over a few named, labelled, finite axes. This package knows no game,
robot or file. Compiled kernels are imported when they are first used.
"""

from ppinfer.distributions.axis import Axis, Label
from ppinfer.distributions.distribution import Distribution
from ppinfer.distributions.factor import Factor
from ppinfer.distributions.filtering import forward_filter, smooth
from ppinfer.distributions.ragged import Ragged, expand, row_starts
from ppinfer.distributions.state_filtering import filter_states, smooth_states

__all__ = [
    "Axis",
    "Distribution",
    "Factor",
    "Label",
    "Ragged",
    "expand",
    "filter_states",
    "forward_filter",
    "row_starts",
    "smooth",
    "smooth_states",
]
