"""What commands print: tables for people, one JSON object for machines."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from typing import Any

from ppinfer.errors import printable

_WIDE = 160
# what JSON lets stand in a string though a terminal obeys it, or no encoding can hold it
_ACTING = re.compile("[\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufeff]")


def say(text: str, *, file: Any = None) -> None:
    r"""Print some lines of text, or one to a file; what comes from a log does not act on the terminal.

    Examples
    --------
    >>> say("participant \x1b[31m")
    participant \x1b[31m
    """
    print(printable(text, keep="\n" if file is None else ""), file=file)


def print_json(value: object) -> None:
    """Print one JSON document on standard output; non-finite numbers become null (JSON has none)."""
    text = json.dumps(_finite(value), indent=2, ensure_ascii=False, allow_nan=False)
    print(_ACTING.sub(lambda found: f"\\u{ord(found[0]):04x}", text))


def _finite(value: object) -> object:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a small table; what comes from a log is text, never markup, and nothing in it acts on a terminal."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    def shown(text: str) -> Text:
        return Text(printable(text, keep="\n"))

    table = Table(title=shown(title), title_justify="left", show_header=any(columns))
    for column in columns:
        table.add_column(shown(column))
    for row in rows:
        table.add_row(*map(shown, row))
    console = Console()
    # what is not read on a terminal is not to be wrapped at the width of one
    (console if console.is_terminal else Console(width=_WIDE)).print(table)
