"""Where agents may be: their nominal motion, and independent rollouts of it with disturbances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ppinfer.errors import SafetyError
from ppinfer.safety.motion import LinearAgent, Mover


@dataclass(frozen=True, eq=False)
class Rollouts:
    """Independent futures of some agents who do not avoid anybody.

    Parameters
    ----------
    positions : (other, instant, space, rollout) float64
        Where each is, from now on.
    mode : (other, rollout) int64
        Which target it pursues.
    noise : tuple of (step, rank, rollout) float64
        For each agent, the standard normal numbers that disturbed it.
    """

    positions: Float[np.ndarray, "other instant space rollout"]
    mode: Int[np.ndarray, "other rollout"]
    noise: tuple[np.ndarray, ...]

    @property
    def rollouts(self) -> int:
        """How many futures there are."""
        return int(self.positions.shape[3])


def nominal_motion(
    agent: LinearAgent,
    start: Float[np.ndarray, "row n"],
    targets: Float[np.ndarray, "row n"],
    horizon: int,
) -> tuple[Float[np.ndarray, "row instant n"], Float[np.ndarray, "row step m"]]:
    """Return states and controls of an agent that pursues its target without any disturbance.

    Parameters
    ----------
    agent : LinearAgent
        Who moves; its control is shortened to its limit.
    start, targets : (row, n) float64
        From which state, towards which.
    horizon : int
        Steps.

    Examples
    --------
    >>> agent = LinearAgent(np.eye(1), 0.1 * np.eye(1), np.eye(1), (0,))
    >>> states, controls = nominal_motion(agent, np.zeros((1, 1)), np.ones((1, 1)), 2)
    >>> states[0, :, 0], controls[0, :, 0]
    (array([0.  , 0.1 , 0.19]), array([1. , 0.9]))
    """
    # imported here: it compiles
    from ppinfer.safety.scans import pursue

    states = np.empty((len(start), horizon + 1, len(agent.A)))
    controls = np.empty((len(start), horizon, agent.B.shape[1]))
    start, targets = (np.ascontiguousarray(rows, dtype=np.float64) for rows in (start, targets))
    pursue(start, targets, agent.A, agent.B, agent.gain, _limit(agent), states, controls)
    return states, controls


def draw_rollouts(others: Sequence[Mover], horizon: int, rollouts: int, rng: np.random.Generator) -> Rollouts:
    """Draw futures of other agents: a target from the probability of each, then a disturbance at every step.

    Parameters
    ----------
    others : sequence of Mover
        Who they are; all in the same space.
    horizon : int
        Steps, at least 1.
    rollouts : int
        Futures, at least 1.
    rng : numpy.random.Generator
        Where chance comes from.

    Raises
    ------
    SafetyError
        Where there is nobody, the spaces differ, or a count is below 1.

    Notes
    -----
    Rollouts are independent and identically distributed; they are listed by the mode of the first agent.

    Examples
    --------
    >>> agent = LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1), noise=0.01 * np.eye(2))
    >>> mover = Mover(agent, np.zeros(2), np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([0.7, 0.3]))
    >>> draw_rollouts([mover], 10, 100, np.random.default_rng(0)).positions.shape
    (1, 11, 2, 100)
    """
    if horizon < 1 or rollouts < 1:
        raise SafetyError(f"horizon and rollouts must be at least 1; got {horizon} and {rollouts}")
    if not others:
        raise SafetyError("there must be at least one other agent to draw rollouts of")
    spaces = {len(other.agent.position_index) for other in others}
    if len(spaces) > 1:
        raise SafetyError(f"all agents must move in the same space; their positions have {spaces} entries")
    positions = np.empty((len(others), horizon + 1, spaces.pop(), rollouts))
    mode = np.empty((len(others), rollouts), dtype=np.int64)
    noise = []
    for index, other in enumerate(others):
        mode[index] = draw_modes(other.probability, rollouts, rng)
        if index == 0:
            # neighbours in the list stay near each other in space; the others' modes stay independent of it
            mode[index].sort()
        noise.append(_roll(other.agent, other.state, other.targets, mode[index], rng, positions[index]))
    return Rollouts(positions, mode, tuple(noise))


def draw_modes(
    probability: Float[np.ndarray, " mode"], count: int, rng: np.random.Generator
) -> Int[np.ndarray, " count"]:
    """Draw independent modes by their probability."""
    if len(probability) == 1:
        return np.zeros(count, dtype=np.int64)
    edges = np.cumsum(probability)
    # rounding must not leave room above the last possible mode
    edges[np.flatnonzero(probability)[-1] :] = np.inf
    return np.searchsorted(edges, rng.random(count), side="right").astype(np.int64)


def roll_robot(
    robot: LinearAgent,
    state: Float[np.ndarray, " n"],
    target: Float[np.ndarray, " n"],
    horizon: int,
    rollouts: int,
    rng: np.random.Generator,
) -> tuple[Float[np.ndarray, "instant space rollout"], np.ndarray]:
    """Return positions in independent rollouts of one agent and one target, and their noise."""
    positions = np.empty((horizon + 1, len(robot.position_index), rollouts))
    mode = np.zeros(rollouts, dtype=np.int64)
    return positions, _roll(robot, state, target[None], mode, rng, positions)


def _roll(
    agent: LinearAgent,
    state: Float[np.ndarray, " n"],
    targets: Float[np.ndarray, "mode n"],
    mode: Int[np.ndarray, " rollout"],
    rng: np.random.Generator,
    positions: Float[np.ndarray, "instant space rollout"],
) -> np.ndarray:
    # imported here: they compile
    from ppinfer.safety.scans import roll_out, roll_out_limited

    root = disturbance_root(agent)
    noise = rng.standard_normal((positions.shape[0] - 1, root.shape[1], len(mode)))
    index = np.array(agent.position_index, dtype=np.int64)
    targets, start = np.ascontiguousarray(targets), np.ascontiguousarray(state, dtype=np.float64)
    if agent.control_limit is None:
        loop = np.ascontiguousarray(agent.closed_loop)
        drive = np.ascontiguousarray(targets @ (agent.B @ agent.gain).T)
        roll_out(start, drive, mode, loop, root, noise, index, positions)
    else:
        roll_out_limited(
            start, targets, mode, agent.A, agent.B, agent.gain, _limit(agent), root, noise, index, positions
        )
    return noise


def disturbance_root(agent: LinearAgent) -> Float[np.ndarray, "n rank"]:
    """Return L with L L' = W and no column of zeros: as few normal numbers a step as W has rank."""
    root = agent.noise_root
    return np.ascontiguousarray(root[:, np.abs(root).max(axis=0) > 0.0])


def _limit(agent: LinearAgent) -> float:
    return np.inf if agent.control_limit is None else float(agent.control_limit)
