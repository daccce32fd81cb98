"""Candidate plans of an arm: raw paths of a sampling-based planner in joint space, timed by the joints' speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from ppinfer.coordination.plans import PlanSet
from ppsim.arms.geometry import Arm
from ppsim.arms.world import STEP
from ppsim.errors import SimulationError


@dataclass(frozen=True, eq=False)
class Rest:
    """What is left of a plan that an agent is executing.

    Parameters
    ----------
    time : (waypoint,) float64
        Seconds from now; 0 at the first.
    position : (waypoint, joint) float64
        Joint angles, rad.
    """

    time: Float[np.ndarray, " waypoint"]
    position: Float[np.ndarray, "waypoint joint"]


def sample_plans(
    arm: Arm,
    agent: str,
    start: Any,
    goals: Sequence[Any],
    *,
    seed: int,
    count: int = 7,
    planner: str = "RRT",
    planner_range: float | None = None,
    committed: Rest | None = None,
) -> PlanSet:
    """Sample plans that bring an arm to its goals one after the other, and add the one that does not move.

    1. For every plan and every leg (from start to the first goal, from there to the next) a planner of OMPL is
       constructed anew, seeded, and solves in joint space, where nothing is in the way. The path is taken raw: all its
       vertices are waypoints, nothing is simplified, so that plans differ.
    2. Joints move in step, the one with the farthest to go at its full speed along each edge; then each leg is
       stretched a little so that it ends on a multiple of `STEP`.
    3. The static plan comes last. `committed`, where there is one, takes the place of the first sampled plan.

    The same arguments give the same plans, in any process and whatever was planned before: planners are stopped by
    counting, never by the clock, and a planner that found no exact path is seeded anew.

    Parameters
    ----------
    arm : Arm
        Whose limits bound the joint space, and whose joint speed times the plans.
    agent : str
        Its name.
    start : (joint,) float
        Joint angles now, rad.
    goals : sequence of (joint,) or (way, joint) float
        Joint angles to reach in order, rad: pick and place, or place alone once the object is held. Where there are
        several ways to reach one (either elbow), each plan takes one at random.
    seed : int
        Of all the plans; the first plans of a larger set are those of a smaller one.
    count : int
        How many plans besides the static one.
    planner : str
        One of `ppsim.arms.planners.PLANNERS`.
    planner_range : float, optional
        Longest edge that the planner adds to its tree, rad; by default the planner's own choice, a fifth of the
        space's diagonal, which is 1.66 rad for the arms of the study.
    committed : Rest, optional
        What is left of the plan that the agent is executing; see `rest_of_plan`.

    Raises
    ------
    SimulationError
        If the planner is unknown, start or a goal is beyond the arm's limits, or a planner found no exact path in
        any of its attempts.

    Examples
    --------
    >>> arm = Arm(base=(0.0, 0.0))
    >>> plans = sample_plans(arm, "robot", arm.home, [[0.5, 0.5], [-0.5, 1.0]], seed=3)
    >>> len(plans), plans.static
    (8, 7)
    >>> bool(np.allclose(plans.positions(plans.duration.max())[:7, 0], [-0.5, 1.0]))
    True
    """
    sampled = count - (committed is not None)
    if count < 1:
        raise SimulationError(f"at least one plan is needed besides the static one; got count={count}")
    ways = [np.atleast_2d(np.asarray(goal, np.float64)) for goal in goals]
    here = np.asarray(start, np.float64)[None]
    _check_stops(arm, agent, np.concatenate([here, *ways]))
    legs = len(ways)
    # all is drawn for all plans, so that committing to one leaves the others as they were
    drawn = np.random.SeedSequence(seed).generate_state(2 * count * legs, np.uint32).reshape(count, 2, legs)
    seeds, coins = drawn[count - sampled :].swapaxes(0, 1)
    chosen = [way[coin % len(way)] for way, coin in zip(ways, coins.T, strict=True)]
    stops = np.stack([np.broadcast_to(here, (sampled, here.shape[1])), *chosen], axis=1)
    from ppsim.arms.planners import solve_legs

    vertices, sizes = solve_legs(arm, stops, seeds, planner, planner_range)
    row_size, time, position = _timed(vertices, sizes.reshape(sampled, legs), arm.joint_speed)
    static_time, static_position = np.zeros(1), here
    if committed is not None:
        row_size = np.concatenate([[len(committed.time)], row_size])
        time = np.concatenate([committed.time, time])
        position = np.concatenate([committed.position, position])
    return PlanSet(
        agent,
        np.append(row_size, 1),
        np.concatenate([time, static_time]),
        np.concatenate([position, static_position]),
        static=count,
        committed=None if committed is None else 0,
    )


def straight_plan(arm: Arm, agent: str, start: Any, goal: Any) -> PlanSet:
    """Return the one plan that goes straight to some joint angles, rad; for an arm that is sent home.

    Examples
    --------
    >>> arm = Arm(base=(0.0, 0.0))
    >>> straight_plan(arm, "robot", [0.0, 0.0], [0.5, 0.2]).duration
    array([2.])
    """
    stops = np.array([start, goal], np.float64)
    _check_stops(arm, agent, stops)
    row_size, time, position = _timed(stops, np.array([[2]]), arm.joint_speed)
    return PlanSet(agent, row_size, time, position)


def rest_of_plan(plans: PlanSet, plan: int, elapsed: float, position: Any) -> Rest | None:
    """Return what is left of a plan after some seconds of it, from where the arm is by now.

    Parameters
    ----------
    plans : PlanSet
        The set that the plan is in.
    plan : int
        Its number.
    elapsed : float
        How many seconds of it were executed, holds not counted.
    position : (joint,) float
        Joint angles now, rad: where the plan wants them but for the error of tracking.

    Returns
    -------
    Rest or None
        None if the plan has ended or does not move.

    Examples
    --------
    >>> plans = PlanSet("robot", [3], [0.0, 1.0, 2.0], [[0.0], [0.5], [0.0]])
    >>> rest = rest_of_plan(plans, 0, 0.5, [0.25])
    >>> rest.time.tolist(), rest.position.ravel().tolist()
    ([0.0, 0.5, 1.5], [0.25, 0.5, 0.0])
    """
    first = int(plans.starts[plan])
    time = plans.time[first : first + int(plans.row_size[plan])] - elapsed
    # legs end on samples: a rounding error less would make this plan dearer than a fresh one that takes as long
    sampled = np.round(time / STEP) * STEP
    time = np.where(np.abs(time - sampled) < 1e-9, sampled, time)
    # what is nearer than a millionth of a second is there already
    ahead = time > 1e-6
    if not ahead.any():
        return None
    here = np.asarray(position, np.float64)[None]
    left = plans.position[first : first + len(time)][ahead]
    return Rest(np.concatenate([[0.0], time[ahead]]), np.concatenate([here, left]))


def _check_stops(arm: Arm, agent: str, stops: Float[np.ndarray, "stop joint"]) -> None:
    if len(stops) < 2:
        raise SimulationError(f"plans of {agent!r} need at least one goal")
    beyond = ~arm.within_limits(stops)
    if beyond.any() or not np.isfinite(stops).all():
        raise SimulationError(
            f"plans of {agent!r}: start and goals must be within the joints' limits of +-{arm.limits} rad; got "
            f"{stops[beyond].tolist()}"
        )


def _timed(
    vertices: Float[np.ndarray, "vertex joint"], sizes: Int[np.ndarray, "plan leg"], speed: float
) -> tuple[Int[np.ndarray, " plan"], Float[np.ndarray, " waypoint"], Float[np.ndarray, "waypoint joint"]]:
    """Time the edges of paths that lie end to end, leg after leg and plan after plan.

    The first vertex of every leg but the first is the last of the leg before, and goes; so do vertices that
    repeat the one before, or are less than a nanosecond from it.
    """
    flat = sizes.ravel()
    leg = np.repeat(np.arange(len(flat)), flat)
    first = np.cumsum(flat) - flat
    column = np.arange(len(vertices)) - first[leg]
    edge = np.zeros((len(flat), flat.max()))
    edge[leg[1:], column[1:]] = np.abs(vertices[1:] - vertices[:-1]).max(axis=1) / speed
    edge[:, 0] = 0.0
    edge[edge < 1e-9] = 0.0
    so_far = np.cumsum(edge, axis=1)
    length = so_far[:, -1]
    steps = np.ceil(length / STEP - 1e-9)
    # a leg of no length takes no time
    share = so_far / np.where(length > 0.0, length, 1.0)[:, None]
    ends = np.cumsum(steps.reshape(sizes.shape), axis=1).ravel()
    time = ((ends - steps)[leg] + steps[leg] * share[leg, column]) * STEP
    kept = edge[leg, column] > 0.0
    kept[first[:: sizes.shape[1]]] = True
    row_size = np.bincount(leg[kept] // sizes.shape[1], minlength=len(sizes))
    return row_size, time[kept], vertices[kept]
