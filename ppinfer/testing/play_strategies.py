"""Hypothesis strategies for parallel play: situations and whole trials, awkward ones among them.

Install the extra ``ppinfer[test]`` for Hypothesis.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ppinfer.coordination import PlayHistory, Situation
from ppinfer.testing.example_play import example_trial

try:
    from hypothesis import strategies as st
except ImportError as error:  # pragma: no cover
    raise ImportError(
        "ppinfer.testing.play_strategies needs Hypothesis: install the extra with `pip install 'ppinfer[test]'`"
    ) from error

AGENTS = ("robot", "human", "guest")
"""Names that agents take."""


@st.composite
def play_trials(
    draw: st.DrawFn, *, agents: Sequence[int] = (2, 3), max_replans: int = 5, max_plans: int = 6
) -> list[Situation]:
    """Draw the situations of one trial, each with the motion since the one before.

    There are sets of one plan, profiles that all collide or none, plans that tie, steps that are held, and agents who
    have left.

    Parameters
    ----------
    agents : sequence of int
        How many agents there may be.
    max_replans, max_plans : int
        At most so many situations, and plans of one agent.

    Examples
    --------
    >>> from hypothesis import given
    >>> @given(play_trials(agents=(2,), max_replans=2))
    ... def test(trial):
    ...     assert trial[0].motion is None
    >>> test()
    """
    count = draw(st.sampled_from(list(agents)))
    # three agents of many plans each make large games
    largest = max_plans if count == 2 else min(3, max_plans)
    return example_trial(
        np.random.default_rng(draw(st.integers(0, 2**32 - 1))),
        replans=draw(st.integers(1, max_replans)),
        agents=AGENTS[:count],
        plans=tuple(draw(st.integers(1, largest)) for _ in range(count)),
        colliding=draw(st.sampled_from([0.3, 0.0, 0.7, 1.0])),
        held=draw(st.sampled_from([0.0, 0.2, 1.0])),
        leaves=draw(st.sampled_from([False, False, False, True])),
        durations=draw(st.sampled_from([(), (), (1.0, 2.0), (1.0,)])),
    )


def situations(*, agents: Sequence[int] = (2, 3), max_plans: int = 6) -> st.SearchStrategy[Situation]:
    """Draw a situation, the last one of a short trial.

    Parameters
    ----------
    agents, max_plans
        As `play_trials` takes them.

    Examples
    --------
    >>> from hypothesis import given
    >>> @given(situations(agents=(2,), max_plans=2))
    ... def test(situation):
    ...     assert len(situation.agents) == 2
    >>> test()
    """
    return play_trials(agents=agents, max_replans=2, max_plans=max_plans).map(lambda trial: trial[-1])


@st.composite
def histories(
    draw: st.DrawFn,
    *,
    ego: str = "robot",
    agents: Sequence[int] = (2, 3),
    max_trials: int = 3,
    max_replans: int = 5,
    max_plans: int = 6,
) -> PlayHistory:
    """Draw the history of a few trials as one agent saw them.

    Parameters
    ----------
    ego : str
        Whose view it is.
    agents, max_replans, max_plans
        As `play_trials` takes them.
    max_trials : int
        At most so many trials, all with the same agents.

    Examples
    --------
    >>> from hypothesis import given
    >>> @given(histories(agents=(2,), max_trials=1))
    ... def test(history):
    ...     assert len(history.row_size) == 1
    >>> test()
    """
    count = draw(st.sampled_from(list(agents)))
    one = play_trials(agents=(count,), max_replans=max_replans, max_plans=max_plans)
    return PlayHistory.from_situations(draw(st.lists(one, min_size=1, max_size=max_trials)), ego)
