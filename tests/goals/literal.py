"""Equations (22)-(27) as printed, and brute-force oracles: slow, and sharing nothing with the library."""

import itertools
import math

import numpy as np
from scipy.linalg import solve_discrete_are


def literal_q(x, u, goal, A, B, Q, R, P):
    """(23)-(24): instantaneous reward minus the cost to go."""
    reward = -(x - goal) @ Q @ (x - goal) - u @ R @ u
    following = A @ x + B @ u
    return reward - (following - goal) @ P @ (following - goal)


def literal_log_normaliser(x, goal, A, B, Q, R, P, beta):
    """(26), in log."""
    m = B.shape[1]
    determinant = np.linalg.det(2 * beta * R + 2 * beta * B.T @ P @ B)
    return -beta * (x - goal) @ P @ (x - goal) + 0.5 * math.log((2 * math.pi) ** m / determinant)


def literal_log_density(x, u, goal, A, B, Q, R, beta):
    """(22) with (26)."""
    P = solve_discrete_are(A, B, Q, R)
    return beta * literal_q(x, u, goal, A, B, Q, R, P) - literal_log_normaliser(x, goal, A, B, Q, R, P, beta)


def literal_belief(log_likelihood, prior, transition=None):
    """(27), one sample after another, in ordinary arithmetic."""
    belief, beliefs = np.array(prior, dtype=float), []
    for t, row in enumerate(log_likelihood):
        if t and transition is not None:
            belief = belief @ transition
        belief = belief * np.exp(row - row.max())
        belief = belief / belief.sum()
        beliefs.append(belief)
    return np.array(beliefs)


def enumerated_smoother(log_likelihood, prior, transition):
    """The posterior at each sample given all of them, summed over every sequence of goals."""
    samples, goals = log_likelihood.shape
    total = np.zeros((samples, goals))
    for path in itertools.product(range(goals), repeat=samples):
        weight = prior[path[0]] * np.prod([transition[i, j] for i, j in itertools.pairwise(path)])
        weight *= math.exp(sum(log_likelihood[t, goal] for t, goal in enumerate(path)))
        for t, goal in enumerate(path):
            total[t, goal] += weight
    return total / total.sum(axis=1, keepdims=True)
