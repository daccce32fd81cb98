"""Hypothesis strategies for evidence about goals."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from ppinfer.goals import GoalEvidence, PartnerMotion

DT = 0.1
_COORDINATES = st.integers(-80, 80).map(lambda number: number / 8)


@st.composite
def goal_evidences(
    draw: st.DrawFn,
    *,
    max_rows: int = 3,
    max_samples: int = 6,
    max_goals: int = 4,
    dropouts: bool = True,
    partners: int = 0,
) -> GoalEvidence:
    """Draw evidence: rows in the plane, goals that may be absent, dropouts, gaps in time, logged motion or none.

    Parameters
    ----------
    max_rows, max_samples, max_goals : int
        At most so many rows, samples a row, and goals.
    dropouts : bool
        Whether samples may be missing.
    partners : int
        At most so many other agents, and at least one; 0 for none. They are missing at samples of their own.

    Examples
    --------
    >>> from hypothesis import given
    >>> @given(goal_evidences(max_rows=1))
    ... def test(evidence):
    ...     assert evidence.rows == 1
    >>> test()
    """
    rows = draw(st.integers(1, max_rows))
    row_size = np.array(
        draw(st.lists(st.integers(1, max_samples), min_size=rows, max_size=rows)), dtype=np.int64
    )
    samples = int(row_size.sum())
    goals = draw(st.integers(1, max_goals))

    def plane(count: int) -> np.ndarray:
        flat = draw(st.lists(_COORDINATES, min_size=2 * count, max_size=2 * count))
        return np.array(flat, dtype=np.float64).reshape(count, 2)

    flags = st.lists(st.booleans(), min_size=rows * goals, max_size=rows * goals)
    present = np.array(draw(flags)).reshape(rows, goals)
    present[np.arange(rows), draw(st.lists(st.integers(0, goals - 1), min_size=rows, max_size=rows))] = True
    observed = np.ones(samples, dtype=bool)
    if dropouts:
        observed = np.array(draw(st.lists(st.booleans(), min_size=samples, max_size=samples)))
    gaps = np.array(draw(st.lists(st.integers(1, 2), min_size=samples, max_size=samples)), dtype=np.float64)
    position = np.where(observed[:, None], plane(samples), np.nan)
    logged = draw(st.booleans())
    return GoalEvidence(
        time=np.cumsum(gaps * DT),
        position=position,
        goals=plane(rows * goals).reshape(rows, goals, 2),
        row_size=row_size,
        goal_labels=tuple(f"goal {goal}" for goal in range(goals)),
        observed=observed,
        present=present,
        velocity=plane(samples) if logged else None,
        control=plane(samples) if logged else None,
        control_order=draw(st.sampled_from([1, 2])),
        time_step=DT,
        partners=tuple(
            draw(_partner_motions(f"partner {index}", samples, dropouts=dropouts))
            for index in range(draw(st.integers(1, partners)) if partners else 0)
        ),
    )


@st.composite
def _partner_motions(draw: st.DrawFn, name: str, samples: int, *, dropouts: bool) -> PartnerMotion:
    flat = st.lists(_COORDINATES, min_size=2 * samples, max_size=2 * samples)
    position = np.array(draw(flat), dtype=np.float64).reshape(samples, 2)
    observed = np.ones(samples, dtype=bool)
    if dropouts:
        observed = np.array(draw(st.lists(st.booleans(), min_size=samples, max_size=samples)))
    velocity = np.array(draw(flat), dtype=np.float64).reshape(samples, 2) if draw(st.booleans()) else None
    return PartnerMotion(name, np.where(observed[:, None], position, np.nan), observed, velocity)
