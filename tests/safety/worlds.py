"""Agents and scenes that the tests of safety share."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_discrete_are

from ppinfer.safety import LinearAgent, Mover


def double_integrator(noise=0.0, limit=None, dt=0.1):
    A = np.kron(np.eye(2), [[1.0, dt], [0.0, 1.0]])
    B = np.kron(np.eye(2), [[0.5 * dt**2], [dt]])
    P = solve_discrete_are(A, B, 10 * np.eye(4), np.eye(2))
    K = np.linalg.solve(np.eye(2) + B.T @ P @ B, B.T @ P @ A)
    W = np.diag([0.0, noise**2, 0.0, noise**2]) if noise else None
    return LinearAgent(A, B, K, (0, 2), noise=W, control_limit=limit)


def single_integrator(noise=0.0, limit=None, space=2, gain=1.0, dt=0.1):
    eye = np.eye(space)
    W = noise**2 * eye if noise else None
    return LinearAgent(eye, dt * eye, gain * eye, tuple(range(space)), noise=W, control_limit=limit)


def at(x, y):
    """Return a double integrator's state at rest."""
    return np.array([x, 0.0, y, 0.0])


def heading(agent, state, targets, probability):
    return Mover(agent, np.asarray(state, float), np.asarray(targets, float), np.asarray(probability, float))


def oncoming(noise=0.3, probability=(0.6, 0.4)):
    """Return a human who comes the other way, or turns off."""
    return heading(double_integrator(noise), at(5, 0), [at(-5, 0), at(0, 5)], probability)
