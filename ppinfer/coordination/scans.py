"""Compiled scans over plans; imported only when plans are first sampled."""

from __future__ import annotations

import numba
import numpy as np
from jaxtyping import Float, Int


@numba.njit(cache=True, nogil=True)
def sample_plans(
    start: Int[np.ndarray, " plan"],
    row_size: Int[np.ndarray, " plan"],
    time: Float[np.ndarray, " waypoint"],
    position: Float[np.ndarray, "waypoint joint"],
    when: Float[np.ndarray, "plan time"],
) -> tuple[Float[np.ndarray, "plan time joint"], Float[np.ndarray, "plan time joint"]]:
    """Return position and velocity of each plan at its own, non-decreasing, times.

    The velocity is the one just before that time (a left limit): 0 at the start and after the end of a plan.
    """
    plans, times = when.shape
    joints = position.shape[1]
    where = np.empty((plans, times, joints))
    speed = np.zeros((plans, times, joints))
    for plan in range(plans):
        last = start[plan] + row_size[plan] - 1
        leg = start[plan]
        for t in range(times):
            now = when[plan, t]
            while leg < last and time[leg + 1] < now:
                leg += 1
            if leg == last or now <= time[start[plan]]:
                for joint in range(joints):
                    where[plan, t, joint] = position[leg, joint]
            else:
                span = time[leg + 1] - time[leg]
                share = (now - time[leg]) / span
                for joint in range(joints):
                    change = position[leg + 1, joint] - position[leg, joint]
                    where[plan, t, joint] = position[leg, joint] + share * change
                    speed[plan, t, joint] = change / span
    return where, speed


@numba.njit(cache=True, nogil=True)
def plan_frequencies(
    ego_cost: Float[np.ndarray, "own other"],
    other_cost: Float[np.ndarray, "own other"],
    drawn_own: Int[np.ndarray, "subgame own_drawn"],
    drawn_other: Int[np.ndarray, "subgame other_drawn"],
    rationality: float,
    hold: int,
) -> Float[np.ndarray, "theta other"]:
    """Return how often the other agent plays each plan over sub-games, for equilibria that favour ego or the other.

    In each sub-game: the collision-free equilibria, less those weakly dominated among them; of these, those of the
    class (all, if it is empty), weighted by exp(-rationality min(c_ego, c_other)). A sub-game without any counts as
    the other agent's holding still.
    """
    games, m = drawn_own.shape
    n = drawn_other.shape[1]
    played = np.zeros((2, ego_cost.shape[1]))
    found = np.empty((m * n, 2), np.int64)
    kept = np.empty(m * n, np.bool_)
    ego_best = np.empty(n)
    other_best = np.empty(m)
    for game in range(games):
        ego_best[:] = np.inf
        other_best[:] = np.inf
        for i in range(m):
            for j in range(n):
                a, b = drawn_own[game, i], drawn_other[game, j]
                ego_best[j] = min(ego_best[j], ego_cost[a, b])
                other_best[i] = min(other_best[i], other_cost[a, b])
        count = 0
        for i in range(m):
            for j in range(n):
                a, b = drawn_own[game, i], drawn_other[game, j]
                own, others = ego_cost[a, b], other_cost[a, b]
                if own < np.inf and others < np.inf and own <= ego_best[j] and others <= other_best[i]:
                    found[count, 0] = a
                    found[count, 1] = b
                    count += 1
        for x in range(count):
            own, others = ego_cost[found[x, 0], found[x, 1]], other_cost[found[x, 0], found[x, 1]]
            kept[x] = True
            for y in range(count):
                own_y, others_y = ego_cost[found[y, 0], found[y, 1]], other_cost[found[y, 0], found[y, 1]]
                if own_y <= own and others_y <= others and (own_y < own or others_y < others):
                    kept[x] = False
                    break
        if count == 0:
            played[:, hold] += 1.0
            continue
        for theta in range(2):
            empty = True
            for x in range(count):
                own, others = ego_cost[found[x, 0], found[x, 1]], other_cost[found[x, 0], found[x, 1]]
                if kept[x] and (own <= others if theta == 0 else others <= own):
                    empty = False
            # weights are taken relative to the largest of the class: none of it may underflow
            least, total = np.inf, 0.0
            for step in range(3):
                for x in range(count):
                    own, others = ego_cost[found[x, 0], found[x, 1]], other_cost[found[x, 0], found[x, 1]]
                    if not kept[x] or not (empty or (own <= others if theta == 0 else others <= own)):
                        continue
                    if step == 0:
                        least = min(least, min(own, others))
                        continue
                    weight = np.exp(-rationality * (min(own, others) - least))
                    if step == 1:
                        total += weight
                    else:
                        played[theta, found[x, 1]] += weight / total
    played /= games
    return played
