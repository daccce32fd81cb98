"""How tables show a mean with its standard error, and a difference with its interval."""

from __future__ import annotations

import math


def with_sem(mean: float, sem: float, digits: int) -> str:
    """Return a mean and its standard error, if it has one: one scene says nothing of how scenes differ.

    Examples
    --------
    >>> with_sem(1.5, 0.25, 2), with_sem(1.5, float("nan"), 1)
    ('1.50 ± 0.25', '1.5')
    """
    return f"{mean:.{digits}f}" + (f" ± {sem:.{digits}f}" if math.isfinite(sem) else "")


def with_interval(mean: float, low: float, high: float, digits: int = 3) -> str:
    """Return a difference and its interval, if there is one.

    Examples
    --------
    >>> with_interval(0.5, 0.25, 0.75, 2)
    '+0.50 [+0.25, +0.75]'
    """
    interval = f" [{low:+.{digits}f}, {high:+.{digits}f}]" if math.isfinite(low) else ""
    return f"{mean:+.{digits}f}{interval}"
