"""What to say to somebody who gave a name that nothing has."""

from __future__ import annotations

import difflib
from collections.abc import Sequence


def choices(given: str, known: Sequence[str]) -> str:
    """Return the names there are, and the one that was probably meant.

    Examples
    --------
    >>> choices("distnce", ["motion", "distance"])
    "one of motion, distance; did you mean 'distance'?"
    """
    close = difflib.get_close_matches(given, known, n=1)
    listed = f"one of {', '.join(known)}" if known else "none"
    return f"{listed}; did you mean {close[0]!r}?" if close else listed
