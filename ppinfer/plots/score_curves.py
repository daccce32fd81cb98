"""Accuracy and log score against the share of the path seen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import GOAL_COLOURS, INK, MUTED, new_axes, quiet

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ppinfer.studies.scores import Score

ScoreField = Literal["accuracy", "mean_log_posterior"]
SCORE_LABELS: dict[str, str] = {
    "accuracy": "accuracy of the goal",
    "mean_log_posterior": "mean log posterior of the true goal [nat]",
}


@draws_plain_text
def plot_score_over_share(
    scores: Sequence[Score],
    field: ScoreField = "accuracy",
    *,
    chance: float | None = None,
    label: str | None = None,
    colour: str = GOAL_COLOURS[0],
    ax: Axes | None = None,
) -> Axes:
    """Draw a score against the share of each segment seen, with one standard error over participants.

    Parameters
    ----------
    scores
        Scores after many shares (`ppinfer.studies.scores.Scores.overall`).
    field
        ``"accuracy"`` or ``"mean_log_posterior"``.
    chance
        Where guessing would be, drawn as a dashed line.
    label, colour
        The curve's name in a legend, where several share axes, and its colour.
    ax
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes drawn on.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR
    >>> from ppinfer.studies import infer_log, score_posterior
    >>> from ppinfer.testing import example_log
    >>> scores = score_posterior(infer_log(example_log(), GoalLQR()), at=[0.25, 0.5, 0.75])
    >>> ax = plot_score_over_share(scores.overall, chance=1 / 3)
    >>> ax.figure.savefig("accuracy.png")
    """
    ax = ax if ax is not None else new_axes(4.2, 3.2)
    share = 100 * np.array([score.at for score in scores])
    mean = np.array([getattr(score, field) for score in scores])
    error = np.array([getattr(score, f"{field}_se") for score in scores])
    finite = np.isfinite(mean)
    ax.fill_between(
        share[finite], (mean - error)[finite], (mean + error)[finite], color=colour, alpha=0.18, linewidth=0
    )
    ax.plot(share[finite], mean[finite], "-o", color=colour, linewidth=1.8, markersize=3.5, label=label)
    if not finite.all():
        count = int((~finite).sum())
        ax.text(
            0.03,
            0.03,
            f"{count} shares at -inf are not drawn",
            transform=ax.transAxes,
            color=INK,
            fontsize="small",
        )
    if chance is not None:
        ax.axhline(chance, color=MUTED, linewidth=1, linestyle="--")
        ax.annotate(
            "guessing",
            (100, chance),
            ha="right",
            va="bottom",
            color=MUTED,
            fontsize="small",
            xytext=(0, 2),
            textcoords="offset points",
        )
    ax.set_xlim(0, 102)
    if field == "accuracy":
        ax.set_ylim(0, 1.03)
    else:
        ax.set_ylim(top=0.0)
    ax.set_xlabel("share of the segment seen [%]")
    ax.set_ylabel(SCORE_LABELS[field])
    quiet(ax)
    return ax
