"""Compiled scans of the goal models; imported only when a model first runs."""

from __future__ import annotations

import numba
import numpy as np
from jaxtyping import Bool, Float, Int

LEAST_EXPONENT = -700.0


@numba.njit(cache=True, nogil=True, error_model="numpy")
def cumulative_scores(
    state: Float[np.ndarray, "sample n"],
    control: Float[np.ndarray, "sample m"],
    informative: Bool[np.ndarray, " sample"],
    first: int,
    last: int,
    row_stop: Int[np.ndarray, " row"],
    K: Float[np.ndarray, "m n"],
    slope: Float[np.ndarray, "row goal m"],
    price: Float[np.ndarray, "row goal"],
    log_prior: Float[np.ndarray, "row goal"],
    reference: Float[np.ndarray, "row m"],
    carried: Float[np.ndarray, " carried"],
    scores: Float[np.ndarray, "block goal"],
    exponents: Float[np.ndarray, "block goal"],
) -> None:
    """Write slope . Z_t - price n_t + log_prior, less its maximum over goals, for the samples [first, last).

    The same goes to `exponents`, but nothing below `LEAST_EXPONENT`: what is smaller adds nothing to a sum that is at
    least 1, and exponentials that underflow take many times as long.

    Z_t is the sum of u + K x - reference over the informative samples of the row so far, and n_t their number; both
    restart exactly at every row. `carried` holds the row, n and Z where the block before this one ended.
    """
    goals, controls = slope.shape[1], slope.shape[2]
    states = state.shape[1]
    row = int(carried[0])
    count = carried[1]
    total = carried[2:].copy()
    sample = first
    while sample < last:
        while sample >= row_stop[row]:
            row += 1
            count = 0.0
            total[:] = 0.0
        stop = min(last, row_stop[row])
        row_slope, row_price, row_prior = slope[row], price[row], log_prior[row]
        for t in range(sample, stop):
            if informative[t]:
                count += 1.0
                for i in range(controls):
                    offset = control[t, i] - reference[row, i]
                    for j in range(states):
                        offset += K[i, j] * state[t, j]
                    total[i] += offset
            largest = -np.inf
            for goal in range(goals):
                score = row_prior[goal] - row_price[goal] * count
                for i in range(controls):
                    score += row_slope[goal, i] * total[i]
                scores[t - first, goal] = score
                largest = max(largest, score)
            for goal in range(goals):
                score = scores[t - first, goal] - largest
                scores[t - first, goal] = score
                exponents[t - first, goal] = max(score, LEAST_EXPONENT)
        sample = stop
    carried[0], carried[1] = row, count
    carried[2:] = total


@numba.njit(cache=True, nogil=True)
def normalise_rows(
    scores: Float[np.ndarray, "sample goal"], weights: Float[np.ndarray, "sample goal"]
) -> None:
    """Subtract log sum_g weights from every row of `scores`; weights are the exponentials of the scores."""
    for sample in range(scores.shape[0]):
        total = 0.0
        for goal in range(scores.shape[1]):
            total += weights[sample, goal]
        log_total = np.log(total)
        for goal in range(scores.shape[1]):
            scores[sample, goal] -= log_total


@numba.njit(cache=True, nogil=True)
def squared_residuals(
    offset: Float[np.ndarray, "sample m"],
    informative: Bool[np.ndarray, " sample"],
    row_size: Int[np.ndarray, " row"],
    best: Float[np.ndarray, "row goal m"],
    S: Float[np.ndarray, "m m"],
    squares: Float[np.ndarray, "sample goal"],
) -> None:
    """Write e' S e with e = offset - best for every sample and goal; zero where a sample is not informative."""
    goals, controls = best.shape[1], best.shape[2]
    residual = np.zeros(controls)
    sample = 0
    for row in range(len(row_size)):
        for _ in range(row_size[row]):
            for goal in range(goals):
                square = 0.0
                if informative[sample]:
                    for i in range(controls):
                        residual[i] = offset[sample, i] - best[row, goal, i]
                    for i in range(controls):
                        for j in range(controls):
                            square += residual[i] * S[i, j] * residual[j]
                squares[sample, goal] = square
            sample += 1


