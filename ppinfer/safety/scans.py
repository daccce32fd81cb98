"""Compiled scans of rollouts, candidates and their distances; imported only when one of them is first needed."""

from __future__ import annotations

import numba
import numpy as np
from jaxtyping import Float, Int

# rollouts that are stepped together: their states stay in the nearest cache
BLOCK = 128


@numba.njit(cache=True, nogil=True, error_model="numpy")
def roll_out(
    start: Float[np.ndarray, " n"],
    drive: Float[np.ndarray, "mode n"],
    mode: Int[np.ndarray, " rollout"],
    loop: Float[np.ndarray, "n n"],
    root: Float[np.ndarray, "n rank"],
    noise: Float[np.ndarray, "step rank rollout"],
    position_index: Int[np.ndarray, " space"],
    positions: Float[np.ndarray, "instant space rollout"],
) -> None:
    """Write the positions of x' = loop x + drive[mode] + root noise, at the start and after every step."""
    steps, rank, rollouts = noise.shape
    n, space = len(start), len(position_index)
    x, following, constant = np.empty((n, BLOCK)), np.empty((n, BLOCK)), np.empty((n, BLOCK))
    for first in range(0, rollouts, BLOCK):
        count = min(BLOCK, rollouts - first)
        for i in range(n):
            for r in range(count):
                x[i, r] = start[i]
                constant[i, r] = drive[mode[first + r], i]
        for s in range(space):
            for r in range(count):
                positions[0, s, first + r] = start[position_index[s]]
        for t in range(steps):
            for i in range(n):
                row = following[i]
                row[:count] = constant[i, :count]
                for j in range(n):
                    factor = loop[i, j]
                    if factor != 0.0:
                        other = x[j]
                        for r in range(count):
                            row[r] += factor * other[r]
                for j in range(rank):
                    factor = root[i, j]
                    if factor != 0.0:
                        drawn = noise[t, j, first : first + count]
                        for r in range(count):
                            row[r] += factor * drawn[r]
            x, following = following, x
            for s in range(space):
                own = x[position_index[s]]
                for r in range(count):
                    positions[t + 1, s, first + r] = own[r]


@numba.njit(cache=True, nogil=True, error_model="numpy")
def roll_out_limited(
    start: Float[np.ndarray, " n"],
    target: Float[np.ndarray, "mode n"],
    mode: Int[np.ndarray, " rollout"],
    A: Float[np.ndarray, "n n"],
    B: Float[np.ndarray, "n m"],
    K: Float[np.ndarray, "m n"],
    limit: float,
    root: Float[np.ndarray, "n rank"],
    noise: Float[np.ndarray, "step rank rollout"],
    position_index: Int[np.ndarray, " space"],
    positions: Float[np.ndarray, "instant space rollout"],
) -> None:
    """Write the positions of x' = A x + B u + root noise, u = -K (x - target[mode]) shortened to the limit."""
    steps, rank, rollouts = noise.shape
    n, m, space = B.shape[0], B.shape[1], len(position_index)
    x, following, u = np.empty(n), np.empty(n), np.empty(m)
    for r in range(rollouts):
        goal = target[mode[r]]
        x[:] = start
        for s in range(space):
            positions[0, s, r] = x[position_index[s]]
        for t in range(steps):
            length = 0.0
            for i in range(m):
                u[i] = 0.0
                for j in range(n):
                    u[i] -= K[i, j] * (x[j] - goal[j])
                length += u[i] * u[i]
            length = np.sqrt(length)
            share = limit / length if length > limit else 1.0
            for i in range(n):
                value = 0.0
                for j in range(n):
                    value += A[i, j] * x[j]
                for j in range(m):
                    value += B[i, j] * share * u[j]
                for j in range(rank):
                    value += root[i, j] * noise[t, j, r]
                following[i] = value
            x, following = following, x
            for s in range(space):
                positions[t + 1, s, r] = x[position_index[s]]


