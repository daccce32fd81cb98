"""Compiled scans over poses of two arms; imported only when arms are first held against each other."""

from __future__ import annotations

from math import cos, inf, sin, sqrt

import numba
import numpy as np
from jaxtyping import Float, Int

# an arm is its base, heading, two link lengths and radius in one row
_SLACK = 1e-9


@numba.njit(cache=True, nogil=True, inline="always")
def _point_to_segment(x: float, y: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Return the squared distance of a point from a segment."""
    dx, dy = bx - ax, by - ay
    length = dx * dx + dy * dy
    share = ((x - ax) * dx + (y - ay) * dy) / length if length > 0.0 else 0.0
    share = min(1.0, max(0.0, share))
    ex, ey = ax + share * dx - x, ay + share * dy - y
    return ex * ex + ey * ey


@numba.njit(cache=True, nogil=True)
def _segment_to_segment(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float
) -> float:
    """Return the squared distance between the segments a-b and c-d; 0 where they cross."""
    ux, uy, vx, vy = bx - ax, by - ay, dx - cx, dy - cy
    # on which side of each segment's line the other's ends are
    c_side = ux * (cy - ay) - uy * (cx - ax)
    d_side = ux * (dy - ay) - uy * (dx - ax)
    a_side = vx * (ay - cy) - vy * (ax - cx)
    b_side = vx * (by - cy) - vy * (bx - cx)
    if c_side * d_side < 0.0 and a_side * b_side < 0.0:
        return 0.0
    return min(
        min(_point_to_segment(ax, ay, cx, cy, dx, dy), _point_to_segment(bx, by, cx, cy, dx, dy)),
        min(_point_to_segment(cx, cy, ax, ay, bx, by), _point_to_segment(dx, dy, ax, ay, bx, by)),
    )


@numba.njit(cache=True, nogil=True)
def _apart(
    one_x: float,
    one_y: float,
    one: Float[np.ndarray, " 4"],
    two_x: float,
    two_y: float,
    two: Float[np.ndarray, " 4"],
) -> float:
    """Return the distance between the bones of two arms, each given by its base and its (elbow, end effector)."""
    least = _segment_to_segment(one[0], one[1], one[2], one[3], two[0], two[1], two[2], two[3])
    least = min(least, _segment_to_segment(one_x, one_y, one[0], one[1], two[0], two[1], two[2], two[3]))
    least = min(least, _segment_to_segment(one[0], one[1], one[2], one[3], two_x, two_y, two[0], two[1]))
    least = min(least, _segment_to_segment(one_x, one_y, one[0], one[1], two_x, two_y, two[0], two[1]))
    return sqrt(least)


@numba.njit(cache=True, nogil=True)
def _pose(arm: Float[np.ndarray, " 6"], shoulder: float, elbow: float, into: Float[np.ndarray, " 4"]) -> None:
    """Write where elbow and end effector are."""
    upper = arm[2] + shoulder
    into[0] = arm[0] + arm[3] * cos(upper)
    into[1] = arm[1] + arm[3] * sin(upper)
    into[2] = into[0] + arm[4] * cos(upper + elbow)
    into[3] = into[1] + arm[4] * sin(upper + elbow)


@numba.njit(cache=True, nogil=True)
def clearances(
    arms: Float[np.ndarray, "2 6"], one: Float[np.ndarray, "pose joint"], two: Float[np.ndarray, "pose joint"]
) -> Float[np.ndarray, " pose"]:
    """Return the distance between the capsules of two arms, pose by pose; negative where they overlap."""
    clear = np.empty(len(one))
    first, second = np.empty(4), np.empty(4)
    for pose in range(len(one)):
        _pose(arms[0], one[pose, 0], one[pose, 1], first)
        _pose(arms[1], two[pose, 0], two[pose, 1], second)
        bones = _apart(arms[0, 0], arms[0, 1], first, arms[1, 0], arms[1, 1], second)
        clear[pose] = bones - arms[0, 5] - arms[1, 5]
    return clear


@numba.njit(cache=True, nogil=True)
def _sampled(
    arm: Float[np.ndarray, " 6"],
    start: Int[np.ndarray, " plan"],
    row_size: Int[np.ndarray, " plan"],
    time: Float[np.ndarray, " waypoint"],
    position: Float[np.ndarray, "waypoint joint"],
    stride: float,
) -> tuple[Int[np.ndarray, " plan"], Float[np.ndarray, "plan step 4"], Float[np.ndarray, "plan step"]]:
    """Return every plan's poses every `stride` seconds: how many, (elbow, end effector), and the way gone so far.

    The way is a bound on how far any point of the arm can have moved since the plan began. Within an edge the joints
    turn at constant rates, so each pose is the one before, turned.
    """
    plans = len(start)
    steps = np.empty(plans, np.int64)
    most = 0
    for plan in range(plans):
        steps[plan] = int(np.floor(time[start[plan] + row_size[plan] - 1] / stride + _SLACK))
        most = max(most, steps[plan])
    poses = np.empty((plans, most + 1, 4))
    way = np.empty((plans, most + 1))
    reach = arm[3] + arm[4]
    for plan in range(plans):
        at = start[plan]
        last = at + row_size[plan] - 1
        _pose(arm, position[at, 0], position[at, 1], poses[plan, 0])
        way[plan, 0] = 0.0
        gone = 0.0
        step = 1
        while at < last and step <= steps[plan]:
            span = time[at + 1] - time[at]
            upper_rate = (position[at + 1, 0] - position[at, 0]) / span
            elbow_rate = (position[at + 1, 1] - position[at, 1]) / span
            speed = abs(upper_rate) * reach + abs(elbow_rate) * arm[4]
            until = time[at + 1] + _SLACK if at + 1 == last else time[at + 1]
            if step * stride <= until:
                since = step * stride - time[at]
                upper = arm[2] + position[at, 0] + upper_rate * since
                lower = upper + position[at, 1] + elbow_rate * since
                ux, uy, lx, ly = cos(upper), sin(upper), cos(lower), sin(lower)
                turn, both = upper_rate * stride, (upper_rate + elbow_rate) * stride
                uc, us, lc, ls = cos(turn), sin(turn), cos(both), sin(both)
                while step <= steps[plan] and step * stride <= until:
                    pose = poses[plan, step]
                    pose[0] = arm[0] + arm[3] * ux
                    pose[1] = arm[1] + arm[3] * uy
                    pose[2] = pose[0] + arm[4] * lx
                    pose[3] = pose[1] + arm[4] * ly
                    way[plan, step] = gone + speed * (step * stride - time[at])
                    ux, uy = ux * uc - uy * us, ux * us + uy * uc
                    lx, ly = lx * lc - ly * ls, lx * ls + ly * lc
                    step += 1
            gone += speed * span
            at += 1
    return steps, poses, way


@numba.njit(cache=True, nogil=True)
def contacts(
    arms: Float[np.ndarray, "2 6"],
    start_one: Int[np.ndarray, " one"],
    row_size_one: Int[np.ndarray, " one"],
    time_one: Float[np.ndarray, " waypoint_one"],
    position_one: Float[np.ndarray, "waypoint_one joint"],
    static_one: int,
    start_two: Int[np.ndarray, " two"],
    row_size_two: Int[np.ndarray, " two"],
    time_two: Float[np.ndarray, " waypoint_two"],
    position_two: Float[np.ndarray, "waypoint_two joint"],
    static_two: int,
    stride: float,
    clearance: float,
) -> Float[np.ndarray, "2 one two"]:
    """Return when each profile first comes to a collision, and when within the clearance; inf for never.

    No pose is looked at before the arms can have come near enough, given how far apart they were and how much way
    each plan makes.
    """
    steps_one, poses_one, way_one = _sampled(arms[0], start_one, row_size_one, time_one, position_one, stride)
    steps_two, poses_two, way_two = _sampled(arms[1], start_two, row_size_two, time_two, position_two, stride)
    touching = arms[0, 5] + arms[1, 5]
    first = np.full((2, len(start_one), len(start_two)), inf)
    for i in range(len(start_one)):
        for j in range(len(start_two)):
            i_stays, j_stays = i == static_one, j == static_two
            if i_stays and j_stays:
                continue
            end = steps_two[j] if i_stays else steps_one[i]
            if not j_stays:
                end = min(end, steps_two[j])
            contact = clearance > 0.0
            threshold = touching + clearance if contact else touching
            step = 1
            while step <= end:
                a, b = min(step, steps_one[i]), min(step, steps_two[j])
                apart = _apart(
                    arms[0, 0], arms[0, 1], poses_one[i, a], arms[1, 0], arms[1, 1], poses_two[j, b]
                )
                if contact and apart <= threshold:
                    first[1, i, j] = step * stride
                    contact, threshold = False, touching
                if not contact and apart <= threshold:
                    first[0, i, j] = step * stride
                    break
                # the way that both have to go before they can touch
                ahead = way_one[i, a] + way_two[j, b] + (apart - threshold) - _SLACK
                step += 1
                while (
                    step <= end
                    and way_one[i, min(step, steps_one[i])] + way_two[j, min(step, steps_two[j])] < ahead
                ):
                    step += 1
            if clearance <= 0.0:
                first[1, i, j] = first[0, i, j]
    return first
