"""Names for participants that say nothing of who they are, nor of where they stood in the table."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence

import numpy as np
from jaxtyping import Float, Int


def pseudonyms(
    participant: Int[np.ndarray, " response"],
    conditions: Sequence[Hashable],
    values: Float[np.ndarray, "response item"],
    *,
    seed: int = 0,
) -> tuple[str, ...]:
    """Return P01, P02, ... for participants, from what they answered and nothing else.

    1. Participants are sorted by their answers (conditions in order, then the numbers; no answer comes first), so that
       neither their names nor the order of the table matters. Those who answered alike can be exchanged.
    2. They are shuffled with ``seed``, so that a low number does not mean low answers.

    A hash of a name would be no pseudonym: whoever has a list of names can hash them all.

    Parameters
    ----------
    participant : (response,) int
        Whose response each is, 0 to n - 1.
    conditions : sequence of n responses
        Under which condition (anything that can be sorted as text).
    values : (response, item) float64
        The answers; NaN where there is none.
    seed : int
        Of the shuffle; it is no secret, since nothing that identifies anybody goes in.

    Returns
    -------
    tuple of str
        A name for each participant.

    Examples
    --------
    >>> answers = np.array([[5.0], [1.0], [3.0]])
    >>> named = pseudonyms(np.arange(3), ["a", "a", "a"], answers)
    >>> turned = pseudonyms(np.arange(3), ["a", "a", "a"], answers[::-1])
    >>> sorted(named), named == turned[::-1]
    (['P01', 'P02', 'P03'], True)
    """
    count = int(participant.max()) + 1 if len(participant) else 0
    answers: list[list[tuple[str, tuple[float, ...]]]] = [[] for _ in range(count)]
    for who, condition, row in zip(participant.tolist(), conditions, values.tolist(), strict=True):
        answers[who].append((str(condition), tuple(-math.inf if math.isnan(cell) else cell for cell in row)))
    ranked = sorted(range(count), key=lambda who: sorted(answers[who]))
    numbers = np.random.default_rng(seed).permutation(count) + 1
    width = max(2, len(str(count)))
    named = {who: f"P{number:0{width}}" for who, number in zip(ranked, numbers.tolist(), strict=True)}
    return tuple(named[who] for who in range(count))