@numba.njit(cache=True, nogil=True, error_model="numpy")
def pursue(
    start: Float[np.ndarray, "row n"],
    target: Float[np.ndarray, "row n"],
    A: Float[np.ndarray, "n n"],
    B: Float[np.ndarray, "n m"],
    K: Float[np.ndarray, "m n"],
    limit: float,
    states: Float[np.ndarray, "row instant n"],
    controls: Float[np.ndarray, "row step m"],
) -> None:
    """Write the states and controls of x' = A x + B u, u = -K (x - target) shortened to the limit, without noise."""
    rows, steps, m = controls.shape
    n = start.shape[1]
    for row in range(rows):
        states[row, 0] = start[row]
        for t in range(steps):
            length = 0.0
            for i in range(m):
                value = 0.0
                for j in range(n):
                    value -= K[i, j] * (states[row, t, j] - target[row, j])
                controls[row, t, i] = value
                length += value * value
            length = np.sqrt(length)
            if length > limit:
                for i in range(m):
                    controls[row, t, i] *= limit / length
            for i in range(n):
                value = 0.0
                for j in range(n):
                    value += A[i, j] * states[row, t, j]
                for j in range(m):
                    value += B[i, j] * controls[row, t, j]
                states[row, t + 1, i] = value


@numba.njit(cache=True, nogil=True, error_model="numpy")
def count_safe(
    plans: Float[np.ndarray, "candidate instant space"],
    others: Float[np.ndarray, "other instant space rollout"],
    distance: Float[np.ndarray, " other"],
    static: Float[np.ndarray, "static space"],
    static_distance: Float[np.ndarray, " static"],
    safe: Int[np.ndarray, " candidate"],
) -> None:
    """Write in how many rollouts a plan is never nearer to anybody than the distance.

    Rollouts are looked at in blocks; a block that cannot be near, by the box about it, is passed over.
    """
    candidates, instants, space = plans.shape
    many, rollouts = others.shape[0], others.shape[3]
    blocks = (rollouts + BLOCK - 1) // BLOCK
    boxed = candidates >= 4
    low = np.empty((many, blocks, instants, space) if boxed else (0, 0, 0, 0))
    high = np.empty_like(low)
    if boxed:
        for other in range(many):
            for block in range(blocks):
                first = block * BLOCK
                last = min(first + BLOCK, rollouts)
                for t in range(instants):
                    for s in range(space):
                        least, most = np.inf, -np.inf
                        for value in others[other, t, s, first:last]:
                            least = value if value < least else least
                            most = value if value > most else most
                        low[other, block, t, s], high[other, block, t, s] = least, most
    margin, square = np.empty(BLOCK), np.empty(BLOCK)
    for candidate in range(candidates):
        safe[candidate] = 0
        plan = plans[candidate]
        if _hits(plan, static, static_distance):
            continue
        for block in range(blocks):
            first = block * BLOCK
            count = min(BLOCK, rollouts - first)
            margin[:count] = np.inf
            for other in range(many):
                required = distance[other] * distance[other]
                for t in range(instants):
                    if boxed:
                        gap = 0.0
                        for s in range(space):
                            off = max(
                                low[other, block, t, s] - plan[t, s],
                                plan[t, s] - high[other, block, t, s],
                                0.0,
                            )
                            gap += off * off
                        if gap >= required:
                            continue
                    if space == 2:
                        px, py = plan[t, 0], plan[t, 1]
                        x = others[other, t, 0, first : first + count]
                        y = others[other, t, 1, first : first + count]
                        for r in range(count):
                            value = (x[r] - px) * (x[r] - px) + (y[r] - py) * (y[r] - py) - required
                            margin[r] = value if value < margin[r] else margin[r]
                    else:
                        square[:count] = -required
                        for s in range(space):
                            own = plan[t, s]
                            z = others[other, t, s, first : first + count]
                            for r in range(count):
                                square[r] += (z[r] - own) * (z[r] - own)
                        for r in range(count):
                            margin[r] = square[r] if square[r] < margin[r] else margin[r]
            for r in range(count):
                if margin[r] >= 0.0:
                    safe[candidate] += 1


@numba.njit(cache=True, nogil=True)
def _hits(
    plan: Float[np.ndarray, "instant space"],
    static: Float[np.ndarray, "static space"],
    distance: Float[np.ndarray, " static"],
) -> bool:
    for obstacle in range(len(distance)):
        for t in range(plan.shape[0]):
            square = 0.0
            for s in range(plan.shape[1]):
                square += (plan[t, s] - static[obstacle, s]) ** 2
            if square < distance[obstacle] ** 2:
                return True
    return False


