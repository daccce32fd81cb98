"""The laws of equilibria, to be called on one's own games and on one's own ways of finding equilibria.

Each returns nothing, and raises an `AssertionError` that names the law and the profile.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import product
from typing import TypeAlias

from ppinfer.distributions import Factor
from ppinfer.distributions.axis import Label
from ppinfer.games import Game, pure_equilibria
from ppinfer.testing.agreement import TOLERANCE, agree, at_cell, magnitude_of

OfGame: TypeAlias = Callable[[Game], Factor]
"""An operation from a game to a factor over its axes."""


def check_pure_equilibria(game: Game, *, find: OfGame = pure_equilibria) -> None:
    """Check that exactly the pure equilibria are marked: none is missed and none is added.

    Every deviation of every player is looked at, one after another, so keep the game small.

    Parameters
    ----------
    game : Game
        Of any number of players, with any batch axes.
    find : callable
        The operation that is checked.

    Examples
    --------
    >>> check_pure_equilibria(Game([[[1.0, 2.0]], [[3.0, 3.0]]], ["robot", "human"]))
    """
    marked = find(game).align(*game.axes).log_values
    lead = len(game.batch)
    for cell in product(*(range(len(axis)) for axis in game.axes)):
        if not (marked[cell] == 0.0 or marked[cell] == -math.inf):
            raise AssertionError(f"equilibrium: the mark at {at_cell(game.axes, cell)} is neither 1 nor 0")
        exists = game.present is None or bool(game.present[cell])
        better = _better_reply(game, cell) if exists else None
        if (marked[cell] == 0.0) != (exists and better is None):
            why = (
                "does not exist"
                if not exists
                else f"has a better reply: {at_cell(game.axes[lead:], better[lead:])}"
                if better is not None
                else "is an equilibrium"
            )
            verb = "is marked" if marked[cell] == 0.0 else "is not marked"
            raise AssertionError(f"equilibrium: {at_cell(game.axes, cell)} {verb}, but {why}")


def _better_reply(game: Game, cell: tuple[int, ...]) -> tuple[int, ...] | None:
    """Return the first profile that is better for the one player whose plan differs; None if there is none."""
    lead = len(game.batch)
    for player in range(len(game.players)):
        for plan in range(len(game.plans[player])):
            other = (*cell[: lead + player], plan, *cell[lead + player + 1 :])
            if game.present is not None and not game.present[other]:
                continue
            own = game.costs[(*cell[:lead], player, *cell[lead:])]
            if game.costs[(*other[:lead], player, *other[lead:])] < own:
                return other
    return None


def check_game_relabelling(
    operation: OfGame, game: Game, axis: str, labels: Sequence[Label], *, tolerance: float = TOLERANCE
) -> None:
    """Check that permuting the plans of a player, or the games of a batch, permutes the answer and nothing else.

    Parameters
    ----------
    operation : callable
        From a game to a factor over its axes.
    game : Game
        What it takes.
    axis : str
        The axis whose labels are permuted.
    labels : sequence of labels
        All labels of that axis, in another order.
    tolerance : float
        Relative to the largest log value.

    Examples
    --------
    >>> game = Game([[[1.0, 2.0]], [[3.0, 4.0]]], ["robot", "human"])
    >>> check_game_relabelling(pure_equilibria, game, "human_plan", [1, 0])
    """
    answer = operation(game)
    agree(
        f"relabelling: the answer for {axis!r} relabelled (left) and the answer, relabelled",
        operation(game.restrict(**{axis: labels})),
        answer.restrict(**{axis: labels}),
        magnitude_of(answer),
        tolerance,
    )


def check_player_order(
    operation: OfGame, game: Game, order: Sequence[int], *, tolerance: float = TOLERANCE
) -> None:
    """Check that the order in which the players are named makes no difference.

    Parameters
    ----------
    operation : callable
        From a game to a factor over its axes.
    game : Game
        What it takes.
    order : sequence of int
        The positions of all players, in another order.
    tolerance : float
        Relative to the largest log value.

    Examples
    --------
    >>> check_player_order(pure_equilibria, Game([[[1.0, 2.0]], [[3.0, 4.0]]], ["robot", "human"]), [1, 0])
    """
    lead = len(game.batch)
    assert sorted(order) == list(range(len(game.players))), "order names every player once"
    dimensions = [*range(lead), *(lead + player for player in order)]
    costs = game.costs.take(list(order), axis=lead)
    costs = costs.transpose(*range(lead), lead, *(lead + 1 + player for player in order))
    other = Game(
        costs,
        [game.players[player] for player in order],
        [game.plans[player] for player in order],
        game.batch,
        None if game.present is None else game.present.transpose(dimensions),
    )
    answer = operation(game)
    agree(
        "player order: the answer for the players in another order (left) and the answer",
        operation(other).align(*answer.axes),
        answer,
        magnitude_of(answer),
        tolerance,
    )


def check_game_batch_equals_loop(
    operation: OfGame, game: Game, axis: str, *, tolerance: float = TOLERANCE
) -> None:
    """Check that a batch of games gives what a Python loop over them gives.

    Parameters
    ----------
    operation : callable
        From a game to a factor over its axes.
    game : Game
        With the batch axis.
    axis : str
        The batch axis.
    tolerance : float
        Relative to the largest log value.

    Examples
    --------
    >>> from ppinfer import Axis
    >>> costs = np.arange(12.0).reshape(3, 2, 1, 2)
    >>> game = Game(costs, ["robot", "human"], batch=[Axis("trial", 3)])
    >>> check_game_batch_equals_loop(pure_equilibria, game, "trial")
    """
    answer = operation(game)
    batch = next(one for one in game.batch if one.name == axis)
    for label in batch.labels:
        agree(
            f"batch = loop: the batch at {axis}={label!r} (left) and the loop",
            answer.restrict(**{axis: label}),
            operation(game.restrict(**{axis: label})),
            magnitude_of(answer),
            tolerance,
        )
