"""One function a picture, each returning Matplotlib axes; no picture is kept in any global state."""

from ppinfer.plots.over_time import plot_posterior_over_time
from ppinfer.plots.participants import plot_participants
from ppinfer.plots.path import plot_path
from ppinfer.plots.reliability import plot_reliability
from ppinfer.plots.score_curves import plot_score_over_share

__all__ = [
    "plot_participants",
    "plot_path",
    "plot_posterior_over_time",
    "plot_reliability",
    "plot_score_over_share",
]