@numba.njit(cache=True, nogil=True, error_model="numpy")
def repel_candidates(
    start: Float[np.ndarray, " n"],
    target: Float[np.ndarray, " n"],
    A: Float[np.ndarray, "n n"],
    B: Float[np.ndarray, "n m"],
    K: Float[np.ndarray, "m n"],
    limit: float,
    position_index: Int[np.ndarray, " space"],
    obstacles: Float[np.ndarray, "obstacle space"],
    modes: Float[np.ndarray, "mode instant space"],
    weight: Float[np.ndarray, " mode"],
    required: Float[np.ndarray, "mode instant"],
    strength: float,
    clip: float,
    states: Float[np.ndarray, "candidate instant n"],
    controls: Float[np.ndarray, "candidate step m"],
    smallest: Float[np.ndarray, " candidate"],
    margin: Float[np.ndarray, " candidate"],
) -> None:
    """Write trajectories that pursue the target, repelled by all modes and, but for the first, by one obstacle each.

    One more than that, if there is room for it, is repelled by nothing.
    `smallest` is the least distance from any mode, after the start; `margin` that beyond what is required, from the
    start on.
    """
    count, steps, m = controls.shape
    n, space = len(start), len(position_index)
    # candidates side by side, so that what is done for one is done for some at once
    x, following, u = np.empty((n, count)), np.empty((n, count)), np.empty((m, count))
    push, source, square = np.empty((space, count)), np.zeros((space, count)), np.empty(count)
    own, gamma = np.zeros(count), np.zeros(count)
    for candidate in range(count):
        smallest[candidate] = np.inf
        margin[candidate] = np.inf
        if candidate <= len(obstacles):
            gamma[candidate] = strength
        if 0 < candidate <= len(obstacles):
            own[candidate] = strength
            source[:, candidate] = obstacles[candidate - 1]
        x[:, candidate] = start
    clipped = clip * clip
    for t in range(steps + 1):
        for candidate in range(count):
            for i in range(n):
                states[candidate, t, i] = x[i, candidate]
        push[:] = 0.0
        for s in range(space):
            where = x[position_index[s]]
            for c in range(count):
                square[c] = (0.0 if s == 0 else square[c]) + (where[c] - source[s, c]) ** 2
        for s in range(space):
            where = x[position_index[s]]
            for c in range(count):
                push[s, c] += own[c] / max(square[c], clipped) * (where[c] - source[s, c])
        for mode in range(len(weight)):
            for s in range(space):
                where, place = x[position_index[s]], modes[mode, t, s]
                for c in range(count):
                    square[c] = (0.0 if s == 0 else square[c]) + (where[c] - place) ** 2
            needed = required[mode, t]
            for c in range(count):
                distance = np.sqrt(square[c])
                if t > 0:
                    smallest[c] = min(smallest[c], distance)
                margin[c] = min(margin[c], distance - needed)
                square[c] = weight[mode] * gamma[c] / max(square[c], clipped)
            for s in range(space):
                where, place = x[position_index[s]], modes[mode, t, s]
                for c in range(count):
                    push[s, c] += square[c] * (where[c] - place)
        if t == steps:
            break
        for i in range(m):
            for c in range(count):
                u[i, c] = push[i, c]
            for j in range(n):
                factor, goal = K[i, j], target[j]
                for c in range(count):
                    u[i, c] -= factor * (x[j, c] - goal)
        if limit < np.inf:
            square[:] = 0.0
            for i in range(m):
                for c in range(count):
                    square[c] += u[i, c] * u[i, c]
            for i in range(m):
                for c in range(count):
                    length = np.sqrt(square[c])
                    u[i, c] *= limit / length if length > limit else 1.0
        for i in range(n):
            following[i] = 0.0
            for j in range(n):
                factor = A[i, j]
                for c in range(count):
                    following[i, c] += factor * x[j, c]
            for j in range(m):
                factor = B[i, j]
                for c in range(count):
                    following[i, c] += factor * u[j, c]
        for candidate in range(count):
            for i in range(m):
                controls[candidate, t, i] = u[i, candidate]
        x, following = following, x


