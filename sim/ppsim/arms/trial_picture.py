"""The picture of an instant of a trial of two arms: the table, what the robot considers and believes, and stops."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import UInt8

from ppinfer.plots.palette import FAINT, INK, MUTED, WARNING, quiet
from ppsim.arms.drawing import Capsules, agent_colour, draw_scene
from ppsim.arms.recorded import RecordedTrial

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

# inches and dots
_SIZE, _DPI = (9.6, 7.2), 100
# how the robot's own plan is drawn, what it expects of the other, and one that does not move
_CHOSEN: Any = "-"
_EXPECTED: Any = (0, (3, 1.5))
_RING: dict[str, Any] = {"marker": "o", "markersize": 17, "markerfacecolor": "none", "markeredgewidth": 2.2}
_WAITS = _RING | {"marker": ""}
# a stop is to be seen for a little longer than its one step, in samples
_GLOW = 3


def _on_white(colour: str, share: float) -> tuple[int, int, int]:
    parts = (int(colour[at : at + 2], 16) for at in (1, 3, 5))
    red, green, blue = (round(share * part + (1.0 - share) * 255) for part in parts)
    return red, green, blue


# what a stop adds to the colours of a picture: its own, less and less of it, and the edges of its letters
STOP_SHADES = tuple(_on_white(WARNING, step / 6) for step in range(6, 0, -1))


class TrialPicture:
    """A figure of a trial that can be put to any of its samples.

    On the table: the arms, their objects (dots) and where these go (squares), the end effectors' paths along the
    plans that the robot considers (faint), the one that it takes (bold), and what it thinks the human takes (dashed).
    Beside it and below, p(theta): whom the human's equilibria favour, now and so far; red marks are safety stops.

    Parameters
    ----------
    trial : RecordedTrial
        What to draw.
    """

    def __init__(self, trial: RecordedTrial) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.trial = trial
        self.figure: Figure = Figure(figsize=_SIZE, dpi=_DPI, facecolor="white")
        self._canvas: Any = FigureCanvasAgg(self.figure)
        self._table = self.figure.add_axes((0.065, 0.325, 0.68, 0.60))
        self._bars = self.figure.add_axes((0.835, 0.66, 0.115, 0.12))
        self._history = self.figure.add_axes((0.065, 0.075, 0.885, 0.15))
        self._believes = bool(np.isfinite(trial.belief).any())
        self._bars.set_visible(self._believes)
        #: what changes from sample to sample; all else is drawn once
        self._moving: list[Artist] = []
        draw_scene(self._table, trial)
        self._make_table()
        self._make_bars()
        self._make_history()
        self._make_words()
        for artist in self._moving:
            artist.set_animated(True)
        self._moving.sort(key=lambda artist: artist.get_zorder())
        self._still: Any = None
        self._drawn_replan = -2

    def show(self, sample: int) -> None:
        """Put the picture to a sample of the trial."""
        trial = self.trial
        replan = trial.replan_at(sample)
        for agent, capsules in enumerate(self._capsules):
            capsules.show(trial.joints[sample, agent])
            self._objects[agent].set_data(*trial.object_at(agent, sample)[:, None])
        # once the robot has left, nobody considers plans
        considered = replan if np.isfinite(trial.joints[sample, 0]).all() else -1
        if considered != self._drawn_replan:
            self._show_plans(considered)
            self._drawn_replan = considered
        self._show_belief(sample, replan)
        self._show_stops(sample)

    def pixels(self) -> UInt8[np.ndarray, "row column 3"]:
        """Draw the picture as it is, and return it as red, green and blue."""
        if self._still is None:
            self._canvas.draw()
            self._still = self._canvas.copy_from_bbox(self.figure.bbox)
        self._canvas.restore_region(self._still)
        for artist in self._moving:
            self.figure.draw_artist(artist)
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()

    def _make_table(self) -> None:
        from matplotlib.collections import LineCollection
        from matplotlib.lines import Line2D
        from matplotlib.patches import Rectangle

        ax, trial = self._table, self.trial
        ax.set_title(trial.title, loc="left", color=INK, fontsize="large")
        for spine in ax.spines.values():
            spine.set_visible(True)
            spine.set_color(FAINT)
        self._capsules = [Capsules(ax, arm, agent_colour(agent)) for agent, arm in enumerate(trial.arms)]
        self._faint, self._bold, self._objects = [], [], []
        for agent in range(len(trial.agents)):
            colour = agent_colour(agent)
            self._faint.append(LineCollection([], colors=colour, alpha=0.22, linewidths=1.0, zorder=3))
            style = _CHOSEN if agent == 0 else _EXPECTED
            self._bold.append(
                Line2D([], [], color=colour, linewidth=2.8, linestyle=style, zorder=4, **_WAITS)
            )
            self._objects.append(
                Line2D([], [], marker="o", markersize=9, color=colour, markeredgecolor=INK, zorder=7)
            )
            ax.add_collection(self._faint[-1], autolim=False)
            ax.add_line(self._bold[-1])
            ax.add_line(self._objects[-1])
        self._frame = Rectangle(
            (0, 0),
            1,
            1,
            transform=ax.transAxes,
            fill=False,
            color=WARNING,
            linewidth=4,
            zorder=8,
            clip_on=False,
        )
        ax.add_patch(self._frame)
        self._alarm = ax.text(
            0.5, 0.965, "SAFETY STOP", transform=ax.transAxes, ha="center", va="top", color="white", weight="bold",
            fontsize="large", zorder=9,
        )  # fmt: skip
        self._alarm_box = {"boxstyle": "round,pad=0.4", "facecolor": WARNING, "edgecolor": "none"}
        self._alarm.set_bbox(self._alarm_box)
        for capsules in self._capsules:
            self._moving += capsules.artists
        self._moving += [*self._faint, *self._bold, *self._objects, self._frame, self._alarm]

    def _make_bars(self) -> None:
        from matplotlib.patches import Rectangle

        ax, trial = self._bars, self.trial
        other = trial.agents[-1]
        places = np.arange(len(trial.theta))[::-1].tolist()
        ax.barh(places, 1.0, height=0.62, color="#F1F1F1")
        self._bar, self._share = [], []
        for name, at in zip(trial.theta, places, strict=True):
            bar = Rectangle((0.0, at - 0.31), 0.0, 0.62, color=_theta_colour(trial, name), linewidth=0)
            self._bar.append(bar)
            ax.add_patch(bar)
            self._share.append(ax.text(1.06, at, "", va="center", color=INK, fontsize="medium"))
        ax.set(xlim=(0, 1), ylim=(-0.6, max(len(trial.theta), 1) - 0.4), xticks=[0, 0.5, 1])
        ax.set_yticks(places, labels=[_favours(other, name) for name in trial.theta])
        ax.set_xlabel("p(θ)")
        quiet(ax)
        ax.spines["left"].set_visible(False)
        ax.tick_params(left=False)
        if self._believes:
            self._moving += [*self._bar, *self._share]

    def _make_history(self) -> None:
        from matplotlib.collections import LineCollection
        from matplotlib.lines import Line2D

        ax, trial = self._history, self.trial
        ax.set(
            xlim=(0, max(float(trial.time[-1]), 1.0)),
            ylim=(-0.02, 1.02),
            xlabel="time (s)",
            yticks=[0, 0.5, 1],
        )
        ax.set_ylabel("p(θ)")
        quiet(ax)
        # labels of arms that finish at nearly the same time would lie on one another
        close = abs(float(trial.finish_time[0] - trial.finish_time[-1])) < 0.1 * float(trial.time[-1])
        for agent, done in enumerate(trial.finish_time):
            if np.isfinite(done):
                up = 15 if close and done < np.nanmax(trial.finish_time) else 3
                ax.axvline(done, color=agent_colour(agent), linestyle=":", linewidth=1.4)
                ax.annotate(
                    f"{trial.agents[agent]} done", (done, 1.0), (-3, up), xycoords=("data", "axes fraction"),
                    textcoords="offset points", ha="right", va="bottom", color=agent_colour(agent), fontsize="small",
                )  # fmt: skip
        if not self._believes:
            ax.text(
                0.5,
                0.5,
                f"this {trial.agents[0]} holds no belief",
                transform=ax.transAxes,
                ha="center",
                color=MUTED,
            )
        self._stops = LineCollection([], colors=WARNING, linewidths=1.8, zorder=3)
        self._curves = [
            Line2D([], [], drawstyle="steps-post", color=_theta_colour(trial, name), linewidth=2.4, zorder=4)
            for name in trial.theta
        ]
        self._now = Line2D([], [], color=INK, linewidth=1.0, zorder=5)
        ax.add_collection(self._stops, autolim=False)
        for line in (*self._curves, self._now):
            ax.add_line(line)
        self._moving += [self._stops, *self._curves, self._now]

    def _make_words(self) -> None:
        from matplotlib.lines import Line2D

        robot, other = self.trial.agents[0], self.trial.agents[-1]
        figure = self.figure
        self._clock = figure.text(0.95, 0.925, "", fontsize=20, color=INK, va="top", ha="right")
        self._count = figure.text(0.775, 0.555, "", fontsize=13, va="top")
        self._moving += [self._clock, self._count]
        if self._believes:
            figure.text(0.775, 0.85, f"Whom does\nthe {other} favour?", color=INK, va="top")
        mine, theirs = agent_colour(0), agent_colour(1)
        entries = [
            (Line2D([], [], color=mine, linewidth=2.8), f"the {robot}'s plan"),
            (
                Line2D([], [], color=theirs, linewidth=2.8, linestyle=_EXPECTED),
                f"the {other}'s, as\nthe {robot} expects",
            ),
            (Line2D([], [], color=MUTED, linewidth=1.0, alpha=0.5), "other candidates"),
            (
                Line2D(
                    [], [], color=MUTED, linestyle="", **_RING | {"markersize": 10, "markeredgewidth": 1.8}
                ),
                "waits",
            ),
            (
                Line2D([], [], color=MUTED, linestyle="", marker="o", markersize=8, markeredgecolor=INK),
                "object",
            ),
            (
                Line2D([], [], color=MUTED, linestyle="", marker="s", markersize=9, fillstyle="none"),
                "goes here",
            ),
            (Line2D([], [], color=WARNING, linewidth=1.8), "safety stop"),
        ]
        figure.legend(
            *zip(*entries, strict=True), loc="upper left", bbox_to_anchor=(0.76, 0.515), frameon=False,
            fontsize=9, labelcolor=MUTED, handlelength=2.2, labelspacing=0.65,
        )  # fmt: skip

    def _show_plans(self, replan: int) -> None:
        for agent in range(len(self.trial.agents)):
            paths = list(self.trial.paths[replan][agent]) if replan >= 0 else []
            chosen = int(self.trial.chosen[replan, agent]) if replan >= 0 else -1
            bold = paths[chosen] if 0 <= chosen < len(paths) else np.empty((0, 2))
            self._faint[agent].set_segments([path for path in paths if len(path) > 1])
            # many of them must not hide the table
            self._faint[agent].set_alpha(min(0.25, 3.0 / max(len(paths), 1)))
            self._bold[agent].set_data(*bold.T)
            # a plan that does not move is one point, which gets a ring
            self._bold[agent].set_marker("o" if len(bold) == 1 else "")

    def _show_belief(self, sample: int, replan: int) -> None:
        trial = self.trial
        now = float(trial.time[sample])
        self._now.set_data([now, now], [0.0, 1.0])
        belief = trial.belief[: replan + 1]
        until = np.nanmin([now, trial.finish_time[0]])
        when = np.append(trial.time[trial.replan_sample[: replan + 1]], [until] * min(1, len(belief)))
        for number, curve in enumerate(self._curves):
            curve.set_data(when, np.append(belief[:, number], belief[-1:, number]))
            share = float(belief[-1, number]) if len(belief) else np.nan
            self._bar[number].set_width(0.0 if np.isnan(share) else share)
            self._share[number].set_text("" if np.isnan(share) else f"{share:.2f}")

    def _show_stops(self, sample: int) -> None:
        trial = self.trial
        since = trial.held[max(0, sample - _GLOW + 1) : sample + 1]
        # full at the stop itself, then fading
        glow = float((np.flatnonzero(since)[-1] + 1 + _GLOW - len(since)) / _GLOW) if since.any() else 0.0
        for artist in (self._alarm, self._frame):
            artist.set_visible(glow > 0.0)
            artist.set_alpha(glow)
        self._alarm.set_bbox(self._alarm_box | {"alpha": glow})
        count = int(trial.stops[sample])
        self._count.set_text(f"{count} safety stop{'' if count == 1 else 's'}")
        self._count.set_color(WARNING if count else INK)
        self._clock.set_text(f"{float(trial.time[sample]):.1f} s")
        when = trial.time[: sample + 1][trial.held[: sample + 1]]
        self._stops.set_segments([[(at, 0.0), (at, 1.0)] for at in when])


def _theta_colour(trial: RecordedTrial, name: str) -> str:
    """Return the colour of the agent that is favoured; anything else, such as fair, has a colour of its own."""
    return agent_colour(trial.agents.index(name) if name in trial.agents else len(trial.agents))


def _favours(agent: str, name: str) -> str:
    return "itself" if name == agent else f"the {name}" if name != "fair" else name
