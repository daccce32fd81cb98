"""All pure equilibria of a pairwise game, by a search that gives up partial profiles that none can complete."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int, UInt64

from ppinfer.errors import GameError
from ppinfer.games.pairwise.found import PairwiseEquilibria
from ppinfer.games.pairwise.game import PairwiseGame

ROWS_AT_ONCE = 2048
"""How many partial profiles are extended together: few enough for the cache, and for answers to come early."""


def pairwise_equilibria(
    game: PairwiseGame, *, collision_free: bool = True, limit: int = 1_000_000
) -> PairwiseEquilibria:
    """Find every pure equilibrium (1) of a pairwise game without building the table of all profiles.

    1. A set of plans, of any players, is a row of bits. Choosing plan p *blocks* the plans of others that collide
       with it. A profile in which nobody collides is an equilibrium exactly when every plan that is cheaper than a
       chosen plan of the same player is blocked; plans of equal cost block nothing.
    2. Partial profiles are extended player by player, many at once. One is given up as soon as a plan that must be
       blocked can no longer be: no plan still open to the players to come collides with it; or when a player to come
       has no plan left.

    Parameters
    ----------
    game : PairwiseGame
    collision_free : bool
        Whether to leave out equilibria in which some player's cost is inf. By definition (1) a player all of whose
        plans collide has regret 0 whatever it does, so there can be very many of these, and coordination keeps none
        of them. With False the answer is that of `pure_equilibria` on the dense table, to the letter.
    limit : int
        The most equilibria to return.

    Returns
    -------
    PairwiseEquilibria
        Labels of one sparse ``profile`` axis, in the order of the grid; possibly none.

    Raises
    ------
    GameError
        If there are more than `limit`.

    Examples
    --------
    Three agents each have a short way and a detour; the short ways all meet in the middle.

    >>> meet = [[True, False], [False, False]]
    >>> pairs = {("a", "b"): meet, ("a", "c"): meet, ("b", "c"): meet}
    >>> game = PairwiseGame([[2.0, 3.0], [2.0, 4.0], [2.0, 5.0]], pairs, ["a", "b", "c"])
    >>> found = pairwise_equilibria(game)
    >>> found.profiles
    array([[0, 1, 1],
           [1, 0, 1],
           [1, 1, 0]])
    >>> found.costs.sum(axis=1)
    array([11., 10.,  9.])
    """
    if limit < 1:
        raise GameError(f"limit is the most equilibria to return, at least 1; got {limit}")
    players = [_choices(game, player, collision_free) for player in range(len(game.players))]
    # few choices first: they branch least while little is known
    order = sorted(range(len(players)), key=lambda player: len(players[player].plan))
    found: list[np.ndarray] = []
    count = 0
    for profiles in _complete([players[player] for player in order], _dead(game)):
        count += len(profiles)
        if count > limit:
            what = "collision-free equilibria" if collision_free else "equilibria"
            raise GameError(
                f"there are more than {limit} {what} among {game.profiles:.3g} profiles; raise limit=, or "
                + ("drop plans of equal cost" if collision_free else "ask for those without collisions only")
            )
        found.append(profiles)
    chosen = np.concatenate(found) if found else np.empty((0, len(order)), np.int64)
    chosen = chosen[:, np.argsort(order)]
    chosen = chosen[np.lexsort(chosen.T[::-1])]
    return PairwiseEquilibria._of(game, chosen, collision_free)


@dataclass(frozen=True)
class _Choices:
    """What one player may do, and what each choice asks of the others; sets of plans are rows of bits.

    ``plan`` is the position of the plan chosen; ``blocks`` are the plans that collide with it; all of ``must`` have to
    be blocked in the end (or be of infinite cost by themselves), and none of ``free`` may be.
    """

    plan: Int[np.ndarray, " choice"]
    blocks: UInt64[np.ndarray, "choice word"]
    must: UInt64[np.ndarray, "choice word"]
    free: UInt64[np.ndarray, "choice word"]


@dataclass(frozen=True)
class _Partial:
    """Profiles of the first few players, and the union of what their choices block, ask for and keep free."""

    plans: Int[np.ndarray, "row chosen"]
    blocked: UInt64[np.ndarray, "row word"]
    must: UInt64[np.ndarray, "row word"]
    free: UInt64[np.ndarray, "row word"]

    def __getitem__(self, rows: slice | Bool[np.ndarray, " row"]) -> _Partial:
        return _Partial(self.plans[rows], self.blocked[rows], self.must[rows], self.free[rows])


def _choices(game: PairwiseGame, player: int, collision_free: bool) -> _Choices:
    """Return a player's choices: a plan that stays free; or, where collisions count, any plan when all are blocked."""
    cost = game.costs[player]
    start = sum(game.shape[:player])
    total = sum(game.shape)
    blocks = np.zeros((len(cost), total), bool)
    for (one, other), collide in game.collisions.items():
        if player == one:
            blocks[:, sum(game.shape[:other]) :][:, : game.shape[other]] = collide
        elif player == other:
            blocks[:, sum(game.shape[:one]) :][:, : game.shape[one]] = collide.T
    own = np.zeros((len(cost), total), bool)
    own[:, start : start + len(cost)] = True
    cheaper = np.zeros_like(own)
    cheaper[:, start : start + len(cost)] = cost[None, :] < cost[:, None]
    itself = np.zeros_like(own)
    itself[np.arange(len(cost)), start + np.arange(len(cost))] = True
    # a plan that costs inf by itself is blocked from the start, so it cannot stay free
    plan, must, free = np.arange(len(cost)), cheaper, itself
    if not collision_free:
        plan = np.concatenate([plan, plan])
        blocks = np.concatenate([blocks, blocks])
        must = np.concatenate([must, own])
        free = np.concatenate([free, np.zeros_like(own)])
    return _Choices(plan, _bits(blocks), _bits(must), _bits(free))