@numba.njit(cache=True, nogil=True, error_model="numpy")
def count_safe_bodies(
    plans: Float[np.ndarray, "candidate instant space"],
    others: Float[np.ndarray, "other instant space rollout"],
    distance: Float[np.ndarray, " other"],
    own_start: Float[np.ndarray, "own space"],
    own_end: Float[np.ndarray, "own space"],
    own_radius: Float[np.ndarray, " own"],
    first: Int[np.ndarray, " bound"],
    its_start: Float[np.ndarray, "its space"],
    its_end: Float[np.ndarray, "its space"],
    its_radius: Float[np.ndarray, " its"],
    reach: Float[np.ndarray, " other"],
    safe: Int[np.ndarray, " candidate"],
) -> None:
    """Write in how many rollouts the robot's capsules never come nearer than the distance to anybody's.

    The capsules of other o are those from `first[o]` to `first[o + 1]`; farther apart than `reach[o]` nothing is near.
    """
    candidates, instants, space = plans.shape
    many, rollouts = others.shape[0], others.shape[3]
    offset = np.empty(space)
    for candidate in range(candidates):
        safe[candidate] = 0
        for r in range(rollouts):
            kept = True
            for other in range(many):
                for t in range(instants):
                    square = 0.0
                    for s in range(space):
                        offset[s] = plans[candidate, t, s] - others[other, t, s, r]
                        square += offset[s] * offset[s]
                    if square >= reach[other] * reach[other]:
                        continue
                    for own in range(len(own_radius)):
                        for its in range(first[other], first[other + 1]):
                            gap = segment_gap(
                                offset, own_start[own], own_end[own], its_start[its], its_end[its]
                            )
                            if gap - own_radius[own] - its_radius[its] < distance[other]:
                                kept = False
                                break
                        if not kept:
                            break
                    if not kept:
                        break
                if not kept:
                    break
            if kept:
                safe[candidate] += 1


@numba.njit(cache=True, nogil=True, error_model="numpy")
def segment_gap(
    offset: Float[np.ndarray, " space"],
    own_start: Float[np.ndarray, " space"],
    own_end: Float[np.ndarray, " space"],
    its_start: Float[np.ndarray, " space"],
    its_end: Float[np.ndarray, " space"],
) -> float:
    """Return the least distance between two segments, the first one moved by the offset; a segment may be a point."""
    a, e, b, c, f = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(len(offset)):
        along, across = own_end[k] - own_start[k], its_end[k] - its_start[k]
        apart = offset[k] + own_start[k] - its_start[k]
        a += along * along
        e += across * across
        b += along * across
        c += along * apart
        f += across * apart
    s, t = 0.0, 0.0
    if a * e - b * b > 0.0:
        s = min(max((b * f - c * e) / (a * e - b * b), 0.0), 1.0)
    if e > 0.0:
        t = (b * s + f) / e
    # beyond an end of the other segment it is that end which counts
    if t <= 0.0:
        t = 0.0
        s = min(max(-c / a, 0.0), 1.0) if a > 0.0 else 0.0
    elif t >= 1.0:
        t = 1.0
        s = min(max((b - c) / a, 0.0), 1.0) if a > 0.0 else 0.0
    square = 0.0
    for k in range(len(offset)):
        apart = offset[k] + own_start[k] - its_start[k]
        apart += s * (own_end[k] - own_start[k]) - t * (its_end[k] - its_start[k])
        square += apart * apart
    return float(np.sqrt(square))


@numba.njit(cache=True, nogil=True)
def segment_gaps(
    offset: Float[np.ndarray, " space"],
    own_start: Float[np.ndarray, "pair space"],
    own_end: Float[np.ndarray, "pair space"],
    its_start: Float[np.ndarray, "pair space"],
    its_end: Float[np.ndarray, "pair space"],
    gap: Float[np.ndarray, " pair"],
) -> None:
    """Write the distances of many pairs of segments."""
    for pair in range(len(gap)):
        gap[pair] = segment_gap(offset, own_start[pair], own_end[pair], its_start[pair], its_end[pair])