@numba.njit(cache=True, nogil=True, error_model="numpy")
def difference_motion(
    time: Float[np.ndarray, " sample"],
    position: Float[np.ndarray, "sample space"],
    velocity: Float[np.ndarray, "sample space"],
    velocity_logged: bool,
    seen: Bool[np.ndarray, " sample"],
    row_size: Int[np.ndarray, " row"],
    position_index: Int[np.ndarray, " space"],
    velocity_index: Int[np.ndarray, " _"],
    state: Float[np.ndarray, "sample n"],
    control: Float[np.ndarray, "sample m"],
    informative: Bool[np.ndarray, " sample"],
) -> None:
    """Write, at each sample, the state at the sample of its row seen before it and the control that led from there.

    The control is the difference of positions over time or, where the state holds velocities (an empty
    `velocity_index` says that it does not), that of velocities: as logged, or differences themselves. Zeros, and not
    `informative`, where too little was seen.
    """
    space, second_order = position.shape[1], len(velocity_index) > 0
    needed = 2 if second_order and not velocity_logged else 1
    speed, last_speed = np.zeros(space), np.zeros(space)
    sample = 0
    for row in range(len(row_size)):
        rank, last = 0, sample
        for _ in range(row_size[row]):
            tells = seen[sample] and rank >= needed
            informative[sample] = tells
            if not tells:
                state[sample] = 0.0
                control[sample] = 0.0
            if seen[sample]:
                elapsed = time[sample] - time[last]
                for i in range(space):
                    if velocity_logged:
                        speed[i] = velocity[sample, i]
                    elif rank > 0:
                        speed[i] = (position[sample, i] - position[last, i]) / elapsed
                    if tells:
                        state[sample, position_index[i]] = position[last, i]
                        if second_order:
                            state[sample, velocity_index[i]] = last_speed[i]
                            control[sample, i] = (speed[i] - last_speed[i]) / elapsed
                        else:
                            control[sample, i] = speed[i]
                    last_speed[i] = speed[i]
                rank, last = rank + 1, sample
            sample += 1


@numba.njit(cache=True, nogil=True)
def linear_motion(
    start: Float[np.ndarray, "row n"],
    goal: Float[np.ndarray, "row n"],
    row_size: Int[np.ndarray, " row"],
    noise: Float[np.ndarray, "sample m"],
    A: Float[np.ndarray, "n n"],
    B: Float[np.ndarray, "n m"],
    K: Float[np.ndarray, "m n"],
    goal_gain: Float[np.ndarray, "m n"],
    state: Float[np.ndarray, "sample n"],
    control: Float[np.ndarray, "sample m"],
) -> None:
    """Write the states and controls of x' = A x + B u, u = goal_gain theta - K x + noise, for every row."""
    states, controls = B.shape
    x = np.zeros(states)
    following = np.zeros(states)
    sample = 0
    for row in range(len(row_size)):
        x[:] = start[row]
        for _ in range(row_size[row]):
            for i in range(controls):
                u = noise[sample, i]
                for j in range(states):
                    u += goal_gain[i, j] * goal[row, j] - K[i, j] * x[j]
                control[sample, i] = u
            for i in range(states):
                state[sample, i] = x[i]
                value = 0.0
                for j in range(states):
                    value += A[i, j] * x[j]
                for j in range(controls):
                    value += B[i, j] * control[sample, j]
                following[i] = value
            x[:] = following
            sample += 1


