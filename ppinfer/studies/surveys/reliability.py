"""Does a scale hang together? Cronbach's alpha, its interval, and what each item does to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class Alpha:
    """Cronbach's alpha of a scale, or why there is none.

    Attributes
    ----------
    responses, items : int
        How many went in: responses that answered every item.
    alpha : float or None
        As in `cronbach_alpha`.
    standardized : float or None
        The same of the items' correlations; None if an item never varies, or standardized items add up to nothing.
    low, high : float or None
        Feldt's interval; None where responses are not independent of one another, or there is no alpha.
    reason : str
        Why there is no alpha or no standardized one; empty if there are both.

    Examples
    --------
    >>> Alpha.of(np.array([[1.0], [2.0], [4.0]])).reason
    'alpha is of two items or more'
    """

    responses: int
    items: int
    alpha: float | None
    standardized: float | None
    low: float | None
    high: float | None
    reason: str = ""

    @classmethod
    def of(
        cls, values: Float[np.ndarray, "response item"], *, independent: bool = True, level: float = 0.95
    ) -> Alpha:
        """Return what can be said of responses that answered every item.

        Parameters
        ----------
        values : (response, item) float64
            After reversing, no NaN.
        independent : bool
            Whether no participant has more than one response; otherwise there is no interval.
        level : float
            Of the interval.
        """
        n, k = values.shape
        reason = why_no_alpha(values)
        if reason:
            return cls(n, k, None, None, None, None, reason)
        alpha = cronbach_alpha(values)
        standardized = standardized_alpha(values)
        if standardized is None:
            constant = bool((np.ptp(values, axis=0) == 0).any())
            why = "an item has the same answer everywhere" if constant else "standardized items cancel out"
            reason = f"no standardized alpha: {why}"
        low: float | None = None
        high: float | None = None
        if independent:
            low, high = feldt_interval(alpha, n, k, level=level)
        return cls(n, k, alpha, standardized, low, high, reason)


def why_no_alpha(values: Float[np.ndarray, "response item"]) -> str:
    """Return why a table of answers has no alpha; empty if it has one.

    Examples
    --------
    >>> why_no_alpha(np.array([[1.0, 3.0], [3.0, 1.0]]))
    'the sum of the items is the same in every response'
    """
    n, k = values.shape
    if k < 2:
        return "alpha is of two items or more"
    if n < 2:
        return f"alpha is of two responses or more that answered every item, here {n}"
    # centred answers add up to 0 but for rounding
    total = values.sum(axis=1)
    if np.ptp(total) <= 1e-12 * max(1.0, float(np.abs(values).max())) * k:
        return "the sum of the items is the same in every response"
    return ""


def cronbach_alpha(values: Float[np.ndarray, "response item"]) -> float:
    r"""Return Cronbach's alpha (Cronbach 1951) of k items.

    .. math:: \alpha = \frac{k}{k - 1} \left(1 - \frac{\sum_i s_i^2}{s_{total}^2}\right)

    with the variances of the items and of their sum. 1 means that all items say the same, 0 that they have nothing in
    common; it is negative if they contradict one another, as an item does that should have been reversed.

    Parameters
    ----------
    values : (response, item) float64
        After reversing, no NaN; two items and two responses at least, whose sums differ (`why_no_alpha`).

    Examples
    --------
    >>> cronbach_alpha(np.array([[1.0, 1.0], [2.0, 2.0], [5.0, 5.0]]))
    1.0
    """
    k = values.shape[1]
    parts = values.var(axis=0, ddof=1).sum()
    total = values.sum(axis=1).var(ddof=1)
    return float(k / (k - 1) * (1 - parts / total))


def standardized_alpha(values: Float[np.ndarray, "response item"]) -> float | None:
    r"""Return the alpha of standardized items, :math:`k \bar r / (1 + (k - 1) \bar r)`; None if an item never varies.

    Examples
    --------
    >>> round(standardized_alpha(np.array([[1.0, 2.0], [2.0, 4.0], [5.0, 10.0]])), 12)
    1.0
    """
    k = values.shape[1]
    if (np.ptp(values, axis=0) == 0).any():
        return None
    mean = (np.corrcoef(values, rowvar=False).sum() - k) / (k * (k - 1))
    below = 1 + (k - 1) * mean
    return None if below <= 1e-12 else float(k * mean / below)


def feldt_interval(alpha: float, responses: int, items: int, *, level: float = 0.95) -> tuple[float, float]:
    r"""Return Feldt's interval (Feldt 1965; Feldt, Woodruff and Salih 1987) of an alpha.

    :math:`(1 - \alpha) / (1 - \hat\alpha)` has an F distribution with :math:`n - 1` and :math:`(n - 1)(k - 1)` degrees
    of freedom if responses are independent and normal, items in parallel.

    Examples
    --------
    >>> low, high = feldt_interval(0.8, 41, 5)
    >>> round(low, 3), round(high, 3)
    (0.684, 0.883)
    """
    from scipy.stats import f

    tail = (1 - level) / 2
    degrees = responses - 1, (responses - 1) * (items - 1)
    high, low = (float(f.ppf(share, *degrees)) for share in (tail, 1 - tail))
    return 1 - (1 - alpha) * low, 1 - (1 - alpha) * high


def item_rest_correlations(
    values: Float[np.ndarray, "response item"],
) -> tuple[float | None, ...]:
    """Return the correlation of each item with the sum of the others; None where either never varies.

    Examples
    --------
    >>> [round(r, 3) for r in item_rest_correlations(np.array([[1.0, 1.0], [2.0, 3.0], [4.0, 5.0]]))]
    [0.982, 0.982]
    """
    n, k = values.shape
    found: list[float | None] = []
    for at in range(k):
        rest = np.delete(values, at, axis=1).sum(axis=1)
        varies = n > 1 and k > 1 and np.ptp(values[:, at]) > 1e-12 and np.ptp(rest) > 1e-12
        found.append(float(np.corrcoef(values[:, at], rest)[0, 1]) if varies else None)
    return tuple(found)


def alphas_if_dropped(values: Float[np.ndarray, "response item"]) -> tuple[float | None, ...]:
    """Return the alpha of the other items for each item; None where they have none.

    Examples
    --------
    >>> alphas_if_dropped(np.array([[1.0, 1.0, 5.0], [2.0, 2.0, 1.0], [5.0, 5.0, 3.0]]))[2]
    1.0
    """
    others = [np.delete(values, at, axis=1) for at in range(values.shape[1])]
    return tuple(None if why_no_alpha(rest) else cronbach_alpha(rest) for rest in others)


def centred_within(
    values: Float[np.ndarray, "response item"], participant: np.ndarray
) -> Float[np.ndarray, "response item"]:
    """Return answers as differences from the participant's own mean of each item.

    Examples
    --------
    >>> centred_within(np.array([[1.0], [3.0], [5.0]]), np.array([0, 0, 1])).ravel().tolist()
    [-1.0, 1.0, 0.0]
    """
    _, who = np.unique(participant, return_inverse=True)
    sums = np.zeros((int(who.max()) + 1 if len(who) else 0, values.shape[1]))
    np.add.at(sums, who, values)
    return values - (sums / np.bincount(who)[:, None])[who]
