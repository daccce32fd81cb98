"""Where the robot had better be: a state near it from which going on would be safe (FINDSAFESTATE of Algorithm 2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ppinfer.errors import SafetyError
from ppinfer.safety.long_term import long_term_safe_probability, plan_safe_probability
from ppinfer.safety.motion import LinearAgent, Mover
from ppinfer.safety.obstacles import StaticObstacle
from ppinfer.safety.probability import SafeProbabilities, SafeProbability
from ppinfer.safety.rollouts import Rollouts, disturbance_root, draw_rollouts, nominal_motion


@dataclass(frozen=True, eq=False)
class SafeState:
    """A state at rest near the robot, and how safe a robot would be there; the robot itself is not there yet.

    Parameters
    ----------
    state : (n,) float64
        Where: a position, and zero for every other entry.
    certificate : SafeProbability
        Of pursuing the target from there, now; counted on rollouts that it shared with the other states looked at.
    radius : float
        Of the ball about the robot in which it was found (m).
    found : bool
        Whether that is safe enough, with the correction for all states looked at; if not it is the best one seen.
    looked_at : int
        States looked at.
    """

    state: Float[np.ndarray, " n"]
    certificate: SafeProbability
    radius: float
    found: bool
    looked_at: int


def find_safe_state(
    robot: LinearAgent,
    state: Float[np.ndarray, " n"],
    target: Float[np.ndarray, " n"],
    others: Sequence[Mover],
    *,
    distance: float | Sequence[float] = 1.0,
    horizon: int = 50,
    rollouts: int = 1000,
    eps: float = 0.05,
    confidence: float = 0.99,
    samples: int = 64,
    radius: float = 1.0,
    radius_step: float = 1.0,
    radius_limit: float = 4.0,
    static: Sequence[StaticObstacle] = (),
    rng: np.random.Generator,
) -> SafeState:
    """Find the nearest of some random states from which pursuing the target would be safe (FINDSAFESTATE).

    1. Draw states at rest, evenly in a ball about the robot's position.
    2. Of those whose probability of staying safe is at least 1 - eps, with the confidence for all states that may be
       looked at together (Bonferroni), take the nearest. All are held against the same rollouts.
    3. If there is none, draw anew in a larger ball, up to the limit; then return the best state seen, and say so.

    Parameters
    ----------
    robot, state, target, others, distance, horizon, rollouts, static, rng
        As of `long_term_safe_probability`.
    eps, confidence : float
        What counts as safe enough.
    samples : int
        States in each ball.
    radius, radius_step, radius_limit : float
        The first ball's, what it grows by, and the last one's (m).

    Raises
    ------
    SafetyError
        Where shapes, spaces or counts do not fit.

    Examples
    --------
    >>> walker = LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1), noise=0.0004 * np.eye(2))
    >>> human = Mover(walker, np.array([3.0, 0.0]), np.array([[-4.0, 0.0]]), np.array([1.0]))
    >>> robot = LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1))
    >>> found = find_safe_state(robot, np.zeros(2), np.array([0.0, 4.0]), [human], rng=np.random.default_rng(0))
    >>> found.found, found.radius, found.state.round(1)
    (True, 1.0, array([ 0.1, -0. ]))
    """
    if samples < 1 or not 0.0 < radius <= radius_limit or not radius_step > 0.0:
        raise SafetyError(
            f"samples must be at least 1, 0 < radius <= radius_limit and radius_step positive; got {samples!r}, "
            f"{radius!r}, {radius_limit!r}, {radius_step!r}"
        )
    balls = 1 + int(np.floor((radius_limit - radius) / radius_step + 1e-9))
    position = robot.position(np.asarray(state, dtype=np.float64))
    shared = draw_rollouts(others, horizon, rollouts, rng)
    best: SafeState | None = None
    for ball in range(balls):
        size = radius + ball * radius_step
        offset = _ball(samples, len(position), rng) * size
        order = np.argsort((offset * offset).sum(axis=1), kind="stable")
        states = np.zeros((samples, len(robot.A)))
        states[:, list(robot.position_index)] = position + offset[order]
        safe = _count_safe(robot, states, target, others, shared, distance, static, rng)
        enough = safe.is_safe(eps, confidence, among=balls * samples)
        # the nearest come first
        pick = int(np.argmax(enough)) if enough.any() else int(np.argmax(safe.safe))
        found = SafeState(states[pick], safe[pick], size, bool(enough[pick]), (ball + 1) * samples)
        if found.found:
            return found
        if best is None or found.certificate.safe > best.certificate.safe:
            best = found
    assert best is not None
    return SafeState(best.state, best.certificate, best.radius, False, balls * samples)


def _count_safe(
    robot: LinearAgent,
    states: Float[np.ndarray, "candidate n"],
    target: Float[np.ndarray, " n"],
    others: Sequence[Mover],
    shared: Rollouts,
    distance: float | Sequence[float],
    static: Sequence[StaticObstacle],
    rng: np.random.Generator,
) -> SafeProbabilities:
    horizon, rollouts = shared.positions.shape[1] - 1, shared.rollouts
    if robot.control_limit is not None and disturbance_root(robot).size:
        # how it strays depends on where it starts: rollouts cannot be shared, and this is rarely asked for
        counts = [
            long_term_safe_probability(
                robot, one, target, others, distance=distance, horizon=horizon, rollouts=rollouts, static=static,
                rng=rng,
            ).safe
            for one in states
        ]  # fmt: skip
        return SafeProbabilities(np.array(counts, dtype=np.int64), rollouts)
    targets = np.repeat(np.asarray(target, dtype=np.float64)[None], len(states), axis=0)
    plans = robot.position(nominal_motion(robot, states, targets, horizon)[0])
    return plan_safe_probability(plans, shared, distance=distance, static=static, robot=robot, rng=rng)


def _ball(count: int, space: int, rng: np.random.Generator) -> Float[np.ndarray, "count space"]:
    """Return points evenly distributed in the unit ball."""
    direction = rng.standard_normal((count, space))
    direction /= np.sqrt((direction * direction).sum(axis=1, keepdims=True))
    points: np.ndarray = direction * rng.random((count, 1)) ** (1.0 / space)
    return points
