"""The figures of a report, as PNG bytes with their captions."""

from __future__ import annotations

import io
import warnings
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import xarray as xr

from ppinfer.plots.labels import as_plain_text
from ppinfer.plots.over_time import draw_posterior_over_time
from ppinfer.plots.participants import MAX_NAMED, plot_participants
from ppinfer.plots.path import draw_path
from ppinfer.plots.reliability import plot_reliability
from ppinfer.plots.score_curves import plot_score_over_share
from ppinfer.plots.trial_data import read_trial
from ppinfer.studies.calibration import Calibration
from ppinfer.studies.scores import ParticipantScore, Score

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DPI = 160
_PIXELS_AN_INCH = 106
_PAGE_WIDTH = 972


@dataclass(frozen=True)
class ReportFigure:
    """One figure: file name, PNG bytes, what it shows (for those who cannot see it) and how to read it."""

    name: str
    png: bytes
    title: str
    caption: str

    @property
    def data_uri(self) -> str:
        """The picture as text that a page can hold."""
        return f"data:image/png;base64,{b64encode(self.png).decode()}"

    @property
    def shown_width(self) -> int:
        """How wide a page shows it at most, in pixels: letters of all figures are of one size."""
        # a PNG begins with its width
        width = int.from_bytes(self.png[16:20], "big") or _PAGE_WIDTH * _DPI // _PIXELS_AN_INCH
        return width * _PIXELS_AN_INCH // _DPI


def trial_figure(posterior: xr.Dataset, trial: int, *, number: int, why: str) -> ReportFigure:
    """Draw the posterior of one trial over time beside its path."""
    data = read_trial(posterior, trial)
    planar = data.position.shape[1] >= 2
    figure = new_figure(10.4, 3.9) if planar else new_figure(7.2, 3.6)
    if planar:
        left, right = figure.subplots(1, 2, width_ratios=[1.75, 1])
        draw_path(data, space=tuple(map(str, posterior["space"].values)), ax=right)
    else:
        left = figure.subplots()
    draw_posterior_over_time(data, ax=left)
    caption = (
        "Left: the probability of each goal at each instant; the strip below shows the segments in the "
        "colour of the "
        "goal that was reached, so a good posterior has the line of the strip's colour on top, early."
    )
    if planar:
        plane = " in the first two coordinates" if data.position.shape[1] > 2 else ""
        caption += (
            f" Right: the path{plane}, each sample in the colour of the goal believed most, paler where the belief "
            "is less certain; diamonds are all places the goals had (faint where nobody went), rings the goals "
            "reached, the open circle the start."
        )
    return ReportFigure(
        name=f"trial-{number}.png",
        png=png_of(figure),
        title=f"Trial {data.trial_id} of participant {data.participant} ({why})",
        caption=caption,
    )


def score_figure(scores: Sequence[Score], chance: tuple[float, float]) -> ReportFigure:
    """Draw accuracy and mean log posterior against the share of the segment seen."""
    figure = new_figure(9.2, 3.4)
    left, right = figure.subplots(1, 2)
    plot_score_over_share(scores, "accuracy", chance=chance[0], ax=left)
    plot_score_over_share(scores, "mean_log_posterior", chance=chance[1], ax=right)
    return ReportFigure(
        name="scores.png",
        png=png_of(figure),
        title="Scores against the share of the path seen",
        caption=(
            "Left: how often the most probable goal is the true one after a share of each segment. Right: "
            "the mean "
            "logarithm of the true goal's probability (0 is perfect), which also punishes being sure and "
            "wrong. Higher "
            "and earlier is better. Bands: one standard error over participants. Dashed: a uniform guess "
            "among the goals that are present."
        ),
    )


def calibration_figure(calibration: Calibration) -> ReportFigure:
    """Draw the reliability of the most probable goal and of all goals."""
    figure = new_figure(9.2, 4.2)
    left, right = figure.subplots(1, 2)
    plot_reliability(calibration.top_label, ax=left)
    plot_reliability(calibration.one_vs_rest, prediction="any goal", ax=right)
    return ReportFigure(
        name="calibration.png",
        png=png_of(figure),
        title="Calibration",
        caption=(
            "Does a goal that is given 80 % come true 80 times in 100? On the dashed diagonal the "
            "probabilities mean "
            "what they say; points below it are overconfident, above it too timid. Left: the most probable "
            "goal; right: "
            "every goal. All samples of segments count, each segment the same; bars are the share of them "
            "in each bin, "
            "whiskers 95 % bands by resampling participants. The expected calibration error is the mean "
            "distance from the diagonal."
        ),
    )


def participants_figure(scores: Sequence[ParticipantScore]) -> ReportFigure:
    """Draw the participants' scores after one share."""
    # where there are too many to name them, a row each would be empty
    figure = new_figure(9.2, 1.4 + 0.2 * len(scores) if len(scores) <= MAX_NAMED else 3.8)
    left, right = figure.subplots(1, 2)
    plot_participants(scores, "accuracy", ax=left)
    plot_participants(scores, "mean_log_posterior", ax=right)
    return ReportFigure(
        name="participants.png",
        png=png_of(figure),
        title=f"Participants, after {100 * scores[0].at:.3g} % of each segment",
        caption=(
            "One dot a participant, sorted in each panel, with two standard errors over their segments (in "
            "brackets: how "
            "many). Dashed: the mean of the dots. People differ a lot: compare models on the "
            "same people."
        ),
    )


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of this size in inches."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def png_of(figure: Figure) -> bytes:
    """Return a figure as PNG."""
    buffer = io.BytesIO()
    for ax in figure.axes:
        as_plain_text(ax)
    with warnings.catch_warnings():
        # names in scripts that the font lacks are drawn as boxes; the page itself shows them
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        figure.savefig(buffer, format="png", dpi=_DPI, metadata={"Software": None})
    return buffer.getvalue()
