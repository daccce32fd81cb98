"""The figures of a report on any log: all paths at once, and the paths of some trials."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import xarray as xr

from ppinfer.plots.log_paths import MAX_AGENTS, plot_log_paths
from ppinfer.plots.trial_paths import plot_trial_paths
from ppinfer.report.figures import ReportFigure, new_figure, png_of
from ppinfer.report.trial_choice import ChosenTrial

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def overview_figure(log: xr.Dataset) -> ReportFigure:
    """Draw all paths of a log over one another."""
    axes = plot_log_paths(log)
    agents = log.sizes["agent"]
    more = f" The first {MAX_AGENTS} of {agents} agents." if agents > MAX_AGENTS else ""
    seen = "the first two coordinates" if log.sizes["space"] > 2 else "positions"
    what = "hands" if "end_effector" in log else seen
    goals = (
        " Diamonds are all places of goals." if "goal_position" in log and "end_effector" not in log else ""
    )
    return ReportFigure(
        name="paths.png",
        png=png_of(cast("Figure", axes[0].figure)),
        title="All paths",
        caption=f"The paths of all trials over one another ({what}); open circles are starts.{goals}{more}",
    )


def trial_paths_figure(log: xr.Dataset, chosen: tuple[ChosenTrial, ...]) -> ReportFigure:
    """Draw the paths of some trials side by side."""
    figure = new_figure(3.6 * len(chosen), 3.6)
    panels = figure.subplots(1, len(chosen), squeeze=False)[0]
    names = log["trial_id"].values
    for each, ax in zip(chosen, panels, strict=True):
        plot_trial_paths(log, each.index, ax=ax)
        ax.set_title(f"trial {names[each.index]}", fontsize="medium", loc="left").set_parse_math(False)
    return ReportFigure(
        name="trials.png",
        png=png_of(figure),
        title="Some trials",
        caption=(
            "From open to full circle, a dot each second. "
            f"Trials {', '.join(str(names[each.index]) for each in chosen)}: {chosen[0].why}."
        ),
    )
