"""What logs call things, as plain text in pictures: never markup, never a missing glyph, never without end."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from functools import lru_cache
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from ppinfer.errors import printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.text import Text

_P = ParamSpec("_P")
_T = TypeVar("_T")
_ALWAYS = 0x250
"""Letters below this (Latin, with accents) are in every font that Matplotlib may find."""
_MOST = 120
_MOST_ON_AXIS = 40


def label(text: object, *, most: int = _MOST_ON_AXIS) -> str:
    r"""Return what a log calls something as a picture shows it.

    What acts on a terminal, and letters that none of the fonts in use has, are written as Python writes them, so that
    two names stay two; of a long line the beginning and the end are shown.

    Parameters
    ----------
    text : object
        A goal, a participant, a condition, a column.
    most : int
        The most letters of a line that are shown.

    Examples
    --------
    >>> print(label("cup\t1"), label("robot " * 20, most=16))
    cup\t1 robot robo…robot
    """
    shown = printable(str(text), keep="\n")
    if any(ord(letter) >= _ALWAYS for letter in shown):
        known = _known_letters(_fonts_in_use())
        shown = "".join(letter if ord(letter) in known else _escaped(letter) for letter in shown)
    return "\n".join(_shortened(line, most) for line in shown.split("\n"))


def _shortened(line: str, most: int) -> str:
    if len(line) <= most:
        return line
    end = most // 3
    return f"{line[: most - end - 1]}…{line.rstrip()[-end:]}"


def _escaped(letter: str) -> str:
    # line ends stay: a picture may have them
    return letter if letter == "\n" else letter.encode("ascii", "backslashreplace").decode("ascii")


def draws_plain_text(draw: Callable[_P, _T]) -> Callable[_P, _T]:
    """Have a function that returns axes draw all of their text as it is (see `as_plain_text`).

    Examples
    --------
    >>> from ppinfer.plots.palette import new_axes
    >>> @draws_plain_text
    ... def plot_name(name):
    ...     ax = new_axes()
    ...     ax.set_title(name)
    ...     return ax
    >>> plot_name("$x^$").title.get_parse_math()
    False
    """

    @functools.wraps(draw)
    def drawn(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        made = draw(*args, **kwargs)
        for ax in _axes_of(made):
            as_plain_text(ax)
            for legend in ax.figure.legends:
                for text in legend.get_texts():
                    as_plain(text)
        return made

    return drawn


def _axes_of(made: object) -> Iterable[Axes]:
    import numpy as np
    from matplotlib.axes import Axes

    if isinstance(made, Axes):
        return [made]
    if isinstance(made, list | tuple | np.ndarray):
        return [ax for one in made for ax in _axes_of(one)]
    return []


def as_plain_text(ax: Axes) -> None:
    """Turn all text of some axes, their legend and their ticks into text: no formulas, no missing glyphs.

    The numbers of axes that are not linear stay, since Matplotlib writes them as formulas.

    Examples
    --------
    >>> from ppinfer.plots.palette import new_axes
    >>> ax = new_axes()
    >>> _ = ax.set_title("$x^$"), ax.set_xticks([0, 1], labels=["a", "b$$"])
    >>> as_plain_text(ax)
    >>> ax.figure.canvas.draw()
    """
    from matplotlib.text import Text

    numbers: set[int] = set()
    for axis in (ax.xaxis, ax.yaxis):
        if axis.get_scale() == "linear":
            _plain_ticks(axis)
        ticks = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
        numbers |= {id(text) for tick in ticks for text in (tick.label1, tick.label2)}
    for text in ax.findobj(Text):
        if id(text) not in numbers:
            as_plain(text)


def as_plain(text: Text, *, most: int = _MOST) -> None:
    """Turn one text of a picture into the text that it is.

    Examples
    --------
    >>> from matplotlib.text import Text
    >>> text = Text(text="cup $1$")
    >>> as_plain(text)
    >>> text.get_parse_math()
    False
    """
    text.set_parse_math(False)
    if (shown := label(text.get_text(), most=most)) != text.get_text():
        text.set_text(shown)


def _plain_ticks(axis: Axis) -> None:
    from matplotlib.ticker import FixedLocator

    if isinstance(axis.get_major_locator(), FixedLocator):
        named = [text.get_text() for text in axis.get_majorticklabels()]
        if (shown := [label(name) for name in named]) != named:
            axis.set_ticks(axis.get_majorticklocs(), labels=shown)
    for tick in axis.get_major_ticks():
        tick.label1.set_parse_math(False)


def _fonts_in_use() -> tuple[tuple[str, ...], ...]:
    """Return the families that text is drawn in; of the names of each, the first that is installed is taken."""
    import matplotlib as mpl

    fonts = {
        "serif": mpl.rcParams["font.serif"],
        "sans-serif": mpl.rcParams["font.sans-serif"],
        "cursive": mpl.rcParams["font.cursive"],
        "fantasy": mpl.rcParams["font.fantasy"],
        "monospace": mpl.rcParams["font.monospace"],
    }
    return tuple(tuple(fonts.get(family, [family])) for family in mpl.rcParams["font.family"])


@lru_cache(maxsize=8)
def _known_letters(families: tuple[tuple[str, ...], ...]) -> frozenset[int]:
    from matplotlib.font_manager import FontProperties, findfont, get_font

    known: set[int] = set()
    for names in families:
        # finds the first of them that there is, else Matplotlib's own
        known |= set(get_font(findfont(FontProperties(family=list(names)))).get_charmap())
    return frozenset(known)
