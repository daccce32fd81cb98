"""Types of command-line arguments: what is out of range is a mistake in the arguments (exit status 2)."""

from __future__ import annotations

import argparse
import math


def whole_number(text: str) -> int:
    """Return a whole number that is not negative.

    Examples
    --------
    >>> whole_number("3")
    3
    """
    try:
        number = int(text)
    except ValueError:
        number = -1
    if number < 0:
        raise argparse.ArgumentTypeError(f"expected a whole number, 0 or more; got {text!r}")
    return number


def share(text: str) -> float:
    """Return a share of a segment: above 0 and at most 1.

    Examples
    --------
    >>> share("0.25")
    0.25
    """
    number = _number(text)
    if not 0 < number <= 1:
        raise argparse.ArgumentTypeError(f"expected a share above 0 and at most 1; got {text!r}")
    return number


def distance(text: str) -> float:
    """Return a distance: finite and not negative.

    Examples
    --------
    >>> distance("2.5")
    2.5
    """
    number = _number(text)
    if not 0 <= number < math.inf:
        raise argparse.ArgumentTypeError(f"expected a distance, 0 or more; got {text!r}")
    return number


def positive_number(text: str) -> float:
    """Return a number above 0.

    Examples
    --------
    >>> positive_number("0.707")
    0.707
    """
    number = _number(text)
    if not 0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"expected a number above 0; got {text!r}")
    return number


def one_character(text: str) -> str:
    r"""Return what separates cells: one character, or a tab by its name.

    Examples
    --------
    >>> one_character(";"), one_character("tab"), one_character(r"\t")
    (';', '\t', '\t')
    """
    character = "\t" if text in ("tab", "\\t") else text
    if len(character) != 1 or character in '\r\n"':
        raise argparse.ArgumentTypeError(f"expected one character, or tab; got {text!r}")
    return character


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
