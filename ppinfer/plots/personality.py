"""The posterior over theta through one trial: whom the human's choice of equilibria favours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float

from ppinfer.distributions.ragged import row_starts
from ppinfer.errors import LogError
from ppinfer.plots.labels import draws_plain_text
from ppinfer.plots.palette import INK, MUTED, WARNING, goal_colour, new_axes, quiet
from ppinfer.plots.replan_beliefs import belief_variable, controllers
from ppinfer.plots.trial_data import trial_index

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class PersonalityTrial:
    """One trial of a log or of a posterior over theta, in memory.

    Attributes
    ----------
    viewer, agent
        Whose beliefs they are, and about whom: also the label of theta of who favours itself.
    robot, human
        Who controlled the viewer and the agent.
    replan_time, probability
        The robot's replans and its belief at each; NaN where it held none.
    time, held
        The trial's samples, and whether a safety stop led to each; empty where the file does not say.
    finish_time
        Agents and when they were done, of those who were.
    """

    trial_id: str
    viewer: str
    agent: str
    robot: str
    human: str
    theta: tuple[str, ...]
    replan_time: Float[np.ndarray, " replan"]
    probability: Float[np.ndarray, "replan theta"]
    time: Float[np.ndarray, " sample"]
    held: Bool[np.ndarray, " sample"]
    finish_time: tuple[tuple[str, float], ...]

    @property
    def end(self) -> float:
        """When the trial ends, as far as the file says."""
        return float(max(self.replan_time.max(initial=0.0), self.time.max(initial=0.0)))


@draws_plain_text
def plot_personality(
    dataset: xr.Dataset,
    trial: str | int,
    *,
    robot: str = "robot",
    human: str = "human",
    ax: Axes | None = None,
) -> Axes:
    """Draw p(theta) at each replan of a trial, stacked: the height of a band is its probability.

    A belief holds until the next replan. Red ticks at the top mark safety stops, dashed lines when agents were
    done; without a belief the picture stays white.

    Parameters
    ----------
    dataset
        A study log with ``live_log_posterior``, or a posterior over theta; one trial of it is read.
    trial
        The trial's name or index.
    robot, human
        Which agents these are.
    ax
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes drawn on.

    Raises
    ------
    LogError
        If there is no such trial, or the file holds no beliefs over theta.

    Examples
    --------
    >>> from ppinfer.testing.example_plays import example_planned_log
    >>> ax = plot_personality(example_planned_log(), 0)
    >>> ax.figure.savefig("personality.png")
    """
    return draw_personality(read_personality_trial(dataset, trial, robot=robot, human=human), ax=ax)


def read_personality_trial(
    dataset: xr.Dataset, trial: str | int, *, robot: str = "robot", human: str = "human"
) -> PersonalityTrial:
    """Read what `draw_personality` draws of one trial.

    Raises
    ------
    LogError
        If there is no such trial, or the file holds no beliefs over theta.
    """
    name = belief_variable(dataset)
    if name is None:
        raise LogError("the file holds no beliefs over theta at replans")
    index = trial_index(dataset, trial)
    first = int(row_starts(dataset["replan_row_size"].values)[index])
    replans = slice(first, first + int(dataset["replan_row_size"].values[index]))
    mine = dataset["replan_agent"][replans].values.astype(str) == robot
    time, held = np.zeros(0), np.zeros(0, dtype=bool)
    if "row_size" in dataset and "time" in dataset:
        start = int(row_starts(dataset["row_size"].values)[index])
        samples = slice(start, start + int(dataset["row_size"].values[index]))
        time = dataset["time"][samples].values
        held = dataset["held"][samples].values != 0 if "held" in dataset else np.zeros(len(time), dtype=bool)
    done: tuple[tuple[str, float], ...] = ()
    if "finish_time" in dataset:
        agents = [str(agent) for agent in dataset["agent"].values]
        done = tuple(zip(agents, dataset["finish_time"][index].values.tolist(), strict=True))
    return PersonalityTrial(
        trial_id=str(dataset["trial_id"].values[index]),
        viewer=robot,
        agent=human,
        robot=str(controllers(dataset, robot)[index]),
        human=str(controllers(dataset, human)[index]),
        theta=tuple(str(label) for label in dataset["theta"].values),
        replan_time=dataset["replan_time"][replans].values[mine],
        probability=np.exp(dataset[name][replans].values[mine]),
        time=time,
        held=held,
        finish_time=tuple((agent, when) for agent, when in done if np.isfinite(when)),
    )


@draws_plain_text
def draw_personality(data: PersonalityTrial, *, ax: Axes | None = None) -> Axes:
    """Draw a trial that was already read; see `plot_personality`."""
    ax = ax if ax is not None else new_axes(6.4, 2.8)
    end = data.end if data.end > 0 else 1.0
    # who favours itself is at the bottom, so that the height of the line is its probability
    order = sorted(range(len(data.theta)), key=lambda index: (data.theta[index] != data.agent, index))
    begin = np.append(data.replan_time, end)
    tops = np.cumsum(data.probability[:, order], axis=1)
    tops = np.vstack([tops, tops[-1:]]) if len(tops) else np.full((1, len(order)), np.nan)
    for place, index in enumerate(order):
        ax.fill_between(
            begin,
            tops[:, place - 1] if place else np.zeros(len(tops)),
            tops[:, place],
            step="post",
            color=theta_colour(data.theta[index], index),
            alpha=0.75,
            linewidth=0,
            label=_words(data.theta[index], data.agent),
        )
        if place < len(order) - 1:
            ax.step(begin, tops[:, place], where="post", color="white", linewidth=1.2)
    draw_events(data, ax, top=1.045)
    ax.set_xlim(0, end)
    ax.set_ylim(0, 1.09)
    ax.set_yticks([0, 0.25, 0.5, 0.75, 1])
    ax.set_xlabel("time [s]")
    ax.set_ylabel("p(theta)")
    who = f"{data.viewer} {data.robot or 'unknown'}, {data.agent} {data.human or 'unknown'}"
    title = f"trial {data.trial_id}: {who}"
    ax.set_title(title, fontsize="medium", loc="left", pad=16).set_parse_math(False)
    handles, labels = ax.get_legend_handles_labels()
    legend = ax.legend(
        handles,
        labels,
        loc="upper left",
        bbox_to_anchor=(1.01, 1.0),
        frameon=False,
        fontsize="small",
        borderaxespad=0,
        handlelength=1.2,
        labelcolor=INK,
    )
    for text in legend.get_texts():
        text.set_parse_math(False)
    quiet(ax)
    return ax


def draw_events(data: PersonalityTrial, ax: Axes, *, top: float) -> None:
    """Mark safety stops at the height ``top``, and when agents were done."""
    if data.held.any():
        when = data.time[data.held]
        ax.plot(
            when,
            np.full(len(when), top),
            "|",
            color=WARNING,
            markersize=7,
            label=f"safety stop ({len(when)})",
        )
    for index, (agent, when) in enumerate(sorted(data.finish_time, key=lambda done: done[1])):
        ax.axvline(when, color=INK, linewidth=1, linestyle="--")
        text = ax.annotate(
            f"{agent} done",
            (when, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 2),
            textcoords="offset points",
            # whoever is last is named on the other side, since both may be done at nearly the same time
            ha="left" if index else "right",
            fontsize="small",
            color=MUTED,
        )
        text.set_parse_math(False)


def _words(label: str, agent: str) -> str:
    if label == agent:
        return f"{agent} favours itself"
    if label == "fair":
        return label
    # a role has an article, a name has none
    return f"{agent} favours {'the ' if label in ('robot', 'human') else ''}{label}"


def theta_colour(label: str, index: int) -> str:
    """Return the colour of a label of theta: the usual ones keep theirs wherever they stand.

    Examples
    --------
    >>> theta_colour("human", 1) == theta_colour("human", 0)
    True
    """
    usual = {"robot": 0, "human": 1, "fair": 2}
    return goal_colour(usual.get(label, 3 + index))