def _dead(game: PairwiseGame) -> UInt64[np.ndarray, " word"]:
    """Return the plans that cost their player inf whatever the others do."""
    return np.asarray(_bits(np.isinf(np.concatenate(game.costs))[None])[0])


def _bits(sets: Bool[np.ndarray, "set plan"]) -> UInt64[np.ndarray, "set word"]:
    """Pack each row of flags into 64-bit words."""
    padded = np.zeros((len(sets), -(-sets.shape[1] // 64) * 64), bool)
    padded[:, : sets.shape[1]] = sets
    return np.packbits(padded, axis=1, bitorder="little").view(np.uint64)


def _complete(
    players: list[_Choices], dead: UInt64[np.ndarray, " word"]
) -> Iterator[Int[np.ndarray, "profile player"]]:
    """Yield every complete profile that keeps all its promises, some at a time."""
    nothing = np.zeros((1, len(dead)), np.uint64)
    waiting = [_Partial(np.empty((1, 0), np.int64), dead[None], nothing, nothing)]
    while waiting:
        rows = waiting.pop()
        depth = rows.plans.shape[1]
        if depth == len(players):
            yield rows.plans
            continue
        if len(rows.plans) > ROWS_AT_ONCE:
            # the last piece is finished first, so that few pieces wait at any time
            waiting += [rows[i : i + ROWS_AT_ONCE] for i in range(0, len(rows.plans), ROWS_AT_ONCE)]
            continue
        extended = _extend(rows, players[depth])
        extended = extended[_hopeful(extended, players[depth + 1 :])]
        if len(extended.plans):
            waiting.append(extended)


def _extend(rows: _Partial, player: _Choices) -> _Partial:
    """Return the rows with each choice of the next player that leaves free what must stay so."""
    blocked = rows.blocked[:, None] | player.blocks
    free = rows.free[:, None] | player.free
    kept, choice = np.nonzero(~_overlap(blocked, free))
    return _Partial(
        np.column_stack([rows.plans[kept], player.plan[choice]]),
        blocked[kept, choice],
        rows.must[kept] | player.must[choice],
        free[kept, choice],
    )


def _hopeful(rows: _Partial, players: list[_Choices]) -> Bool[np.ndarray, " row"]:
    """Tell which rows the players to come may still complete; exact when none is to come."""
    within_reach = rows.blocked
    open_choices: list[tuple[_Choices, np.ndarray]] = []
    for player in players:
        clash = _overlap(rows.blocked[:, None], player.free) | _overlap(rows.free[:, None], player.blocks)
        open_choices.append((player, ~clash))
        within_reach = within_reach | _union(player.blocks, ~clash)
    hopeful = ~_overlap(rows.must, ~within_reach)
    # once more with what is left: a choice is open only if what it needs blocked can be
    narrowed = rows.blocked
    for player, is_open in open_choices:
        is_open = is_open & ~_overlap(player.must, ~within_reach[:, None])
        hopeful &= is_open.any(axis=1)
        narrowed = narrowed | _union(player.blocks, is_open)
    return np.asarray(hopeful & ~_overlap(rows.must, ~narrowed))


def _overlap(
    some: UInt64[np.ndarray, "... word"], others: UInt64[np.ndarray, "... word"]
) -> Bool[np.ndarray, "..."]:
    """Tell whether two sets have a plan in common."""
    if some.shape[-1] == 1:
        return np.asarray((some[..., 0] & others[..., 0]) != 0)
    return np.asarray(((some & others) != 0).any(axis=-1))


def _union(
    sets: UInt64[np.ndarray, "choice word"], chosen: Bool[np.ndarray, "row choice"]
) -> UInt64[np.ndarray, "row word"]:
    """Return, for each row, the union of the sets chosen."""
    return np.asarray(np.bitwise_or.reduce(np.where(chosen[..., None], sets, np.uint64(0)), axis=1))
