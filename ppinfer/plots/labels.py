"""Labels from logs as plain text in pictures: never markup, never longer than there is room, never a missing glyph."""

from __future__ import annotations

from functools import lru_cache

from ppinfer.errors import printable

_ALWAYS = 0x250
"""Letters below this (Latin, with accents) are in every font that Matplotlib may find."""


def label(text: object, *, most: int = 40) -> str:
    r"""Return what a log calls something as Matplotlib is to draw it: as the text that it is.

    A dollar sign is escaped, since two of them would begin a formula; what acts on a terminal or breaks the line, and
    letters that none of the fonts in use has, are written as Python writes them, so that two names stay two; of a long
    name the beginning and the end are shown.

    Parameters
    ----------
    text : object
        A goal, a participant, a condition, a column.
    most : int
        The most letters that are shown.

    Examples
    --------
    >>> print(label("p$1$"), label("cup\n"), label("robot " * 20, most=16))
    p\$1\$ cup\n robot robo…robot
    """
    shown = printable(str(text)).replace("\n", "\\n")
    if any(ord(letter) >= _ALWAYS for letter in shown):
        known = _known_letters(_fonts_in_use())
        shown = "".join(letter if ord(letter) in known else _escaped(letter) for letter in shown)
    if len(shown) > most:
        shown = shown.strip()
    if len(shown) > most:
        end = most // 3
        shown = f"{shown[: most - end - 1]}…{shown[-end:]}"
    # legends leave out what begins with an underscore
    return (f" {shown}" if shown.startswith("_") else shown).replace("$", r"\$")


def _escaped(letter: str) -> str:
    return letter.encode("ascii", "backslashreplace").decode("ascii")


def _fonts_in_use() -> tuple[tuple[str, ...], ...]:
    """Return the families that text is drawn in; of the names of each, the first that is installed is taken."""
    import matplotlib as mpl

    generic = ("serif", "sans-serif", "cursive", "fantasy", "monospace")
    return tuple(
        tuple(mpl.rcParams[f"font.{family}"]) if family in generic else (family,)
        for family in mpl.rcParams["font.family"]
    )


@lru_cache(maxsize=8)
def _known_letters(families: tuple[tuple[str, ...], ...]) -> frozenset[int]:
    from matplotlib.font_manager import FontProperties, findfont, get_font

    known: set[int] = set()
    for names in families:
        # finds the first of them that there is, else Matplotlib's own
        known |= set(get_font(findfont(FontProperties(family=list(names)))).get_charmap())
    return frozenset(known)
