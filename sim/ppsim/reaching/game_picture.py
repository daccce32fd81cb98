"""The picture of an instant of a reaching game: both agents, what the robot believes and considers, score, hits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from jaxtyping import Float, UInt8

from ppinfer.plots.palette import (
    FAINT,
    HUMAN_COLOUR,
    INK,
    MUTED,
    ROBOT_COLOUR,
    WARNING,
    goal_colour_among_agents,
    quiet,
)
from ppinfer.plots.workspace import clear_corner, halo
from ppinfer.studies.assumed_reactions import robots_of_ones_own
from ppsim.reaching.watching import held_live, paths_at, read_game, scores_of

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

# inches and dots
_SIZE, _DPI = (9.6, 7.2), 100
# a score or a collision is to be seen for so many samples, and where the agents were for so many
_GLOW, _TRAIL = 5, 20
_MARGIN = 2.0
# how far a goal's label is from it: outside its rings
_ASIDE = 0.6


def _on_white(colour: str, share: float) -> tuple[int, int, int]:
    parts = (int(colour[at : at + 2], 16) for at in (1, 3, 5))
    red, green, blue = (round(share * part + (1.0 - share) * 255) for part in parts)
    return red, green, blue


# what later frames may show that the first one does not: goals, trajectories, scores and collisions
SHADES = tuple(
    _on_white(colour, share)
    for colour in (
        WARNING,
        ROBOT_COLOUR,
        HUMAN_COLOUR,
        *(goal_colour_among_agents(goal) for goal in range(5)),
    )
    for share in (1.0, 0.75, 0.5, 0.25)
)


class GamePicture:
    """A figure of a game that can be put to any of its samples.

    In the plane: goals (diamonds), the human (orange) and the robot (blue) with where they just were, the candidate
    trajectories to the robot's goal, made anew from the log (safe ones blue, others dotted red, the chosen one thick),
    and a ring about the goal of each agent. Beside it, as bars: the belief about the human's goal, what the human is
    taken to think the robot's is, and b_post, one row for each goal of the robot, framed where it is the present one;
    of a robot of one's own, whose conditional no log holds, that row alone: the one that it held live.
    Below, b_post given the robot's goal so far.

    Parameters
    ----------
    log : xarray.Dataset
        Of one game; see `ppsim.one_trial.one_trial`.

    Raises
    ------
    LogError
        If the log is not of one game of two agents among goals.

    Examples
    --------
    >>> from ppinfer.testing import example_interaction_log
    >>> picture = GamePicture(example_interaction_log(trials=1))
    >>> picture.show(4)
    >>> picture.pixels().shape
    (720, 960, 3)
    """

    def __init__(self, log: xr.Dataset) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.game = read_game(log)
        self.beliefs = held_live(log, self.game)
        self.score = scores_of(log)
        self.collisions = np.cumsum(self.game.collision)
        self.title = _title(log)
        self.figure: Figure = Figure(figsize=_SIZE, dpi=_DPI, facecolor="white")
        self._canvas: Any = FigureCanvasAgg(self.figure)
        self._plane = self.figure.add_axes((0.065, 0.295, 0.56, 0.645))
        self._moving: list[Artist] = []
        self._make_plane()
        # a log may have more goals than this game
        self._there = np.flatnonzero((~np.isnan(self.game.places).any(axis=2)).any(axis=0)).tolist()
        goals, own = len(self._there), robots_of_ones_own(log, self.game.partner)
        said = "where, as the robot held it live" if own else "where, if the robot goes for"
        self._belief = self._make_bars((0.70, 0.76, 0.27, 0.13), "where will the human go?", 1)[0]
        self._mind = self._make_bars((0.70, 0.565, 0.27, 0.13), "where does it think the robot goes?", 1)[0]
        self._post = self._make_bars((0.70, 0.27, 0.27, 0.225), said, goals)
        self._make_history()
        self._make_words()
        for artist in self._moving:
            artist.set_animated(True)
        self._moving.sort(key=lambda artist: artist.get_zorder())
        self._still: Any = None

    def show(self, sample: int) -> None:
        """Put the picture to a sample of the game."""
        game = self.game
        goal = int(game.partner_goal[sample])
        self._show_agents(sample, goal)
        self._show_paths(sample)
        there = self._there
        _set_bars(self._belief, self.beliefs["belief"][sample, there])
        _set_bars(self._mind, self.beliefs["mental_model"][sample, there])
        for row, bars, frame in zip(there, self._post, self._rows, strict=True):
            _set_bars(bars, np.nan_to_num(game.post[sample, row, there]))
            frame.set_visible(row == goal)
        self._now.set_data([game.time[sample]] * 2, [0.0, 1.0])
        self._show_events(sample)

    def pixels(self) -> UInt8[np.ndarray, "row column 3"]:
        """Draw the picture as it is, and return it as red, green and blue."""
        if self._still is None:
            self._canvas.draw()
            self._still = self._canvas.copy_from_bbox(self.figure.bbox)
        self._canvas.restore_region(self._still)
        for artist in self._moving:
            self.figure.draw_artist(artist)
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()

    def _make_plane(self) -> None:
        from matplotlib.collections import LineCollection
        from matplotlib.lines import Line2D
        from matplotlib.patches import Rectangle

        ax, game = self._plane, self.game
        points = np.concatenate([game.position.reshape(-1, 2), game.places.reshape(-1, 2)])
        points = points[~np.isnan(points).any(axis=1)]
        low, high = points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN
        middle, half = (low + high) / 2, (high - low).max() / 2
        ax.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
        ax.set_aspect("equal")
        for name, label in (("x", ax.set_xlabel), ("y", ax.set_ylabel)):
            label(f"{name} [{game.units}]").set_parse_math(False)
        ax.grid(color="#EEEEEA", linewidth=0.8)
        ax.set_axisbelow(True)
        quiet(ax)
        ax.set_title(self.title, loc="left", fontsize="medium").set_parse_math(False)
        self._paths = [
            LineCollection([], colors=colour, linewidths=0.8, alpha=0.5, linestyles=dashes, zorder=3)
            for colour, dashes in ((WARNING, ":"), (ROBOT_COLOUR, "-"))
        ]
        self._chosen = Line2D([], [], linewidth=2.8, color=ROBOT_COLOUR, zorder=5)
        self._goals = [
            Line2D([], [], marker="D", ms=9, color=goal_colour_among_agents(goal), mec="white", zorder=4)
            for goal in range(len(game.goals))
        ]
        self._names = [
            ax.text(0, 0, name, fontsize="small", color=INK, zorder=9, parse_math=False, path_effects=halo())
            for name in game.goals
        ]
        colours = (HUMAN_COLOUR, ROBOT_COLOUR)
        self._trails = [
            Line2D([], [], color=colour, linewidth=1.8, alpha=0.5, zorder=4) for colour in colours
        ]
        self._agents = [
            Line2D([], [], marker="o", ms=13, color=colour, mec="white", zorder=7) for colour in colours
        ]
        self._rings = [
            Line2D([], [], marker="o", ms=size, mfc="none", mec=colour, mew=2, ls="", zorder=6)
            for size, colour in zip((20, 27), colours, strict=True)
        ]
        self._frame = Rectangle((0, 0), 1, 1, transform=ax.transAxes, fill=False, linewidth=4, clip_on=False)
        self._frame.set_zorder(10)
        for collection in self._paths:
            ax.add_collection(collection, autolim=False)
        for line in (self._chosen, *self._goals, *self._trails, *self._agents, *self._rings):
            ax.add_line(line)
        ax.add_patch(self._frame)
        self._moving += [*self._paths, self._chosen, *self._goals, *self._names, *self._trails, *self._agents]
        self._moving += [*self._rings, self._frame]

    def _make_bars(
        self, place: tuple[float, float, float, float], title: str, rows: int
    ) -> list[list[Rectangle]]:
        """Make rows of bars, one for each goal, in axes of their own; those of b_post are named by their goal."""
        from matplotlib.patches import Rectangle

        ax = self.figure.add_axes(place)
        names, count = [self.game.goals[goal] for goal in self._there], len(self._there)
        ax.set(xlim=(-0.6, count - 0.4), ylim=(0, rows), yticks=[])
        for tick in ax.set_xticks(range(count), names, fontsize="small"):
            tick.label1.set_parse_math(False)
        ax.set_title(title, loc="left", fontsize="small", color=INK)
        quiet(ax)
        ax.tick_params(length=0)
        ax.spines["left"].set_visible(False)
        made: list[list[Rectangle]] = []
        self._rows: list[Rectangle] = []
        for row in range(rows):
            floor = float(rows - 1 - row)
            ax.axhline(floor, color=FAINT, linewidth=0.8)
            bars = [
                Rectangle((at - 0.35, floor), 0.7, 0.0, color=goal_colour_among_agents(goal), linewidth=0)
                for at, goal in enumerate(self._there)
            ]
            for bar in bars:
                ax.add_patch(bar)
            if rows > 1:
                ax.text(
                    -0.7, floor + 0.5, names[row], ha="right", va="center", fontsize="small", weight="bold",
                    color=goal_colour_among_agents(self._there[row]), parse_math=False,
                )  # fmt: skip
                frame = Rectangle(
                    (-0.55, floor + 0.02), count + 0.1, 0.96, fill=False, color=ROBOT_COLOUR, linewidth=2,
                    clip_on=False,
                )  # fmt: skip
                ax.add_patch(frame)
                self._rows.append(frame)
            made.append(bars)
            self._moving += bars
        self._moving += self._rows
        return made

    def _make_history(self) -> None:
        from matplotlib.lines import Line2D

        ax, game = self.figure.add_axes((0.065, 0.075, 0.905, 0.115)), self.game
        given = self.beliefs["given"]
        for goal in self._there:
            ax.plot(game.time, given[:, goal], color=goal_colour_among_agents(goal), linewidth=1.3)
        for which, colour in ((np.diff(self.score, prepend=0) > 0, INK), (game.collision, WARNING)):
            ax.vlines(game.time[which], 0, 1, color=colour, linewidth=1.4)
        end = float(game.time[-1])
        ax.set(xlim=(0, end if end > 0 else 1), ylim=(-0.02, 1.02), yticks=[0, 1], xlabel="time [s]")
        ax.set_title(
            "belief about the human's goal, given the robot's; black: a score, red: a collision",
            loc="left",
            fontsize="small",
            color=INK,
        )
        quiet(ax)
        self._now = Line2D([], [], color=MUTED, linewidth=3.0, alpha=0.7, zorder=9)
        ax.add_line(self._now)
        self._moving.append(self._now)

    def _make_words(self) -> None:
        self._clock = self.figure.text(0.97, 0.965, "", fontsize=16, color=INK, va="top", ha="right")
        self._count = self.figure.text(0.695, 0.955, "", fontsize=10.5, color=INK, va="top")
        self._moving += [self._clock, self._count]

    def _show_agents(self, sample: int, goal: int) -> None:
        game = self.game
        for number, (line, name) in enumerate(zip(self._goals, self._names, strict=True)):
            place = game.places[sample, number]
            line.set_data(*place[:, None])
            name.set_visible(bool(np.isfinite(place).all()))
            across, up = clear_corner(place, game.position[sample], _ASIDE)
            name.set(ha="left" if across > 0 else "right", va="bottom" if up > 0 else "top")
            name.set_position((float(place[0]) + _ASIDE * across, float(place[1]) + _ASIDE * up))
        heading = next((one.goal for one in game.headings if one.start <= sample < one.stop), -1)
        for agent, pursued in enumerate((heading, goal)):
            self._trails[agent].set_data(*game.position[max(0, sample - _TRAIL) : sample + 1, agent].T)
            self._agents[agent].set_data(*game.position[sample, agent][:, None])
            place = game.places[sample, pursued] if pursued >= 0 else np.full(2, np.nan)
            self._rings[agent].set_data(*place[:, None])

    def _show_paths(self, sample: int) -> None:
        paths = paths_at(self.game, sample)
        empty: Float[np.ndarray, "0 2"] = np.empty((0, 2))
        positions = np.empty((0, 1, 2)) if paths is None else paths.candidates.positions
        safe = np.zeros(0, dtype=bool) if paths is None else paths.candidates.safe
        for collection, which in zip(self._paths, (~safe, safe), strict=True):
            collection.set_segments(list(positions[which]))
        self._chosen.set_data(*(empty if paths is None else positions[paths.choice.plan]).T)
        self._chosen.set_color(WARNING if paths is not None and paths.choice.flagged else ROBOT_COLOUR)

    def _show_events(self, sample: int) -> None:
        since = slice(max(0, sample - _GLOW + 1), sample + 1)
        hit = bool(self.game.collision[since].any())
        scored = sample > 0 and self.score[sample] > self.score[max(0, sample - _GLOW)]
        self._frame.set_visible(hit or bool(scored))
        self._frame.set_edgecolor(WARNING if hit else INK)
        count = int(self.collisions[sample])
        self._count.set_text(f"{self.score[sample]} points, {count} collision{'' if count == 1 else 's'}")
        self._count.set_color(WARNING if hit else INK)
        self._clock.set_text(f"{float(self.game.time[sample]):.1f} s")


def _set_bars(bars: list[Rectangle], probability: Float[np.ndarray, " goal"]) -> None:
    for bar, share in zip(bars, probability.tolist(), strict=True):
        bar.set_height(0.88 * share)


def _title(log: xr.Dataset) -> str:
    if "controller" not in log:
        return str(log["trial_id"].values[0])
    names = zip(log["agent"].values.tolist(), log["controller"].values[0].tolist(), strict=True)
    return " · ".join(f"{agent}: {name}" if name else str(agent) for agent, name in reversed(list(names)))
