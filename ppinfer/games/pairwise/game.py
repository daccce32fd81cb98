"""A game coupled by collisions of pairs: what each plan costs its own player, and which plans collide."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from types import MappingProxyType
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from ppinfer.distributions import Axis
from ppinfer.distributions.axis import first_cell
from ppinfer.errors import AxisError, GameError
from ppinfer.games.game import Game, checked_players, plan_axes


@dataclass(frozen=True, eq=False)
class PairwiseGame:
    """N players whose costs depend on their own plans, and who meet only in collisions of pairs.

    In a profile a, player i pays what its own plan costs, c_i(a_i), or inf if its plan collides with the plan of any
    other player. A collision between two others costs it nothing. (With two players both pay inf, always.)

    Parameters
    ----------
    costs : sequence of (plan,) arrays of float
        For each player, what each of its own plans costs, s unless stated otherwise; +inf is allowed.
    collisions : mapping of (player, player) to (plan, plan) arrays of bool
        For a pair, by name or by position, whether a plan of the first collides with a plan of the second. Pairs that
        are left out never collide. A pair given in both orders must say the same twice.
    players : sequence of str
        The players' names.
    plans : sequence of Axis, optional
        One axis of plans for each player; by default ``Axis(f"{player}_plan", k)``.

    Raises
    ------
    GameError
        If the shapes do not fit, players repeat or are unknown, or a cost is NaN or -inf; the message says where.
    AxisError
        If two axes share a name.

    See Also
    --------
    pairwise_equilibria : the equilibria, without the table of all profiles.

    Examples
    --------
    >>> both = [[False, False], [False, True]]
    >>> game = PairwiseGame([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]], {("a", "c"): both}, ["a", "b", "c"])
    >>> game
    PairwiseGame of a, b, c: a_plan 2, b_plan 2, c_plan 2
    >>> game.profile_costs([[0, 0, 0], [1, 0, 1]])
    array([[ 1.,  3.,  5.],
           [inf,  3., inf]])
    """

    costs: tuple[Float[np.ndarray, "_"], ...]
    collisions: Mapping[tuple[int, int], Bool[np.ndarray, "_ _"]]
    players: tuple[str, ...]
    plans: tuple[Axis, ...] = ()

    def __init__(
        self,
        costs: Any,
        collisions: Mapping[Any, Any],
        players: Sequence[str],
        plans: Sequence[Axis] | None = None,
    ) -> None:
        names = checked_players(players)
        own = tuple(_checked_cost(cost, player) for cost, player in zip(costs, names, strict=False))
        if len(costs) != len(names):
            raise GameError(f"there are {len(names)} players ({', '.join(names)}) and costs for {len(costs)}")
        axes = plan_axes(names, [len(cost) for cost in own]) if plans is None else tuple(plans)
        if tuple(map(len, axes)) != tuple(map(len, own)):
            raise GameError(
                f"the plan axes have {tuple(map(len, axes))} labels; the players' costs are of "
                f"{tuple(map(len, own))} plans"
            )
        for first, second in combinations(axes, 2):
            if first.name == second.name:
                raise AxisError(f"two axes of the game are called {first.name!r}; rename one of them")
        for cost, axis in zip(own, axes, strict=True):
            wrong = ~(cost > -np.inf)
            if wrong.any():
                raise GameError(
                    f"the cost is {cost[wrong][0]} at {first_cell([axis], wrong)}; costs are finite or +inf"
                )
        pairs = _checked_collisions(collisions, names, axes)
        for name, value in (("costs", own), ("collisions", pairs), ("players", names), ("plans", axes)):
            object.__setattr__(self, name, value)

    @property
    def shape(self) -> tuple[int, ...]:
        """How many plans each player has."""
        return tuple(map(len, self.plans))

    @property
    def profiles(self) -> int:
        """How many profiles there are: the product of the numbers of plans."""
        return math.prod(self.shape)

    def player(self, name: str) -> int:
        """Return the position of a player; a GameError says who there is.

        Examples
        --------
        >>> PairwiseGame([[1.0], [2.0]], {}, ["robot", "human"]).player("human")
        1
        """
        try:
            return self.players.index(name)
        except ValueError:
            raise GameError(f"there is no player {name!r}; there are {', '.join(self.players)}") from None

    def profile_costs(self, profiles: Any) -> Float[np.ndarray, "profile player"]:
        """Return what profiles cost each player; inf to those who collide.

        Parameters
        ----------
        profiles : (profile, player) int
            Positions of the players' plans.

        Examples
        --------
        >>> game = PairwiseGame([[1.0, 2.0], [3.0, 4.0]], {(0, 1): np.eye(2, dtype=bool)}, ["robot", "human"])
        >>> game.profile_costs([[0, 0], [0, 1]])
        array([[inf, inf],
               [ 1.,  4.]])
        """
        chosen = _checked_profiles(profiles, self)
        paid = np.column_stack([cost[chosen[:, player]] for player, cost in enumerate(self.costs)])
        for (one, other), collide in self.collisions.items():
            hit = collide[chosen[:, one], chosen[:, other]]
            paid[hit, one] = np.inf
            paid[hit, other] = np.inf
        return paid

    def to_game(self) -> Game:
        """Build the table of all profiles; feasible while there are few of them.

        Raises
        ------
        GameError
            If the table would take more than 2 GB.

        Examples
        --------
        >>> PairwiseGame([[1.0, 2.0], [3.0]], {(0, 1): [[True], [False]]}, ["robot", "human"]).to_game().costs[0]
        array([[inf],
               [ 2.]])
        """
        bytes_needed = 8 * len(self.players) * self.profiles
        if bytes_needed > 2_000_000_000:
            raise GameError(
                f"the table of {self.profiles:.3g} profiles and {len(self.players)} players would take "
                f"{bytes_needed / 1e9:.3g} GB; pairwise_equilibria works without it"
            )
        costs = np.empty((len(self.players), *self.shape))
        for player, cost in enumerate(self.costs):
            costs[player] = _along(cost, (player,), costs.ndim - 1)
        for pair, collide in self.collisions.items():
            hit = np.broadcast_to(_along(collide, pair, costs.ndim - 1), self.shape)
            costs[pair[0]][hit] = np.inf
            costs[pair[1]][hit] = np.inf
        return Game(costs, self.players, self.plans)

    def __repr__(self) -> str:
        sizes = ", ".join(f"{axis.name} {len(axis)}" for axis in self.plans)
        return f"PairwiseGame of {', '.join(self.players)}: {sizes}"

    def __reduce__(self) -> tuple[Any, ...]:
        return (PairwiseGame, (self.costs, dict(self.collisions), self.players, self.plans))


def _along(values: np.ndarray, dimensions: tuple[int, ...], ndim: int) -> np.ndarray:
    """Lay an array out over some dimensions (in increasing order) of a grid."""
    return np.expand_dims(values, tuple(i for i in range(ndim) if i not in dimensions))


def _checked_cost(cost: Any, player: str) -> Float[np.ndarray, " plan"]:
    try:
        array = np.array(cost, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise GameError(f"the costs of {player}'s plans must be real numbers: {error}") from None
    if array.ndim != 1 or not len(array):
        raise GameError(
            f"the costs of {player}'s plans must be one number a plan, at least one; got shape {array.shape}"
        )
    array.setflags(write=False)
    return array


def _checked_collisions(
    collisions: Mapping[Any, Any], players: tuple[str, ...], plans: tuple[Axis, ...]
) -> Mapping[tuple[int, int], Bool[np.ndarray, "_ _"]]:
    """Return the tables by position, the lower one first."""
    checked: dict[tuple[int, int], np.ndarray] = {}
    for key, given in collisions.items():
        if not isinstance(key, tuple) or len(key) != 2:
            raise GameError(f"collisions are given for pairs of players, not for {key!r}")
        one, other = (_position(player, players) for player in key)
        if one == other:
            raise GameError(f"collisions of {players[one]} with itself: a pair is of two players")
        collide = np.array(given)
        shape = (len(plans[one]), len(plans[other]))
        if collide.dtype != np.bool_ or collide.shape != shape:
            raise GameError(
                f"collisions of {players[one]} with {players[other]} must be bool of shape {shape}; got "
                f"{collide.dtype} of shape {collide.shape}"
            )
        if one > other:
            one, other, collide = other, one, collide.T
        known = checked.get((one, other))
        if known is not None and not np.array_equal(known, collide):
            cell = first_cell([plans[one], plans[other]], known != collide)
            raise GameError(
                f"collisions of {players[one]} and {players[other]} are given in both orders and differ at {cell}"
            )
        collide.setflags(write=False)
        checked[one, other] = collide
    return MappingProxyType(dict(sorted(checked.items())))


def _position(player: Any, players: tuple[str, ...]) -> int:
    if isinstance(player, str) and player in players:
        return players.index(player)
    if isinstance(player, (int, np.integer)) and 0 <= player < len(players):
        return int(player)
    raise GameError(f"there is no player {player!r}; there are {', '.join(players)}")


def _checked_profiles(profiles: Any, game: PairwiseGame) -> Int[np.ndarray, "profile player"]:
    chosen = np.asarray(profiles)
    if (
        chosen.ndim != 2
        or chosen.shape[1] != len(game.players)
        or not np.issubdtype(chosen.dtype, np.integer)
    ):
        raise GameError(
            f"profiles must be int of shape (profile, {len(game.players)}), one plan for each player; got "
            f"{chosen.dtype} of shape {chosen.shape}"
        )
    wrong = (chosen < 0) | (chosen >= np.array(game.shape))
    if wrong.any():
        row, player = np.argwhere(wrong)[0]
        raise GameError(
            f"profile {row} has plan {chosen[row, player]} of {game.players[player]}, who has {game.shape[player]}"
        )
    return chosen
