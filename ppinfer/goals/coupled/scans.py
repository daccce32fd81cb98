"""Compiled passes over samples. Importing this module loads numba; nothing imports it before it is needed."""

from __future__ import annotations

import numba
import numpy as np
from jaxtyping import Bool, Float, Int


@numba.njit(cache=True, nogil=True)
def agent_geometry(
    time: Float[np.ndarray, " sample"],
    position: Float[np.ndarray, "sample space"],
    seen: Bool[np.ndarray, " sample"],
    row_size: Int[np.ndarray, " row"],
    goals: Float[np.ndarray, "row goal space"],
    last_position: Float[np.ndarray, "sample space"],
    known: Bool[np.ndarray, " sample"],
    stepped: Bool[np.ndarray, " sample"],
    distance: Float[np.ndarray, "sample goal"],
    speed: Float[np.ndarray, " sample"],
    cosine: Float[np.ndarray, "sample goal"],
) -> None:
    """Write where the agent was last seen, how far its goals are from there, and how its last step lay to them."""
    count, space = goals.shape[1], goals.shape[2]
    sample = 0
    for row in range(len(row_size)):
        last = -1
        for _ in range(row_size[row]):
            speed[sample] = 0.0
            stepped[sample] = seen[sample] and last >= 0
            for goal in range(count):
                cosine[sample, goal] = 0.0
            if stepped[sample]:
                length = 0.0
                for i in range(space):
                    length += (position[sample, i] - position[last, i]) ** 2
                length = np.sqrt(length)
                speed[sample] = length / (time[sample] - time[last])
                for goal in range(count):
                    # the distance from the last position is that written there
                    lengths = length * distance[sample - 1, goal]
                    if lengths > 0.0:
                        along = 0.0
                        for i in range(space):
                            along += (position[sample, i] - position[last, i]) * (
                                goals[row, goal, i] - position[last, i]
                            )
                        cosine[sample, goal] = min(1.0, max(-1.0, along / lengths))
            if seen[sample]:
                last = sample
            known[sample] = last >= 0
            for i in range(space):
                last_position[sample, i] = position[last, i] if last >= 0 else 0.0
            for goal in range(count):
                square = 0.0
                if last >= 0:
                    for i in range(space):
                        square += (goals[row, goal, i] - position[last, i]) ** 2
                distance[sample, goal] = np.sqrt(square)
            sample += 1


@numba.njit(cache=True, nogil=True)
def partner_geometry(
    time: Float[np.ndarray, " sample"],
    position: Float[np.ndarray, "sample space"],
    velocity: Float[np.ndarray, "sample space"],
    velocity_logged: bool,
    seen: Bool[np.ndarray, " sample"],
    row_size: Int[np.ndarray, " row"],
    goals: Float[np.ndarray, "row goal space"],
    known: Bool[np.ndarray, " sample"],
    distance: Float[np.ndarray, "sample goal"],
    closing: Float[np.ndarray, "sample goal"],
) -> None:
    """Write how far the goals are from where a partner was last seen, and how fast it closed in on them then."""
    count, space = goals.shape[1], goals.shape[2]
    moving = np.zeros(space)
    sample = 0
    for row in range(len(row_size)):
        last = -1
        moving[:] = 0.0
        for _ in range(row_size[row]):
            if seen[sample]:
                for i in range(space):
                    if velocity_logged:
                        moving[i] = velocity[sample, i]
                    elif last >= 0:
                        moving[i] = (position[sample, i] - position[last, i]) / (time[sample] - time[last])
                last = sample
            known[sample] = last >= 0
            for goal in range(count):
                square, along = 0.0, 0.0
                if last >= 0:
                    for i in range(space):
                        away = goals[row, goal, i] - position[last, i]
                        square += away * away
                        along += away * moving[i]
                length = np.sqrt(square)
                distance[sample, goal] = length
                closing[sample, goal] = along / length if length > 0.0 else 0.0
            sample += 1


@numba.njit(cache=True, nogil=True)
def partner_goals(
    partner_distance: Float[np.ndarray, "partner sample goal"],
    partner_closing: Float[np.ndarray, "partner sample goal"],
    distance: float,
    closing: float,
    present: Bool[np.ndarray, "row goal"],
    row: Int[np.ndarray, " sample"],
    log_q: Float[np.ndarray, "partner sample goal"],
) -> None:
    """Write log softmax(closing v - distance d) over the goals present, -inf for the others."""
    partners, samples, goals = log_q.shape
    for partner in range(partners):
        for sample in range(samples):
            largest = -np.inf
            for goal in range(goals):
                score = -np.inf
                if present[row[sample], goal]:
                    score = (
                        closing * partner_closing[partner, sample, goal]
                        - distance * partner_distance[partner, sample, goal]
                    )
                log_q[partner, sample, goal] = score
                largest = max(largest, score)
            total = 0.0
            for goal in range(goals):
                total += np.exp(log_q[partner, sample, goal] - largest)
            log_total = largest + np.log(total)
            for goal in range(goals):
                log_q[partner, sample, goal] -= log_total


@numba.njit(cache=True, nogil=True)
def log_of_the_others(
    log_q: Float[np.ndarray, "partner sample goal"], out: Float[np.ndarray, "partner sample goal"]
) -> None:
    """Write log(1 - q) as the log of the sum over the other goals; 0 where there is no other."""
    partners, samples, goals = log_q.shape
    for partner in range(partners):
        for sample in range(samples):
            top = 0
            for goal in range(1, goals):
                if log_q[partner, sample, goal] > log_q[partner, sample, top]:
                    top = goal
            second, total = -np.inf, 0.0
            for goal in range(goals):
                share = np.exp(log_q[partner, sample, goal] - log_q[partner, sample, top])
                out[partner, sample, goal] = share
                total += share
                if goal != top:
                    second = max(second, log_q[partner, sample, goal])
            for goal in range(goals):
                # the top one is among the others, so at least 1 is left and no digit is lost
                if goal != top:
                    left = np.log(total - out[partner, sample, goal])
                    out[partner, sample, goal] = log_q[partner, sample, top] + left
            total = 0.0
            for goal in range(goals):
                if goal != top and second > -np.inf:
                    total += np.exp(log_q[partner, sample, goal] - second)
            out[partner, sample, top] = second + np.log(total) if total > 0.0 else 0.0


@numba.njit(cache=True, nogil=True)
def weigh(log_belief: Float[np.ndarray, "sample goal"], log_weights: Float[np.ndarray, "sample goal"]) -> int:
    """Multiply beliefs by weights and normalise, in place; return the first sample that nothing is left of, or -1."""
    samples, goals = log_belief.shape
    for sample in range(samples):
        largest = -np.inf
        for goal in range(goals):
            log_belief[sample, goal] += log_weights[sample, goal]
            largest = max(largest, log_belief[sample, goal])
        if not largest > -np.inf:
            return sample
        total = 0.0
        for goal in range(goals):
            log_belief[sample, goal] -= largest
            total += np.exp(log_belief[sample, goal])
        log_total = np.log(total)
        for goal in range(goals):
            log_belief[sample, goal] -= log_total
    return -1
