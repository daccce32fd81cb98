"""The long-term safe probability of going for a target, and of many candidate plans at once (Algorithm 2)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from ppinfer.errors import SafetyError
from ppinfer.safety.distances import Body, stack_bodies
from ppinfer.safety.motion import LinearAgent, Mover
from ppinfer.safety.obstacles import StaticObstacle, stack_obstacles
from ppinfer.safety.probability import SafeProbabilities, SafeProbability
from ppinfer.safety.rollouts import Rollouts, disturbance_root, draw_rollouts, nominal_motion, roll_robot


def long_term_safe_probability(
    robot: LinearAgent,
    state: Float[np.ndarray, " n"],
    target: Float[np.ndarray, " n"],
    others: Sequence[Mover],
    *,
    distance: float | Sequence[float] = 1.0,
    horizon: int = 50,
    rollouts: int = 1000,
    static: Sequence[StaticObstacle] = (),
    body: Body | None = None,
    bodies: Sequence[Body | None] | None = None,
    rng: np.random.Generator,
) -> SafeProbability:
    """Estimate how likely a robot that pursues a target stays clear of everybody (LONGTERMSAFEPROB of Algorithm 2).

    1. In each rollout every other agent draws its target from its probability and pursues it, disturbed at every
       step; it avoids nobody, which is the worst case. The robot pursues its own, disturbed if it has noise.
    2. A rollout is safe where at every t = 0..H the robot's position is at least the distance from everyone's.

    Parameters
    ----------
    robot : LinearAgent
        How the robot moves.
    state, target : (n,) float64
        Where it is, and the state it pursues.
    others : sequence of Mover
        The other agents.
    distance : float or one for each of the others
        d_min (m).
    horizon : int
        H, steps.
    rollouts : int
        n.
    static : sequence of StaticObstacle
        What stands still.
    body, bodies : Body, sequence of Body
        Capsules of the robot and of each of the others, where they are more than points (None); then `distance` is
        the least gap between their surfaces, and that of a static obstacle the gap from its centre.
    rng : numpy.random.Generator
        Where chance comes from.

    Returns
    -------
    SafeProbability
        Whose lower bound decides.

    Raises
    ------
    SafetyError
        Where shapes, spaces or counts do not fit.

    Examples
    --------
    >>> walker = LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1), noise=0.0004 * np.eye(2))
    >>> human = Mover(walker, np.array([4.0, 0.0]), np.array([[-4.0, 0.0], [4.0, 4.0]]), np.array([0.2, 0.8]))
    >>> robot = LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1))
    >>> found = long_term_safe_probability(
    ...     robot, np.array([-4.0, 0.0]), np.array([4.0, 0.0]), [human], rng=np.random.default_rng(0)
    ... )
    >>> 0.75 < found.estimate < 0.85, found.is_safe(eps=0.05)
    (True, False)
    """
    state, target = _state(robot, state, "state"), _state(robot, target, "target")
    deviation = None
    if robot.noise is None or not disturbance_root(robot).size:
        plan = robot.position(nominal_motion(robot, state[None], target[None], horizon)[0])
    else:
        # the robot's own rollouts are all there is to its plan
        plan = np.zeros((1, horizon + 1, len(robot.position_index)))
        deviation, _ = roll_robot(robot, state, target, horizon, rollouts, rng)
    drawn = draw_rollouts(others, horizon, rollouts, rng) if others else None
    return _count(plan, drawn, deviation, rollouts, distance, static, body, bodies)[0]


def plan_safe_probability(
    plans: Float[np.ndarray, "candidate instant space"],
    others: Sequence[Mover] | Rollouts,
    *,
    distance: float | Sequence[float] = 1.0,
    rollouts: int = 1000,
    static: Sequence[StaticObstacle] = (),
    robot: LinearAgent | None = None,
    body: Body | None = None,
    bodies: Sequence[Body | None] | None = None,
    rng: np.random.Generator,
) -> SafeProbabilities:
    """Estimate how likely each of many candidate plans stays clear of everybody.

    The others avoid nobody, so their rollouts are drawn once and every candidate is held against the same ones
    (common random numbers): a candidate costs its distance checks only. Choosing by these counts needs the Bonferroni
    correction, which `SafeProbabilities` makes by default, or a fresh look at the chosen one (`choose_safe_plan`).

    Parameters
    ----------
    plans : (candidate, instant, space) float64
        Positions from now on, t = 0..H (m).
    others : sequence of Mover, or Rollouts
        The other agents, or futures of theirs that are drawn already.
    distance, static, body, bodies, rng
        As of `long_term_safe_probability`.
    rollouts : int
        n, where they are not drawn already.
    robot : LinearAgent, optional
        If it has noise: the robot follows a plan with its gain and strays from it; without, it is where the plan says.

    Returns
    -------
    SafeProbabilities
        One count for each candidate.

    Raises
    ------
    SafetyError
        Where shapes, spaces or counts do not fit; where a robot with noise has a control limit too, since how it
        strays depends on the plan then.

    Examples
    --------
    >>> walker = LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1), noise=0.0004 * np.eye(2))
    >>> human = Mover(walker, np.array([4.0, 0.0]), np.array([[-4.0, 0.0]]), np.array([1.0]))
    >>> stay = np.zeros((21, 2))
    >>> aside = np.stack([np.zeros(21), np.linspace(0.0, 8.0, 21)], axis=1)
    >>> found = plan_safe_probability(np.stack([stay, aside]), [human], rng=np.random.default_rng(0))
    >>> found.is_safe()
    array([False,  True])
    """
    plans = np.ascontiguousarray(plans, dtype=np.float64)
    horizon = plans.shape[1] - 1
    deviation = None
    drawn: Rollouts | None
    if isinstance(others, Rollouts):
        drawn, rollouts = others, others.rollouts
    else:
        drawn = draw_rollouts(others, horizon, rollouts, rng) if others else None
    if robot is not None and disturbance_root(robot).size:
        if robot.control_limit is not None:
            raise SafetyError(
                "how a robot with noise and a control limit strays depends on the plan: use "
                "long_term_safe_probability for each target, or leave out the limit"
            )
        origin = np.zeros(len(robot.A))
        deviation, _ = roll_robot(robot, origin, origin, horizon, rollouts, rng)
    return _count(plans, drawn, deviation, rollouts, distance, static, body, bodies)


def _count(
    plans: Float[np.ndarray, "candidate instant space"],
    drawn: Rollouts | None,
    deviation: Float[np.ndarray, "instant space rollout"] | None,
    rollouts: int,
    distance: float | Sequence[float],
    static: Sequence[StaticObstacle],
    body: Body | None,
    bodies: Sequence[Body | None] | None,
) -> SafeProbabilities:
    # imported here: it compiles
    from ppinfer.safety.scans import count_safe, count_safe_bodies

    candidates, instants, space = plans.shape
    positions = np.empty((0, instants, space, rollouts)) if drawn is None else drawn.positions
    if positions.shape[1:3] != (instants, space):
        raise SafetyError(
            f"plans of {instants} instants in {space} dimensions meet rollouts of {positions.shape[1]} in "
            f"{positions.shape[2]}: draw them over the same horizon and space"
        )
    shapes = list(bodies or [None] * len(positions))
    if len(shapes) != len(positions):
        raise SafetyError(f"give one body (or None) for each of {len(positions)} others; got {len(shapes)}")
    required = _distances(distance, len(positions))
    where, apart = stack_obstacles(static, space)
    extended = body is not None or any(one is not None for one in shapes)
    if deviation is not None or extended:
        standing = np.broadcast_to(where[:, None, :, None], (len(where), instants, space, rollouts))
        positions = np.concatenate([positions, standing])
        required = np.concatenate([required, apart])
        shapes += [None] * len(where)
        where, apart = where[:0], apart[:0]
    if deviation is not None:
        # seen from the robot's plan, whatever the robot strays the others stray the other way
        positions = positions - deviation
    safe = np.empty(candidates, dtype=np.int64)
    plans = np.ascontiguousarray(plans)
    if extended:
        own_start, own_end, own_radius, first, start, end, radius, reach = stack_bodies(
            body, shapes, required, space
        )
        count_safe_bodies(
            plans, positions, required, own_start, own_end, own_radius, first, start, end, radius, reach, safe
        )
    else:
        count_safe(plans, positions, required, where, apart, safe)
    return SafeProbabilities(safe, rollouts)


def _distances(distance: float | Sequence[float], others: int) -> Float[np.ndarray, " other"]:
    given = np.asarray(distance, dtype=np.float64)
    if given.ndim > 1 or (given.ndim == 1 and len(given) != others) or not (given >= 0).all():
        raise SafetyError(
            f"distance must be one number that is not negative, or one for each of {others} others; got {distance!r}"
        )
    return np.full(others, given) if given.ndim == 0 else given


def _state(robot: LinearAgent, value: Float[np.ndarray, " _"], name: str) -> Float[np.ndarray, " n"]:
    state = np.ascontiguousarray(value, dtype=np.float64)
    if state.shape != (len(robot.A),) or not np.isfinite(state).all():
        raise SafetyError(f"{name} must be {len(robot.A)} finite numbers; got {value!r}")
    return state
