"""The posterior over the goals of one trial, live: its parameters, and how much has been seen, on sliders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from jaxtyping import Float

from ppinfer.errors import PPInferError
from ppinfer.goals import GoalModel
from ppinfer.plots.explore import Explorer, explore, require_widgets
from ppinfer.plots.palette import FAINT, INK, goal_colour, goal_dashes
from ppinfer.plots.trial_data import TrialData, read_trial, trial_index

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PROBABILITIES = (0.0, 0.001, 0.01, 0.05, 0.1, 0.2, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.999, 1.0)
_DECADES = 3
# what a `GoalLQR` takes from its agent, where it was given one
_OF_THE_AGENT = ("control_weight", "rationality")
# area of a goal that is certain, and of one that is ruled out (points^2)
_CERTAIN, _RULED_OUT = 420.0, 25.0


def explore_goals(
    log: xr.Dataset,
    trial: str | int,
    model: GoalModel,
    *,
    parameters: Sequence[str] = ("rationality", "stay"),
    agent: str | None = None,
    seen: float | None = None,
) -> Explorer:
    """Show where an agent seems to be heading in one trial, with the model's parameters on sliders.

    On the left the path so far and the goals, the larger the more probable; on the right the posterior over time, up
    to where the slider ``seen`` stands. The strip below it is the truth, where it is known.

    Parameters
    ----------
    log : Dataset
        A study log with goals.
    trial : str or int
        The trial's name or index.
    model : GoalModel
        Where the sliders begin.
    parameters : sequence of str
        Which of the model's parameters get a slider: any of those that can be fitted, ``model.fitted``.
    agent : str, optional
        Whose goals; default ``human`` where there is one, or the only agent.
    seen : float, optional
        How much of the trial has been seen at first (s); default: half.

    Returns
    -------
    Explorer
        The picture; its controls are the parameters, and ``seen`` (s).

    Raises
    ------
    PPInferError
        Where ipywidgets is not installed, or a parameter is none that this model is fitted by.
    LogError
        Where there is no such trial, or the log has no goals in the plane.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR
    >>> from ppinfer.testing import example_log
    >>> shown = explore_goals(example_log(), 0, GoalLQR())
    >>> sorted(shown.controls)
    ['rationality', 'seen', 'stay']
    >>> shown.controls["rationality"].value = 0.02
    """
    from ppinfer.studies import infer_log, select_trials

    unknown = sorted(set(parameters) - set(model.fitted))
    if unknown:
        raise PPInferError(
            f"explore_goals: {model.name} has no parameter {unknown[0]!r} to move; it has "
            f"{', '.join(model.fitted) or 'none'}"
        )
    if getattr(model, "agent", None) is not None:
        fixed = [name for name in parameters if name in _OF_THE_AGENT]
        if fixed:
            raise PPInferError(
                f"explore_goals: this {model.name} has an agent of its own, whose {fixed[0]} cannot be moved; give the "
                "model its parameters instead, or leave them out of `parameters`"
            )
    one = select_trials(log, np.array([trial_index(log, trial)]))

    begun: Any = model  # a dataclass, like every model that is fitted

    def read(**values: float) -> TrialData:
        return read_trial(infer_log(one, replace(begun, **values), agent=agent), 0)

    first = read()
    widgets = require_widgets()
    begin, end = float(first.time[0]), float(first.time[-1])
    controls = {name: _slider(name, getattr(model, name), model.fitted[name]) for name in parameters}
    controls["seen"] = widgets.FloatSlider(
        value=(begin + end) / 2 if seen is None else seen,
        min=begin,
        max=end,
        step=max((end - begin) / 100, 1e-3),
        description="seen so far [s]",
    )
    bounds = _bounds(first)

    def draw(left: Axes, right: Axes, *, seen: float, **values: float) -> None:
        # the trial is read anew: its evidence is one array program, a few milliseconds for thousands of samples
        data = read(**values)
        now = max(int(np.searchsorted(data.time, seen, side="right")) - 1, 0)
        _draw_place(left, data, now, bounds)
        held = ", ".join(f"{name} {value:.3g}" for name, value in values.items())
        # a printed page has no sliders: the picture says itself where they stand
        title = f"trial {data.trial_id}, {data.time[now]:.1f} s\n{held}"
        left.set_title(title, loc="left", fontsize="medium").set_parse_math(False)
        _draw_belief(right, data, now)

    return explore(draw, figsize=(11.0, 4.2), widths=(1.0, 1.5), **controls)


def _slider(name: str, value: float, scale: str) -> Any:
    widgets = require_widgets()
    if scale == "log":
        middle = np.log10(value)
        return widgets.FloatLogSlider(
            value=value, min=middle - _DECADES, max=middle + _DECADES, step=0.1, description=name
        )
    return widgets.SelectionSlider(
        value=value, options=sorted({*_PROBABILITIES, float(value)}), description=name
    )


def _bounds(data: TrialData) -> Float[np.ndarray, "limit space"]:
    """Return the least and the greatest place that the picture shows, (2, 2), with a margin."""
    places = np.concatenate([data.position[:, :2], data.goal_position[:, :, :2].reshape(-1, 2)])
    low, high = np.nanmin(places, axis=0), np.nanmax(places, axis=0)
    margin = 0.08 * (high - low).max()
    limits: np.ndarray = np.array([low - margin, high + margin])
    return limits


def _draw_place(ax: Axes, data: TrialData, now: int, bounds: Float[np.ndarray, "limit space"]) -> None:
    """Draw the path up to a sample, and the goals there are then, by their probability."""
    ax.plot(*data.position[: now + 1, :2].T, color=INK, linewidth=1.4, zorder=2)
    ax.plot(*data.position[0, :2], "o", mfc="white", mec=INK, ms=6, zorder=3)
    ax.plot(*data.position[now, :2], "o", color=INK, ms=5, zorder=3)
    for goal in data.shown_goals:
        place, probability = data.goal_position[now, goal, :2], data.probability[now, goal]
        if np.isnan(place).any():
            continue
        size = _RULED_OUT + (_CERTAIN - _RULED_OUT) * probability
        ax.scatter(
            place[0], place[1], marker="D", s=size, color=goal_colour(goal), edgecolors="white", zorder=4
        )
        text = ax.annotate(
            f"{data.goals[goal]}: {probability:.2f}",
            tuple(place),
            xytext=(0, -4 - np.sqrt(size) / 2),
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize="small",
            color=INK,
            zorder=5,
        )
        text.set_parse_math(False)
    ax.set(xlim=bounds[:, 0], ylim=bounds[:, 1], xlabel=f"x [{data.units}]", ylabel=f"y [{data.units}]")
    ax.set_aspect("equal", adjustable="box")


def _draw_belief(ax: Axes, data: TrialData, now: int) -> None:
    """Draw the posterior up to a sample, and the true goals of the whole trial below it."""
    from matplotlib.patches import Rectangle

    for goal in data.shown_goals:
        (line,) = ax.plot(
            data.time[: now + 1],
            data.probability[: now + 1, goal],
            color=goal_colour(goal),
            linestyle=goal_dashes(goal),
            linewidth=1.8,
            label=f"goal {data.goals[goal]}",
        )
        line.set_clip_on(False)
    for segment in data.segments:
        when = float(data.time[segment.start])
        colour = goal_colour(segment.true_goal) if segment.true_goal >= 0 else FAINT
        length = float(data.time[segment.stop - 1]) - when
        ax.add_patch(Rectangle((when, -0.1), length, 0.05, color=colour, linewidth=0))
    ax.axvline(float(data.time[now]), color=INK, linewidth=0.8, linestyle=":")
    begin, end = float(data.time[0]), float(data.time[-1])
    ax.set(xlim=(begin, end if end > begin else begin + 1.0), ylim=(-0.12, 1.04), yticks=[0, 0.5, 1])
    ax.set(xlabel="time [s]" + " (strip: true goal)" * bool(data.segments), ylabel="posterior probability")
    legend = ax.legend(
        loc="lower left", bbox_to_anchor=(0, 1), ncols=6, frameon=False, fontsize="small", borderaxespad=0.2
    )
    for text in legend.get_texts():
        text.set_parse_math(False)
