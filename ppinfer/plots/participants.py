"""How scores differ between participants."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import FAINT, GOAL_COLOURS, INK, MUTED, new_axes, quiet
from ppinfer.plots.score_curves import SCORE_LABELS, ScoreField

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ppinfer.studies.scores import ParticipantScore

MAX_NAMED = 40


@draws_plain_text
def plot_participants(
    scores: Sequence[ParticipantScore], field: ScoreField = "accuracy", *, ax: Axes | None = None
) -> Axes:
    """Draw one dot a participant, sorted, with two standard errors over their segments.

    Parameters
    ----------
    scores
        Scores of participants after one share (`ppinfer.studies.scores.Scores.by_participant`).
    field
        ``"accuracy"`` or ``"mean_log_posterior"``.
    ax
        Where to draw; a new figure by default, as tall as the participants need. Past 40 participants they
        are not named.

    Returns
    -------
    matplotlib.axes.Axes
        The axes drawn on.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR
    >>> from ppinfer.studies import infer_log, score_posterior
    >>> from ppinfer.testing import example_log
    >>> scores = score_posterior(infer_log(example_log(), GoalLQR()), at=[0.5])
    >>> ax = plot_participants(scores.by_participant)
    >>> ax.figure.savefig("participants.png")
    """
    ranked = sorted(scores, key=lambda each: (getattr(each, field), each.participant))
    if ax is None:
        ax = new_axes(4.6, min(9.0, 1.2 + 0.2 * min(len(ranked), MAX_NAMED)))
    value = np.array([getattr(each, field) for each in ranked])
    error = 2 * np.nan_to_num(np.array([getattr(each, f"{field}_se") for each in ranked]))
    height = np.arange(len(ranked))
    finite = np.isfinite(value)
    low, high = value - error, value + error
    if field == "accuracy":
        low, high = np.clip(low, 0, 1), np.clip(high, 0, 1)
    else:
        high = np.minimum(high, 0)
    ax.hlines(height[finite], low[finite], high[finite], color=GOAL_COLOURS[0], alpha=0.35, linewidth=2)
    ax.plot(value[finite], height[finite], "o", color=GOAL_COLOURS[0], markersize=4.5)
    for row in height[~finite]:
        ax.annotate(
            "-inf", (0.01, row), xycoords=("axes fraction", "data"), va="center", color=INK, fontsize="small"
        )
    if finite.any():
        ax.axvline(float(value[finite].mean()), color=MUTED, linewidth=1, linestyle="--")
    if len(ranked) <= MAX_NAMED:
        names = [f"{each.participant}  ({each.segments})" for each in ranked]
        for label in ax.set_yticks(height, names):
            label.label1.set_parse_math(False)
        ax.set_ylabel("participant (segments)")
    else:
        ax.set_yticks([])
        ax.set_ylabel(f"{len(ranked)} participants, sorted")
    ax.set_ylim(-0.7, len(ranked) - 0.3)
    if field == "accuracy":
        ax.set_xlim(0, 1.02)
    ax.set_xlabel(SCORE_LABELS[field])
    ax.grid(axis="x", color=FAINT, linewidth=0.5)
    ax.set_axisbelow(True)
    quiet(ax)
    return ax
