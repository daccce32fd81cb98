"""The calibration curve."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import FAINT, GOAL_COLOURS, INK, MUTED, new_axes, quiet

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ppinfer.studies.calibration import Reliability


@draws_plain_text
def plot_reliability(
    reliability: Reliability, *, prediction: str = "the most probable goal", ax: Axes | None = None
) -> Axes:
    """Draw how often predictions came true against their probability, with the band over participants.

    Grey bars at the bottom are the share of predictions in each bin (full height = all). On the diagonal
    probabilities mean what they say; below it they overstate.

    Parameters
    ----------
    reliability
        From `ppinfer.studies.calibration.calibrate_posterior`.
    prediction
        What the probabilities are of, for the axis.
    ax
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes drawn on.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR
    >>> from ppinfer.studies import calibrate_posterior, infer_log
    >>> from ppinfer.testing import example_log
    >>> ax = plot_reliability(calibrate_posterior(infer_log(example_log(), GoalLQR())).top_label)
    >>> ax.figure.savefig("reliability.png")
    """
    ax = ax if ax is not None else new_axes(4.2, 4)
    edges = reliability.edges
    ax.bar(
        edges[:-1],
        reliability.weight,
        width=np.diff(edges),
        align="edge",
        color=FAINT,
        edgecolor="white",
        linewidth=0.8,
        label="share of predictions",
    )
    ax.plot([0, 1], [0, 1], color=MUTED, linewidth=1, linestyle="--", label="as it says")
    used = reliability.weight > 0
    if np.isfinite(reliability.low[used]).any():
        below = reliability.observed[used] - reliability.low[used]
        above = reliability.high[used] - reliability.observed[used]
        ax.errorbar(
            reliability.predicted[used],
            reliability.observed[used],
            # rounding may put an end of the band on the wrong side of its point
            yerr=np.maximum(np.nan_to_num([below, above]), 0),
            fmt="none",
            ecolor=GOAL_COLOURS[0],
            elinewidth=1,
            capsize=2.5,
            alpha=0.6,
        )
    ax.plot(
        reliability.predicted[used],
        reliability.observed[used],
        "o-",
        color=GOAL_COLOURS[0],
        linewidth=1.6,
        markersize=4.5,
        label="observed (95 % band)",
    )
    ax.text(
        0.03,
        0.97,
        f"expected calibration error {reliability.expected_calibration_error:.3f}",
        transform=ax.transAxes,
        va="top",
        fontsize="small",
        color=INK,
    )
    ax.set_xlim(0, 1)
    ax.set_ylim(0, 1.02)
    ax.set_xlabel(f"probability of {prediction}")
    ax.set_ylabel("how often it is true")
    ax.legend(loc="upper left", bbox_to_anchor=(0.0, 0.92), frameon=False, fontsize="small")
    quiet(ax)
    return ax