@numba.njit(cache=True, nogil=True)
def kalman_bank(
    time: Float[np.ndarray, " sample"],
    position: Float[np.ndarray, "sample space"],
    seen: Bool[np.ndarray, " sample"],
    row_size: Int[np.ndarray, " row"],
    drive: Float[np.ndarray, "row goal n"],
    present: Bool[np.ndarray, "row goal"],
    F: Float[np.ndarray, "n n"],
    Q: Float[np.ndarray, "n n"],
    H: Float[np.ndarray, "space n"],
    R: Float[np.ndarray, "space space"],
    start_covariance: Float[np.ndarray, "n n"],
    dt: float,
    most_steps: int,
    gate_squared: float,
    reacquire_after: int,
    log_likelihood: Float[np.ndarray, "sample goal"],
    outlier: Bool[np.ndarray, " sample"],
) -> None:
    """Write the log density of every innovation under every goal, and which samples were gated.

    One Kalman filter a goal, x' = F x + drive; the covariance is the same for all of them, so it is stepped once.
    """
    goals, states = drive.shape[1], drive.shape[2]
    space = position.shape[1]
    identity = np.eye(states)
    FT = np.ascontiguousarray(F.T)
    HT = np.ascontiguousarray(H.T)
    x = np.zeros((goals, states))
    y = np.zeros((goals, space))
    sample = 0
    for row in range(len(row_size)):
        started = False
        rejected = 0
        P = start_covariance.copy()
        for _ in range(row_size[row]):
            outlier[sample] = False
            for goal in range(goals):
                log_likelihood[sample, goal] = 0.0
            if started:
                steps = int(
                    min(float(most_steps), max(1.0, np.round((time[sample] - time[sample - 1]) / dt)))
                )
                for _step in range(steps):
                    for goal in range(goals):
                        x[goal] = F @ x[goal] + drive[row, goal]
                    P = F @ P @ FT + Q
            if seen[sample]:
                if not started:
                    for goal in range(goals):
                        x[goal] = HT @ position[sample]
                    started = True
                else:
                    S = H @ P @ HT + R
                    S_inverse = np.linalg.inv(S)
                    nearest = np.inf
                    for goal in range(goals):
                        y[goal] = position[sample] - H @ x[goal]
                        if present[row, goal]:
                            nearest = min(nearest, float(y[goal] @ (S_inverse @ y[goal])))
                    if nearest > gate_squared:
                        outlier[sample] = True
                        rejected += 1
                        if rejected >= reacquire_after:
                            for goal in range(goals):
                                x[goal] = HT @ position[sample]
                            P = start_covariance.copy()
                            rejected = 0
                    else:
                        rejected = 0
                        constant = -0.5 * (np.linalg.slogdet(S)[1] + space * np.log(2 * np.pi))
                        gain = P @ HT @ S_inverse
                        for goal in range(goals):
                            log_likelihood[sample, goal] = constant - 0.5 * float(
                                y[goal] @ (S_inverse @ y[goal])
                            )
                            x[goal] = x[goal] + gain @ y[goal]
                        kept = identity - gain @ H
                        P = kept @ P @ np.ascontiguousarray(kept.T) + gain @ R @ np.ascontiguousarray(gain.T)
            sample += 1


@numba.njit(cache=True, nogil=True)
def walk(
    start: Float[np.ndarray, "row 2"],
    goal: Float[np.ndarray, "row 2"],
    row_size: Int[np.ndarray, " row"],
    share: float,
    turn: Float[np.ndarray, " sample"],
    position: Float[np.ndarray, "sample 2"],
) -> None:
    """Write positions that step towards a goal, each step turned by an angle and `share` of the first distance long."""
    sample = 0
    for row in range(len(row_size)):
        x, y = start[row]
        length = share * np.hypot(goal[row, 0] - x, goal[row, 1] - y)
        for _ in range(row_size[row]):
            position[sample, 0], position[sample, 1] = x, y
            angle = np.arctan2(goal[row, 1] - y, goal[row, 0] - x) + turn[sample]
            x += length * np.cos(angle)
            y += length * np.sin(angle)
            sample += 1
