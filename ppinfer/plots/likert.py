"""Answers on a Likert scale as bars that diverge from the middle: who agrees, who disagrees, how strongly."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, Int

from ppinfer.errors import LogError
from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import FAINT, INK, MUTED, new_axes, quiet

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ppinfer.studies.surveys.survey import Survey

# ends of brown and blue-green, which differ for every kind of sight, and a light grey for the middle
_DISAGREE, _MIDDLE, _AGREE = "#B35806", "#E3E3E3", "#01665E"
_LINE = 46
_ROW = 0.27
_MOST_NAMED = 11


@draws_plain_text
def plot_likert(
    survey: Survey,
    items: Sequence[str] | None = None,
    *,
    by: Sequence[str] | None = None,
    ax: Axes | None = None,
) -> Axes:
    r"""Draw the share of each answer to each item under each condition, stacked around the middle of the scale.

    What lies right of the line at 0 agrees, what lies left disagrees; the middle number of a scale with one is halved
    by the line. The number at the right end is how many answered. Answers are drawn as given, also
    those to items that are scored in reverse.

    Parameters
    ----------
    survey : Survey
        From `ppinfer.studies.surveys.read_survey`; missing answers are left out of the shares.
    items : sequence of str, optional
        Which, from top to bottom; by default all. They are answered on the same numbers.
    by : sequence of str, optional
        Condition columns to tell apart; by default all.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure by default, as tall as the bars need.

    Returns
    -------
    matplotlib.axes.Axes
        The axes drawn on.

    Raises
    ------
    LogError
        If an item is unknown, or items are answered on different numbers.

    Examples
    --------
    >>> from pathlib import Path
    >>> from ppinfer.studies.surveys import Instrument, read_survey
    >>> _ = Path("answers.csv").write_text("user,robot,easy\nann,a,5\nann,b,2\nbob,a,4\nbob,b,3\n")
    >>> instrument = Instrument.parse('''
    ...     columns = {subject = "user", condition = "robot"}
    ...     anchors = {1 = "no", 5 = "yes"}
    ...     items.easy.text = "The robot was easy to work with."
    ... ''')
    >>> ax = plot_likert(read_survey("answers.csv", instrument))
    >>> ax.get_xlabel()
    'share of answers [%]'
    """
    instrument = survey.instrument
    names = list(instrument.items) if items is None else list(items)
    unknown = [name for name in names if name not in instrument.items]
    if unknown or not names:
        raise LogError(
            f"no item {unknown[0]!r}; there are {', '.join(instrument.items)}" if unknown else "no items"
        )
    points = instrument.points(names[0])
    if any(instrument.points(name) != points for name in names):
        raise LogError(
            "items that are answered on different numbers are not drawn together; name those on one scale"
        )
    groups = survey.groups(by)
    columns = [list(instrument.items).index(name) for name in names]
    counts = np.array(
        [[_counts(survey.values[rows, at], points) for rows in groups.values()] for at in columns], np.float64
    )
    if ax is None:
        ax = new_axes(9.0, 1.3 + _ROW * len(names) * (len(groups) + 0.8))
    height = (np.arange(len(names))[:, None] * (len(groups) + 0.8) + np.arange(len(groups))).astype(
        np.float64
    )
    _draw_bars(ax, counts, height, points)
    titles = [_title(survey, label, by) for label in groups]
    _name_rows(ax, survey, names, titles, height)
    _legend(ax, instrument.texts(names[0]), points)
    return ax


def _counts(values: Float[np.ndarray, " response"], points: range) -> Int[np.ndarray, " point"]:
    given = values[~np.isnan(values)].astype(np.int64)
    return np.bincount(given - points[0], minlength=len(points))


def _draw_bars(
    ax: Axes,
    counts: Float[np.ndarray, "item condition point"],
    height: Float[np.ndarray, "item condition"],
    points: range,
) -> None:
    total = counts.sum(axis=2, keepdims=True)
    share = 100 * np.divide(counts, total, out=np.zeros_like(counts), where=total > 0)
    # the bars of one row begin where those before end, shifted so that the middle of the scale is at 0
    ends = np.cumsum(share, axis=2)
    middle = (len(points) - 1) / 2
    below = share[:, :, : len(points) // 2].sum(axis=2)
    if len(points) % 2:
        below = below + share[:, :, int(middle)] / 2
    left = ends - share - below[:, :, None]
    for at, colour in enumerate(_colours(len(points))):
        ax.barh(
            height.ravel(), share[:, :, at].ravel(), left=left[:, :, at].ravel(), height=0.84, color=colour
        )
    if len(points) <= _MOST_NAMED:
        dark = [abs(at - middle) > 0.55 * middle for at in range(len(points))]
        for item, condition, at in np.argwhere(share >= 5):
            ax.text(
                left[item, condition, at] + share[item, condition, at] / 2,
                height[item, condition],
                f"{counts[item, condition, at]:.0f}",
                ha="center",
                va="center",
                fontsize="x-small",
                color="white" if dark[at] else INK,
            )
    # behind the bars, where it would cross the counts in the middle
    ax.axvline(0.0, color=INK, linewidth=1.0, zorder=0.8)
    reach = max(float(-left.min()), float((left + share).max()), 1.0) * 1.03
    ax.set_xlim(-reach, reach)
    for y, count in zip(height.ravel(), total.ravel(), strict=True):
        ax.annotate(
            f"n = {count:.0f}", (1.0, y), xycoords=("axes fraction", "data"), xytext=(3, 0),
            textcoords="offset points", va="center", fontsize="x-small", color=MUTED,
        )  # fmt: skip


def _colours(count: int) -> list[str]:
    from matplotlib.colors import LinearSegmentedColormap, to_hex

    ramp = LinearSegmentedColormap.from_list("likert", [_DISAGREE, "#F0B26B", _MIDDLE, "#7CC4B8", _AGREE])
    return [to_hex(ramp(at / (count - 1))) for at in range(count)]


def _name_rows(
    ax: Axes,
    survey: Survey,
    names: Sequence[str],
    titles: Sequence[str],
    height: Float[np.ndarray, "item condition"],
) -> None:
    for tick in ax.set_yticks(height.ravel(), list(titles) * len(names)):
        tick.label1.set_parse_math(False)
    ax.set_ylim(height.max() + 0.6, height.min() - 0.7)
    quiet(ax)
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)
    widest = max((len(title) for title in titles), default=0)
    for name, row in zip(names, height, strict=True):
        item = survey.instrument.items[name]
        said = survey.instrument.wording(name) + (" (scored in reverse)" if item.reversed else "")
        ax.annotate(
            "\n".join(textwrap.wrap(said, _LINE)), (0.0, float(row.mean())), xycoords=("axes fraction", "data"),
            xytext=(-12 - 5.2 * widest, 0), textcoords="offset points", ha="right", va="center", fontsize="small",
            color=INK, parse_math=False,
        )  # fmt: skip
    ax.set_xlabel("share of answers [%]")
    ax.xaxis.set_major_formatter(lambda value, _: f"{abs(value):.0f}")
    ax.grid(axis="x", color=FAINT, linewidth=0.5)
    ax.set_axisbelow(True)


def _title(survey: Survey, label: str, by: Sequence[str] | None) -> str:
    factors = survey.instrument.factors
    kept = factors if by is None else tuple(by)
    if len(kept) != 1:
        return label
    return survey.instrument.conditions.get(kept[0], {}).get(label) or label


def _legend(ax: Axes, texts: dict[int, str], points: range) -> None:
    from matplotlib.patches import Patch

    shown = points if len(points) <= _MOST_NAMED else [points[0], points[-1]]
    colours = dict(zip(points, _colours(len(points)), strict=True))
    handles = [Patch(color=colours[at], label=f"{at} {texts.get(at, '')}".strip()) for at in shown]
    legend = ax.legend(
        handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=len(handles), frameon=False,
        fontsize="small", handlelength=1.2, columnspacing=1.2,
    )  # fmt: skip
    for text in legend.get_texts():
        text.set_parse_math(False)
