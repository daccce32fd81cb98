"""Is a game a potential game? A certificate either way: a potential of every profile, or a cycle that rules it out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float, Int

from ppinfer.errors import GameError
from ppinfer.games.game import Game
from ppinfer.games.improvements import Profile, most_improvements, profile_at


@dataclass(frozen=True, eq=False)
class Potential:
    """What is known of a game's potential: a function of the profile that falls whenever one player does better.

    Attributes
    ----------
    kind : {"exact", "ordinal", "none"}
        ``"exact"``: a deviation changes the potential by what it changes the deviating player's cost. ``"ordinal"``
        (generalised): every improvement lowers it. ``"none"``: some improvements go round in a circle. In both of the
        former, players who improve one at a time come to rest, at a pure equilibrium.
    values : (*plans) float64 or None
        The potential; None where there is none. Exact: in the unit of the costs, inf where the costs are, and free up
        to a constant within each part of the grid that deviations at finite costs connect; its least value there is 0.
        Ordinal: the most steps that improvements can take from the profile on, so 0 at the equilibria. NaN at
        profiles that do not exist.
    defect : float
        The largest difference between a change of the exact potential and of the deviating player's cost: rounding
        if it is exact; and otherwise, by how much the changes around `discrepancy` fail to add up to 0 (inf where
        that is one profile).
    discrepancy : tuple of profiles
        Why there is no exact potential: a closed path of deviations (the last one leads back to the first profile)
        whose changes of the deviating player's cost do not add up to 0; or one profile that costs some players an
        infinite amount and others not. Empty if there is one.
    improvement_cycle : tuple of profiles
        Why there is no ordinal potential either: each profile is better than the one before it for the one player whose
        plan changed, and the first better than the last. Empty if there is one.
    """

    kind: Literal["exact", "ordinal", "none"]
    values: Float[np.ndarray, "..."] | None
    defect: float
    discrepancy: tuple[Profile, ...] = ()
    improvement_cycle: tuple[Profile, ...] = ()

    @property
    def improvements_end(self) -> bool:
        """Whether players who improve one at a time always come to rest (the finite improvement property)."""
        return self.kind != "none"


def potential(game: Game, *, tolerance: float = 1e-9) -> Potential:
    """Return a certificate that a game has an exact potential, a (generalised) ordinal one, or neither.

    1. Exact (Monderer and Shapley): where no cost is infinite, the potential less a player's cost must be constant
       along every line of that player's plans. Costs are added up along deviations, one connected part of the grid
       after another, and then every line is checked. An infinite cost must be infinite for all players at once, as
       it is where it stands for a collision; the potential is infinite there.
    2. Ordinal: the graph of all strict improvements must have no cycle. From an infinite cost to a finite one is an
       improvement; between infinite ones, none.

    Parameters
    ----------
    game : Game
        One game, without batch axes, of any number of players. The graph takes about 20 bytes for each profile and
        plan that a player could improve to.
    tolerance : float
        How far, relative to the largest finite cost, the exact potential may be off.

    Raises
    ------
    GameError
        If the game has batch axes.

    Examples
    --------
    >>> costs = np.array([[[3.0, np.inf], [4.0, 4.0]], [[5.0, np.inf], [5.0, 2.0]]])
    >>> potential(Game(costs, ["robot", "human"])).values
    array([[ 2., inf],
           [ 3.,  0.]])
    >>> pennies = Game([[[0.0, 1.0], [1.0, 0.0]], [[1.0, 0.0], [0.0, 1.0]]], ["even", "odd"])
    >>> potential(pennies).improvement_cycle
    ((0, 0), (0, 1), (1, 1), (1, 0))
    """
    if game.batch:
        names = ", ".join(axis.name for axis in game.batch)
        raise GameError(
            f"a potential is sought for one game, but this has batch axes ({names}); restrict({names}=...) picks one"
        )
    values, defect, discrepancy = _exact(game, tolerance)
    if not discrepancy:
        return Potential("exact", _frozen(values, game), defect)
    steps, cycle = most_improvements(game)
    if cycle:
        return Potential("none", None, defect, discrepancy, cycle)
    return Potential("ordinal", _frozen(steps, game), defect, discrepancy)


def _frozen(values: np.ndarray, game: Game) -> Float[np.ndarray, "..."]:
    if game.present is not None:
        values[~game.present] = math.nan
    values.setflags(write=False)
    return values


def _exact(game: Game, tolerance: float) -> tuple[np.ndarray, float, tuple[Profile, ...]]:
    """Return the exact potential (or what comes of trying), how far it is off, and why it is none."""
    costs = game.costs
    finite = np.isfinite(costs).all(axis=0)
    mixed = np.isfinite(costs).any(axis=0) & ~finite
    if mixed.any():
        where = np.unravel_index(int(np.argmax(mixed)), mixed.shape)
        return costs[0], math.inf, (tuple(int(i) for i in where),)
    values, parent = _added_up(costs, finite)
    largest = float(np.abs(costs[:, finite]).max(initial=0.0))
    defect, worst = 0.0, None
    for player in range(len(costs)):
        # constant along the lines of the player's plans, if exact
        with np.errstate(invalid="ignore"):
            offset = np.moveaxis(np.where(finite, values - costs[player], math.nan), player, -1)
        lines = offset.reshape(-1, offset.shape[-1])
        some = np.isfinite(lines).any(axis=1)
        if not some.any():
            continue
        low, high = np.nanargmin(lines[some], axis=1), np.nanargmax(lines[some], axis=1)
        rows = np.flatnonzero(some)
        spread = lines[rows, high] - lines[rows, low]
        if spread.max() > defect:
            at = int(np.argmax(spread))
            defect = float(spread[at])
            rest = np.unravel_index(rows[at], offset.shape[:-1])
            worst = tuple(
                tuple(int(i) for i in np.insert(np.array(rest, np.int64), player, plan))
                for plan in (low[at], high[at])
            )
    if worst is None or defect <= tolerance * largest:
        return values, defect, ()
    return values, defect, _closed(worst[0], worst[1], parent, finite.shape)


def _added_up(costs: np.ndarray, finite: np.ndarray) -> tuple[np.ndarray, Int[np.ndarray, " profile"]]:
    """Return costs added up along deviations, from one profile of each connected part on, and each one's parent."""
    shape, players = finite.shape, len(costs)
    values = np.where(finite, math.nan, math.inf)
    parent = np.full(finite.size, -1)
    part = _connected_parts(finite)
    inside = np.flatnonzero(part >= 0)
    seeds = inside[np.unique(part[inside], return_index=True)[1]]
    values.reshape(-1)[seeds] = 0.0
    index = np.arange(finite.size).reshape(shape)
    unknown = np.isnan(values)
    while unknown.any():
        for player in range(players):
            known = finite & ~unknown
            # for every line of this player's plans, the first profile that is known
            first = np.expand_dims(known.argmax(axis=player), player)
            reached = unknown & known.any(axis=player, keepdims=True)
            with np.errstate(invalid="ignore"):
                step = costs[player] - np.take_along_axis(costs[player], first, axis=player)
                found = np.take_along_axis(values, first, axis=player) + step
            values[reached] = found[reached]
            origin = np.broadcast_to(np.take_along_axis(index, first, axis=player), shape)
            parent.reshape(shape)[reached] = origin[reached]
            unknown &= ~reached
    # the constant of each part, so that its least value is 0
    least = np.full(int(part.max(initial=-1)) + 1, math.inf)
    np.minimum.at(least, part[inside], values.reshape(-1)[inside])
    values.reshape(-1)[inside] -= least[part[inside]]
    return values, parent


