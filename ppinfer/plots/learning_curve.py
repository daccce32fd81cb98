"""How good learned prediction is against the amount of data, with the model's line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import GOAL_COLOURS, INK, MUTED, quiet

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ppinfer.studies.learning import LearningRow

CALIBRATION = "expected_calibration_error"
PANELS = {
    "loss": "mean squared error",
    "mean_log_probability": "mean log probability [nat]",
    CALIBRATION: "expected calibration error",
}
_CURVES = {
    "learned": ("learned", GOAL_COLOURS[0], "o-"),
    "model fitted": ("model, weights fitted", GOAL_COLOURS[2], "s-"),
}
_LEVELS = {
    "model": ("model, default weights", GOAL_COLOURS[1], "--"),
    "even": ("even odds", MUTED, ":"),
}
# sizes of so many digits fit below a panel
_LABELS = 4


@draws_plain_text
def plot_learning_curve(rows: Sequence[LearningRow], *, axes: Sequence[Axes] | None = None) -> Axes:
    """Draw error, log probability and calibration of networks against the number of examples they were trained on.

    The model needs none, or few to fit its weights to; beyond those its line is drawn on, dotted.

    Parameters
    ----------
    rows
        From `ppinfer.studies.learning.study_learning`.
    axes
        Three to draw on; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        The first of the axes drawn on; its figure holds them all.

    Examples
    --------
    >>> from ppinfer.testing.prediction_examples import example_learning_rows
    >>> plot_learning_curve(example_learning_rows()).figure.savefig("learning.png")
    """
    from matplotlib.ticker import LogLocator

    if axes is None:
        from matplotlib.figure import Figure

        axes = Figure(figsize=(9.6, 3.4), layout="constrained").subplots(1, len(PANELS))
    sizes = sorted({row.examples for row in rows if row.prediction in _CURVES})
    most = max((row.examples for row in rows), default=1)
    for ax, (name, label) in zip(axes, PANELS.items(), strict=True):
        for prediction, (text, colour, marker) in _CURVES.items():
            found = [(row.examples, getattr(row.score, name)) for row in rows if row.prediction == prediction]
            if found and prediction != "learned":
                # more would change four numbers no more
                ax.plot([found[-1][0], most], [found[-1][1]] * 2, ":", color=colour, linewidth=1.4)
            ax.plot(
                *zip(*found, strict=True), marker, color=colour, linewidth=1.6, markersize=4.5, label=text
            )
        for prediction, (text, colour, dashes) in _LEVELS.items():
            # even odds are calibrated by their nature, and that says nothing
            if prediction == "even" and name == CALIBRATION:
                continue
            for row in rows:
                if row.prediction == prediction:
                    value = getattr(row.score, name)
                    ax.axhline(value, color=colour, linestyle=dashes, linewidth=1.4, label=text)
        ax.set_xscale("log")
        if sizes:
            # the sizes and nothing else: labels of a logarithmic axis collide where it has few decades
            shown = _apart(sizes)
            ax.set_xticks(shown, [f"{size:,}" for size in shown])
            ax.set_xticks(sizes, [""] * len(sizes), minor=True)
        if name != "mean_log_probability":
            ax.set_yscale("log")
            # less than two decades: powers of ten alone would be one label
            ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            ax.yaxis.set_major_formatter("{x:g}")
            ax.yaxis.set_minor_formatter("")
        ax.set_xlabel("examples to learn from")
        ax.set_ylabel(label)
        quiet(ax)
    handles, labels = axes[0].get_legend_handles_labels()
    axes[0].figure.legend(
        handles, labels, loc="outside lower center", ncols=4, frameon=False, fontsize="small", labelcolor=INK
    )
    return axes[0]


def _apart(sizes: list[int]) -> list[int]:
    """Return those that there is room for in a narrow panel, from the greatest down."""
    least = (math.log(sizes[-1]) - math.log(sizes[0])) / _LABELS
    shown: list[int] = []
    for size in reversed(sizes):
        if not shown or math.log(shown[-1] / size) >= least:
            shown.append(size)
    return shown[::-1]
