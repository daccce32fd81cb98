"""The answers to an item, or the scores on a scale, under one condition, in some numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ppinfer.studies.resampling import mean_and_cluster_se


@dataclass(frozen=True)
class Summary:
    """Some numbers of the answers to an item, or of the scores on a scale, under one condition.

    Attributes
    ----------
    name, condition : str
        The item or scale, and the label of the condition; empty where there are none.
    n, participants, missing : int
        Answers, who gave them, and how many were not given.
    mean, sd, median : float
        Over answers; NaN where there are none (the SD: where there is one).
    sem : float
        Standard error of the mean over participants: SD / sqrt(n) where each answered once.
    counts : dict or None
        How many answered each number; of an item as it was answered, not reversed.

    Examples
    --------
    >>> summary = Summary.of("easy", "a", np.array([4.0, 5.0, np.nan]), np.arange(3), points=range(1, 6))
    >>> summary.n, summary.mean, summary.counts
    (2, 4.5, {1: 0, 2: 0, 3: 0, 4: 1, 5: 1})
    """

    name: str
    condition: str
    n: int
    participants: int
    missing: int
    mean: float
    sd: float
    sem: float
    median: float
    counts: dict[int, int] | None = None

    @classmethod
    def of(
        cls,
        name: str,
        condition: str,
        values: Float[np.ndarray, " response"],
        participant: Int[np.ndarray, " response"],
        *,
        points: range | None = None,
    ) -> Summary:
        """Summarise answers, NaN where there is none."""
        given = ~np.isnan(values)
        answers = values[given]
        who, cluster = np.unique(participant[given], return_inverse=True)
        mean, sem = mean_and_cluster_se(answers, cluster, len(who))
        counts = None
        if points is not None:
            counted = np.bincount(answers.astype(np.int64) - points[0], minlength=len(points))
            counts = dict(zip(points, counted.tolist(), strict=True))
        return cls(
            name,
            condition,
            len(answers),
            len(who),
            int((~given).sum()),
            mean,
            float(answers.std(ddof=1)) if len(answers) > 1 else float("nan"),
            sem,
            float(np.median(answers)) if len(answers) else float("nan"),
            counts,
        )
