"""The graph of improvements: which profile is better than which for the one player who changes its plan."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
from jaxtyping import Float, Int

from ppinfer.games.game import Game

Profile: TypeAlias = tuple[int, ...]
"""The position of each player's plan."""


def most_improvements(game: Game) -> tuple[Float[np.ndarray, "..."], tuple[Profile, ...]]:
    """Return the most steps that improvements can take from each profile on; or a cycle of improvements.

    A strict improvement changes one player's plan and lowers its cost.

    Parameters
    ----------
    game : Game
        One game, without batch axes.

    Returns
    -------
    steps : (*plans) float64
        Whole numbers, 0 at the pure equilibria; of no meaning where there is a cycle.
    cycle : tuple of profiles
        Empty if improvements never go round in a circle.

    Examples
    --------
    >>> most_improvements(Game([[[3.0], [1.0], [2.0]], [[0.0], [0.0], [0.0]]], ["robot", "human"]))[0]
    array([[2.],
           [0.],
           [1.]])
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    worse, better = _improvements(game)
    shape = game.costs.shape[1:]
    count = math.prod(shape)
    graph = coo_array((np.ones(len(worse), np.int8), (worse, better)), shape=(count, count))
    parts, label = connected_components(graph, directed=True, connection="strong")
    if parts < count:
        return np.zeros(shape), _cycle(worse, better, label, shape)
    # peel off, again and again, the profiles whose improvements have all been peeled off
    into = graph.T.tocsr()
    left = np.bincount(worse, minlength=count)
    steps = np.zeros(count)
    layer = np.flatnonzero(left == 0)
    depth = 0.0
    while layer.size:
        steps[layer] = depth
        before = into[layer].indices
        np.subtract.at(left, before, 1)
        layer = np.unique(before[left[before] == 0])
        depth += 1.0
    return steps.reshape(shape), ()


def _improvements(game: Game) -> tuple[Int[np.ndarray, " edge"], Int[np.ndarray, " edge"]]:
    """Return the pairs of profiles of which the second is better for the one player whose plan differs."""
    shape = game.costs.shape[1:]
    index = np.arange(math.prod(shape)).reshape(shape)
    present = np.ones(shape, bool) if game.present is None else game.present
    pairs: list[Any] = []
    for player, own in enumerate(game.costs):
        size = shape[player]
        cost, node, exists = (
            np.moveaxis(array, player, -1).reshape(-1, size) for array in (own, index, present)
        )
        # absent profiles read inf, so nothing is ever improved by going there
        line, a, b = np.nonzero((cost[:, None, :] < cost[:, :, None]) & exists[:, :, None])
        pairs.append((node[line, a], node[line, b]))
    return (np.concatenate([worse for worse, _ in pairs]), np.concatenate([better for _, better in pairs]))


def _cycle(
    worse: Int[np.ndarray, " edge"],
    better: Int[np.ndarray, " edge"],
    label: Int[np.ndarray, " profile"],
    shape: tuple[int, ...],
) -> tuple[Profile, ...]:
    """Return a shortest cycle through a profile from which improvements lead back to itself."""
    sizes = np.bincount(label)
    within = (label[worse] == label[better]) & (sizes[label[worse]] > 1)
    following: dict[int, list[int]] = {}
    for a, b in zip(worse[within].tolist(), better[within].tolist(), strict=True):
        following.setdefault(a, []).append(b)
    start = min(following)
    came_from: dict[int, int] = {}
    frontier = [start]
    while start not in came_from:
        reached = []
        for node in frontier:
            for later in following[node]:
                if later not in came_from:
                    came_from[later] = node
                    reached.append(later)
        frontier = reached
    path = [came_from[start]]
    while path[-1] != start:
        path.append(came_from[path[-1]])
    return tuple(profile_at(node, shape) for node in reversed(path))


def profile_at(node: int, shape: tuple[int, ...]) -> Profile:
    """Return the profile at a position of the flattened grid.

    Examples
    --------
    >>> profile_at(5, (2, 3))
    (1, 2)
    """
    return tuple(int(i) for i in np.unravel_index(node, shape))
