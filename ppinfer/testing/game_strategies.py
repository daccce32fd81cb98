"""Hypothesis strategies for games, awkward ones first: ties, infinities, profiles that do not exist, one plan only.

Install the extra ``ppinfer[test]`` for Hypothesis.
"""

from __future__ import annotations

import math

import numpy as np

from ppinfer.distributions import Axis
from ppinfer.games import Game

try:
    from hypothesis import strategies as st
    from hypothesis.extra.numpy import arrays
except ImportError as error:  # pragma: no cover
    raise ImportError(
        "ppinfer.testing.game_strategies needs Hypothesis: install the extra with `pip install 'ppinfer[test]'`"
    ) from error

PLAYERS = ("robot", "human", "guest", "Player 4", "5")
"""Names that generated players take, not all of them identifiers."""


def costs(*, infinities: bool = True) -> st.SearchStrategy[float]:
    """Return costs: whole ones that tie often, both zeros, nearly equal ones, huge ones, and (if asked) inf.

    Parameters
    ----------
    infinities : bool
        Whether inf is among them.

    Examples
    --------
    >>> from ppinfer.testing.game_strategies import costs
    >>> costs(infinities=False)  # doctest: +ELLIPSIS
    one_of(...)
    """
    kinds = [
        st.integers(0, 3).map(float),
        st.sampled_from([-0.0, 1.0 + 2**-52, 1e300, -1e300, 5e-324]),
        st.floats(-1e3, 1e3),
    ]
    if infinities:
        kinds.insert(0, st.just(math.inf))
    return st.one_of(kinds)


@st.composite
def games(
    draw: st.DrawFn,
    *,
    min_players: int = 1,
    max_players: int = 3,
    max_plans: int = 4,
    max_batch: int = 1,
    infinities: bool = True,
    absent: bool = True,
) -> Game:
    """Draw a game, or a batch of games.

    Parameters
    ----------
    min_players, max_players : int
        How many players, up to 5.
    max_plans : int
        The most plans a player has.
    max_batch : int
        The most batch axes, up to 2.
    infinities : bool
        Whether costs may be infinite.
    absent : bool
        Whether profiles may be absent.

    Examples
    --------
    >>> from hypothesis import given
    >>> from ppinfer.testing.game_strategies import games
    >>> @given(games(min_players=2, max_players=2))
    ... def holds(game):
    ...     assert game.players == ("robot", "human")
    >>> holds()
    """
    players = PLAYERS[: draw(st.integers(min_players, max_players))]
    sizes = [draw(st.integers(1, max_plans)) for _ in players]
    names = ("trial", "replan")[: draw(st.integers(0, max_batch))]
    batch = [Axis(name, draw(st.integers(1, 3))) for name in names]
    lead = tuple(len(axis) for axis in batch)
    table = draw(
        arrays(
            np.float64,
            (*lead, len(players), *sizes),
            elements=costs(infinities=infinities),
            fill=st.nothing(),
        )
    )
    present = None
    if absent and draw(st.booleans()):
        present = draw(arrays(np.bool_, (*lead, *sizes)))
    return Game(table, players, batch=batch, present=present)
