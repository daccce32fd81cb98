"""The words of a Gambit file, each with its place, so that a refusal can name line and column."""

from __future__ import annotations

import math
import re
from typing import NoReturn

from ppinfer.errors import GameFileError

_TOKEN = re.compile(
    r"""
      (?P<text>"(?:[^"\\]|\\.)*")
    | (?P<number>[+-]?(?:[0-9]+/[0-9]+|(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)(?=[\s{},"]|$))
    | (?P<brace>[{}])
    | (?P<comma>,)
    | (?P<open>".*)
    | (?P<word>[^\s{},"]+)
    """,
    re.VERBOSE | re.DOTALL,
)
_SPACE = re.compile(r"\s*")
_MOST_SHOWN = 40


class Tokens:
    r"""A cursor over the words of a file; what is asked for and is not there is a `GameFileError`.

    Parameters
    ----------
    name : str
        What messages call the file.
    text : str
        Its content, with line feeds alone between lines.

    Examples
    --------
    >>> tokens = Tokens("pd.nfg", 'NFG 1 R "A \\"title\\"" 1/3')
    >>> tokens.keyword(("NFG",), "NFG"), tokens.integer(1, "1"), tokens.keyword(("R", "D"), "R or D")
    ('NFG', 1, 'R')
    >>> tokens.label("a title"), tokens.number("a payoff")
    ('A "title"', 0.3333333333333333)
    >>> tokens.at_end()
    True
    """

    def __init__(self, name: str, text: str) -> None:
        self._name, self._text = name, text
        self._advance_to(0)

    def _advance_to(self, position: int) -> None:
        space = _SPACE.match(self._text, position)
        assert space is not None
        self._position = space.end()
        self._match = _TOKEN.match(self._text, self._position)
        self.kind = (self._match and self._match.lastgroup) or "end"

    def _take(self) -> str:
        assert self._match is not None
        taken = self._match.group()
        self._advance_to(self._match.end())
        return taken

    def at_end(self) -> bool:
        """Tell whether nothing is left."""
        return self.kind == "end"

    def refuse(self, expected: str) -> NoReturn:
        """Raise the error that says where we are, what was expected and what is there."""
        if self.kind == "open":
            expected, got = f"{expected}, closed by a second double quote", "the end of the file"
        elif self._match is None:
            got = "the end of the file"
        else:
            got = self._match.group()
            got = got if len(got) <= _MOST_SHOWN else f"{got[:_MOST_SHOWN]}..."
        self.refuse_at(self._position, f"expected {expected}, got {got}")

    def refuse_at(self, position: int, what: str) -> NoReturn:
        """Raise the error about a place, given as an offset into the text."""
        line = self._text.count("\n", 0, position) + 1
        column = position - self._text.rfind("\n", 0, position)
        raise GameFileError(f"{self._name}: line {line}, column {column}: {what}")

    @property
    def position(self) -> int:
        """The offset of the next word."""
        return self._position

    def next_is(self, symbol: str) -> bool:
        """Tell whether the next word is a brace, or ``","``."""
        return self.kind in ("brace", "comma") and self._match is not None and self._match.group() == symbol

    def symbol(self, symbol: str, purpose: str) -> None:
        """Step over a brace."""
        if not self.next_is(symbol):
            self.refuse(f"{symbol} {purpose}")
        self._take()

    def skip_comma(self) -> None:
        """Step over a comma, if there is one."""
        if self.kind == "comma":
            self._take()

    def keyword(self, allowed: tuple[str, ...], what: str) -> str:
        """Return the next word, which must be one of those allowed."""
        if self._match is None or self._match.group() not in allowed:
            self.refuse(what)
        return self._take()

    def label(self, what: str) -> str:
        """Return a string in double quotes, its escapes undone."""
        if self.kind != "text":
            self.refuse(f"{what} in double quotes")
        return re.sub(r'\\(["\\])', r"\1", self._take()[1:-1])

    def integer(self, least: int, what: str) -> int:
        """Return a whole number of at least some value."""
        text = self._match.group() if self._match is not None else ""
        # nothing has so many plans or outcomes, and Python refuses to read numbers of thousands of digits
        if self.kind != "number" or not re.fullmatch(r"[+-]?[0-9]{1,18}", text) or int(text) < least:
            self.refuse(what)
        return int(self._take())

    def number(self, what: str) -> float:
        """Return an integer, decimal or rational as the nearest float."""
        if self.kind != "number":
            self.refuse(what)
        start, text = self._position, self._take()
        try:
            if "/" in text:
                above, below = text.split("/")
                value = int(above) / int(below)  # rounded once
            else:
                value = float(text)
        except ZeroDivisionError:
            self.refuse_at(start, f"expected {what}, got {text}, which divides by zero")
        except (OverflowError, ValueError):  # Python reads integers of at most some thousand digits
            value = math.inf
        if not math.isfinite(value):
            shown = text if len(text) <= _MOST_SHOWN else f"{text[:_MOST_SHOWN]}..."
            self.refuse_at(start, f"expected {what}, got {shown}, which no float can hold")
        return value