def _connected_parts(finite: np.ndarray) -> Int[np.ndarray, " profile"]:
    """Return which part each finite profile belongs to, deviations between finite profiles connecting; -1 elsewhere."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    index = np.arange(finite.size).reshape(finite.shape)
    ends: list[np.ndarray] = []
    for player in range(finite.ndim):
        lines = np.moveaxis(index, player, -1).reshape(-1, finite.shape[player])
        # along each line, finite profiles are chained in order
        chosen = lines.ravel()[np.moveaxis(finite, player, -1).ravel()]
        line = np.repeat(np.arange(len(lines)), np.moveaxis(finite, player, -1).sum(axis=-1).ravel())
        same = line[1:] == line[:-1]
        ends.append(np.stack([chosen[:-1][same], chosen[1:][same]]))
    pairs = np.concatenate(ends, axis=1)
    graph = coo_array((np.ones(pairs.shape[1], np.int8), (pairs[0], pairs[1])), shape=(finite.size,) * 2)
    _, label = connected_components(graph, directed=False)
    flat = finite.ravel()
    part = np.full(finite.size, -1)
    part[flat] = np.unique(label[flat], return_inverse=True)[1]
    return part


def _closed(
    start: Profile, stop: Profile, parent: Int[np.ndarray, " profile"], shape: tuple[int, ...]
) -> tuple[Profile, ...]:
    """Return the closed path from one profile up the tree, down to the other and back by one deviation."""

    def ancestry(profile: Profile) -> list[int]:
        line = [int(np.ravel_multi_index(profile, shape))]
        while parent[line[-1]] >= 0:
            line.append(int(parent[line[-1]]))
        return line

    up, down = ancestry(start), ancestry(stop)
    while len(up) > 1 and len(down) > 1 and up[-2] == down[-2]:
        up.pop()
        down.pop()
    path = [profile_at(node, shape) for node in up + down[-2::-1]]
    return tuple(_without_detours(path))


def _without_detours(path: Sequence[Profile]) -> list[Profile]:
    """Return a closed path in which no player moves twice in a row: two such moves are one, with the same change."""

    def mover(a: Profile, b: Profile) -> int:
        return next(player for player, (one, other) in enumerate(zip(a, b, strict=True)) if one != other)

    kept, position = list(path), 0
    while position < len(kept) and len(kept) > 2:
        before, here, after = (kept[(position + shift) % len(kept)] for shift in (-1, 0, 1))
        if mover(before, here) == mover(here, after):
            del kept[position]
            position = max(position - 2, 0)
        else:
            position += 1
    return kept
