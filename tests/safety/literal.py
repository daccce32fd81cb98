"""Algorithms 2 and 3 as printed, one rollout, instant and mode after another, but for what cannot be taken literally.

Chance is given (`noise`, `mode`, `obstacles`), so that these and the array programs answer the same question. What is
read otherwise than printed: the robot's goal is known to every call, a control is -K (x - goal), a potential field
repels, rollouts restart from the state now and are looked at from t = 0 to H, and a candidate that is unsafe is marked
and kept.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def goal_control(agent: Any, x: np.ndarray, goal: np.ndarray) -> np.ndarray:
    u = -agent.gain @ (x - goal)
    length = math.sqrt(float(u @ u))
    if agent.control_limit is not None and length > agent.control_limit:
        u = u * (agent.control_limit / length)
    return u


def step(agent: Any, x: np.ndarray, u: np.ndarray, disturbance: np.ndarray | None = None) -> np.ndarray:
    following = agent.A @ x + agent.B @ u
    return following if disturbance is None else following + disturbance


def position(agent: Any, x: np.ndarray) -> np.ndarray:
    return x[list(agent.position_index)]


def root(agent: Any) -> np.ndarray:
    L = agent.noise_root
    return L[:, np.abs(L).max(axis=0) > 0]


def long_term_safe_prob(
    robot: Any,
    x_R: np.ndarray,
    goal: np.ndarray,
    others: Any,
    d_min: Any,
    H: int,
    mode: np.ndarray,
    noise: Any,
    robot_noise: np.ndarray | None = None,
    static: Any = (),
) -> np.ndarray:
    """Return F, 1 for every safe rollout; noise[i][t, :, k] disturbs other i in rollout k."""
    n = mode.shape[1]
    F = np.ones(n, dtype=int)
    for k in range(n):
        x = x_R.copy()
        them = [other.state.copy() for other in others]
        for t in range(H + 1):
            p = position(robot, x)
            for other, y, d in zip(others, them, d_min, strict=True):
                if np.linalg.norm(p - position(other.agent, y)) < d:
                    F[k] = 0
            for obstacle in static:
                if np.linalg.norm(p - obstacle.position) < obstacle.distance:
                    F[k] = 0
            if F[k] == 0 or t == H:
                break
            u = goal_control(robot, x, goal)
            disturbance = None if robot_noise is None else root(robot) @ robot_noise[t, :, k]
            x = step(robot, x, u, disturbance)
            for i, other in enumerate(others):
                u_H = goal_control(other.agent, them[i], other.targets[mode[i, k]])
                them[i] = step(other.agent, them[i], u_H, root(other.agent) @ noise[i][t, :, k])
    return F


def draw_and_roll(
    robot: Any, x_R: np.ndarray, goal: np.ndarray, others: Any, d_min: float, H: int, n: int, rng: Any
) -> float:
    """Return mean(F), chance drawn on the way: what the printed algorithm does and a benchmark may time."""
    safe = 0
    for _ in range(n):
        x = x_R.copy()
        them = [other.state.copy() for other in others]
        goals = [other.targets[rng.choice(other.modes, p=other.probability)] for other in others]
        for t in range(H + 1):
            p = position(robot, x)
            if any(
                np.linalg.norm(p - position(other.agent, y)) < d_min
                for other, y in zip(others, them, strict=True)
            ):
                break
            if t == H:
                safe += 1
                break
            x = step(robot, x, goal_control(robot, x, goal))
            for i, other in enumerate(others):
                W = root(other.agent)
                disturbance = W @ rng.standard_normal(W.shape[1])
                them[i] = step(
                    other.agent, them[i], goal_control(other.agent, them[i], goals[i]), disturbance
                )
    return safe / n


def printed_accepts(F: np.ndarray, eps: float) -> bool:
    """Return what the printed Algorithm 2 decides by."""
    return bool(np.mean(F) > 1 - eps)


def safe_control(
    robot: Any, x_R: np.ndarray, goal: np.ndarray, x_safe: np.ndarray | None, gamma: float, clip: float
) -> np.ndarray:
    """Return the control of Algorithm 2 where x_safe was found, or none was needed."""
    u = goal_control(robot, x_R, goal)
    if x_safe is not None:
        off = position(robot, x_R) - position(robot, x_safe)
        d = max(float(np.linalg.norm(off)), clip)
        u = u - gamma / d**2 * off
    return u


def push(p: np.ndarray, o: np.ndarray, gamma: float, clip: float) -> np.ndarray:
    d = max(float(np.linalg.norm(p - o)), clip)
    return gamma / d**2 * (p - o)


def printed_push(p: np.ndarray, o: np.ndarray, gamma: float) -> np.ndarray:
    """Return (29) with the sign that is printed."""
    d = float(np.linalg.norm(p - o))
    return gamma / d**2 * (o - p)


def traj_gen(
    robot: Any,
    x_R: np.ndarray,
    goal: np.ndarray,
    others: Any,
    obstacles: np.ndarray,
    H: int,
    d_min: float,
    radius: Any,
    gamma: float,
    clip: float,
    least: float = 0.05,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return states, controls, s and the smallest distance of every candidate; radius(agent)[t] is kappa sigma_t."""
    M = len(obstacles) + 1
    X = np.empty((M, H + 1, len(x_R)))
    U = np.empty((M, H, robot.B.shape[1]))
    s, smallest = np.ones(M, dtype=bool), np.full(M, np.inf)
    grown = [radius(other.agent) for other in others]
    for m in range(M):
        X[m, 0] = x_R
        them = {
            (i, j): other.state.copy()
            for i, other in enumerate(others)
            for j in range(other.modes)
            if other.probability[j] > least
        }
        for t in range(H + 1):
            p = position(robot, X[m, t])
            u = -robot.gain @ (X[m, t] - goal)
            if m > 0:
                u = u + push(p, obstacles[m - 1], gamma, clip)
            for (i, j), y in them.items():
                other = others[i]
                at = position(other.agent, y)
                d = float(np.linalg.norm(p - at))
                if t > 0:
                    smallest[m] = min(smallest[m], d)
                if d <= d_min + grown[i][t]:
                    s[m] = False
                u = u + other.probability[j] * push(p, at, gamma, clip)
                them[i, j] = step(other.agent, y, goal_control(other.agent, y, other.targets[j]))
            if t == H:
                break
            length = float(np.linalg.norm(u))
            if robot.control_limit is not None and length > robot.control_limit:
                u = u * (robot.control_limit / length)
            U[m, t] = u
            X[m, t + 1] = step(robot, X[m, t], u)
    return X, U, s, smallest
