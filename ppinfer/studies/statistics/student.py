"""Student's t of means against zero: what pairs of levels and slopes over rounds are judged by."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True, eq=False)
class StudentTests:
    """Some means over subjects, each against zero.

    Parameters
    ----------
    subjects
        How many there are.
    mean, sd
        Mean and standard deviation of each statistic, exactly zero where they are no more than rounding.
    t, p
        Student's t with ``subjects - 1`` degrees of freedom, and its two-sided p. Where all subjects have the same
        value t is infinite and p 0; where that value is zero both are NaN.

    Examples
    --------
    >>> tests = student_tests(np.array([[1.0, 2.0], [3.0, 2.0]]))
    >>> tests.mean.tolist(), tests.t.tolist(), tests.half_width(0.95).round(3).tolist()
    ([2.0, 2.0], [2.0, inf], [12.706, 0.0])
    """

    subjects: int
    mean: Float[np.ndarray, " statistic"]
    sd: Float[np.ndarray, " statistic"]
    t: Float[np.ndarray, " statistic"]
    p: Float[np.ndarray, " statistic"]

    def half_width(self, level: float, *, together: int = 1) -> Float[np.ndarray, " statistic"]:
        """Return half the width of the confidence interval of each mean.

        Parameters
        ----------
        level
            The probability that an interval holds its mean; if ``together`` is more than 1, that so many intervals all
            hold theirs is at least as probable (Bonferroni).
        together
            How many intervals are looked at together.
        """
        from scipy.special import stdtrit

        quantile = float(stdtrit(self.subjects - 1, 1 - (1 - level) / 2 / together))
        return quantile / math.sqrt(self.subjects) * self.sd


def student_tests(values: Float[np.ndarray, "subject statistic"], *, noise: float = 0.0) -> StudentTests:
    """Test the mean of each column against zero.

    Parameters
    ----------
    values
        One row a subject, at least 2; differences or slopes, in their own units.
    noise
        What rounding alone leaves of a value that is zero in exact arithmetic: means and standard deviations up to it
        are zero.

    Examples
    --------
    >>> tests = student_tests(np.array([[1.2], [2.4], [1.3], [1.3], [0.0], [1.0], [1.8], [0.8], [4.6], [1.4]]))
    >>> tests.t.round(4).tolist(), tests.p.round(6).tolist()
    ([4.0621], [0.002833])
    """
    from scipy.special import stdtr

    n = len(values)
    mean, sd = values.mean(axis=0), values.std(axis=0, ddof=1)
    mean, sd = np.where(np.abs(mean) > noise, mean, 0.0), np.where(sd > noise, sd, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = mean / sd * math.sqrt(n)
    return StudentTests(n, mean, sd, t, 2 * stdtr(n - 1, -np.abs(t)))
