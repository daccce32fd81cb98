"""The one family of exceptions: every refusal of ppinfer derives from `PPInferError`."""

from __future__ import annotations


class PPInferError(Exception):
    """Base of every error that ppinfer raises on purpose.

    A message says what was wrong, where (axis, label, trial, sample, file and line), the offending sizes or
    values, and what to do.

    Examples
    --------
    >>> from ppinfer import Axis, PPInferError
    >>> try:
    ...     Axis("goal", ["cup", "cup"])
    ... except PPInferError as error:
    ...     print(type(error).__name__)
    AxisError
    """

    def __str__(self) -> str:
        # messages quote what files hold, and are shown on terminals: one line, of bounded length
        text = printable(super().__str__())
        return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 500]} ... {text[-500:]}"


_LONGEST = 2500


def printable(text: str, *, keep: str = "") -> str:
    r"""Return a text with everything escaped that would act on a terminal instead of being shown.

    Control characters and line ends, what changes the direction of writing, and lone surrogates are written as Python
    writes them.

    Parameters
    ----------
    text
        Any text.
    keep
        Characters that stay as they are, e.g. line ends.

    Examples
    --------
    >>> print(printable("p1 \x1b[31m \u202e, \n and é"))
    p1 \x1b[31m \u202e, \n and é
    """
    if text.isprintable():
        return text
    return "".join(
        letter if letter.isprintable() or letter in keep else repr(letter)[1:-1] for letter in text
    )


class AxisError(PPInferError, ValueError):
    """Axes that are malformed, unknown, or that share a name without sharing their labels."""


class FactorError(PPInferError, ValueError):
    """Values that no factor can hold (NaN, +inf, a wrong shape) or an operation that is undefined on them."""


class ImpossibleEvidenceError(PPInferError, ValueError):
    """Evidence that leaves no hypothesis possible; the message names the cell (trial, sample)."""


class ModelError(PPInferError, ValueError):
    """A model's parameter that is unknown, of the wrong type, or out of its range."""


class LogError(PPInferError, ValueError):
    """A study log, posterior, recording or mapping that cannot be read or is not sound.

    Examples
    --------
    >>> from ppinfer.errors import LogError
    >>> raise LogError("trials.csv: line 3: column 'x': expected a number, got 'abc'")
    Traceback (most recent call last):
        ...
    ppinfer.errors.LogError: trials.csv: line 3: column 'x': expected a number, got 'abc'
    """


class GameError(PPInferError, ValueError):
    """A game whose players, plans and costs do not fit each other, or a question that it has no answer to."""


class GameFileError(GameError):
    """A game file that cannot be read; the message names file, line and column."""


class SafetyError(PPInferError, ValueError):
    """Agents, distances or probabilities from which no statement about safety follows; the message says why."""
