"""One look for all pictures: colours that colour-blind readers can tell apart, and quiet axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Okabe and Ito's palette without its yellow, which fades on white, and without black, which is kept for text
GOAL_COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#7A5195")
INK = "#222222"
MUTED = "#767676"
FAINT = "#D9D9D9"
WARNING = "#B22222"
# agents keep their colours in every picture; goals that are drawn among agents have the others
AGENT_COLOURS = (GOAL_COLOURS[0], GOAL_COLOURS[1])
ROBOT_COLOUR, HUMAN_COLOUR = AGENT_COLOURS
_AMONG_AGENTS = tuple(colour for colour in GOAL_COLOURS if colour not in AGENT_COLOURS)


def goal_colour(index: int) -> str:
    """Return the colour of a goal by its index; it repeats after seven goals.

    Examples
    --------
    >>> goal_colour(0) == goal_colour(7)
    True
    """
    return GOAL_COLOURS[index % len(GOAL_COLOURS)]


def goal_dashes(index: int) -> str:
    """Return a line style that tells apart goals whose colours repeat.

    Examples
    --------
    >>> goal_dashes(0), goal_dashes(7)
    ('-', '--')
    """
    return ("-", "--", ":", "-.")[index // len(GOAL_COLOURS) % 4]


def goal_colour_among_agents(index: int) -> str:
    """Return the colour of a goal in a picture where agents have colours too; it repeats after five goals.

    Examples
    --------
    >>> goal_colour_among_agents(0) in AGENT_COLOURS
    False
    """
    return _AMONG_AGENTS[index % len(_AMONG_AGENTS)]


def goal_dashes_among_agents(index: int) -> Literal["-", "--", ":", "-."]:
    """Return a line style that tells apart goals whose colours among agents repeat.

    Examples
    --------
    >>> goal_dashes_among_agents(4), goal_dashes_among_agents(5)
    ('-', '--')
    """
    dashes: tuple[Literal["-", "--", ":", "-."], ...] = ("-", "--", ":", "-.")
    return dashes[index // len(_AMONG_AGENTS) % 4]


def new_axes(width: float = 6.4, height: float = 3.2) -> Axes:
    """Return the axes of a new figure of this size in inches, which no global state holds on to."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained").subplots()


def quiet(ax: Axes) -> None:
    """Leave out what does not carry data: the upper and right edge, heavy ticks."""
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        ax.spines[side].set_color(MUTED)
    ax.tick_params(colors=MUTED, labelcolor=INK, labelsize="small")
    ax.xaxis.label.set_color(INK)
    ax.yaxis.label.set_color(INK)
    ax.title.set_color(INK)
