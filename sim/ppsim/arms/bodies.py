"""What the arms' world is made of: links, motors and objects in pymunk, and ghosts of arms to try poses with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import cos, sin
from typing import TYPE_CHECKING, Any

from ppsim.arms.geometry import Arm

if TYPE_CHECKING:
    import pymunk
    from pymunk import Vec2d

_ARM, _OBJECT = 1, 2
# kg, and N m: the motors are strong enough to follow any plan, and not without end
_LINK_MASS, _OBJECT_MASS, _TORQUE = 1.0, 0.05, 50.0
_OBJECT_RADIUS = 0.03
# motors may turn this much faster than the joints' speed, to make up for what is missing
_HEADROOM = 1.25
# poses are tried with capsules this much thicker, m: several times what bodies are off their pivots
_SKIN = 2e-5

#: left, lower, right and upper edge, m
_Box = tuple[float, float, float, float]


@dataclass
class Touches:
    """How often arms have come into contact."""

    count: int = 0


def new_space() -> tuple[pymunk.Space, Touches]:
    """Return an empty table, seen from above, and the count of contacts between arms on it."""
    import pymunk

    space = pymunk.Space()
    space.gravity = (0.0, 0.0)
    space.iterations = 10
    # lengths are metres: what pymunk lets overlap by default is twice a link's radius
    space.collision_slop = 1e-4
    touches = Touches()

    def begin(arbiter: Any, space: Any, data: Any) -> None:
        touches.count += 1

    space.on_collision(_ARM, _ARM, begin=begin)
    return space, touches


class ArmBody:
    """An arm in a space: two links, the pivots that hold them, and a motor for each."""

    def __init__(self, space: pymunk.Space, arm: Arm, group: int) -> None:
        import pymunk

        self.arm = arm
        self.told = arm.home
        self._space = space
        anchor = space.static_body
        self._links = []
        self._shapes = []
        self._motors = []
        self._joints: list[Any] = []
        parent, joint_in_parent, (x, y), angle = anchor, arm.base, arm.base, arm.heading
        for length, turn in zip(arm.links, arm.home, strict=True):
            angle += turn
            ahead = (cos(angle), sin(angle))
            # about the middle of the link, where its mass is
            body = pymunk.Body(
                _LINK_MASS,
                pymunk.moment_for_segment(_LINK_MASS, (-length / 2, 0), (length / 2, 0), arm.radius),
            )
            body.position = (x + ahead[0] * length / 2, y + ahead[1] * length / 2)
            body.angle = angle
            shape = pymunk.Segment(body, (-length / 2, 0.0), (length / 2, 0.0), arm.radius)
            shape.filter = pymunk.ShapeFilter(group=group)
            shape.collision_type = _ARM
            pivot = pymunk.PivotJoint(parent, body, joint_in_parent, (-length / 2, 0.0))
            # against the table, as a belt drives an elbow: links then turn at just the rate that they are told
            motor = pymunk.SimpleMotor(anchor, body, 0.0)
            motor.max_force = _TORQUE
            # a link that has come off its pivot goes nearly all the way back within one step of the physics
            pivot.error_bias = 0.1**100
            for joint in (pivot, motor):
                joint.collide_bodies = False
            space.add(body, shape, pivot)
            self._links.append(body)
            self._shapes.append(shape)
            self._motors.append(motor)
            self._joints += [pivot, motor]
            parent, joint_in_parent = body, (length / 2, 0.0)
            x, y = x + ahead[0] * length, y + ahead[1] * length
        # what is added last is solved last, and holds to the last digit
        space.add(*self._motors)

    @property
    def hand(self) -> tuple[pymunk.Body, tuple[float, float]]:
        """The body whose end grasps, and where on it."""
        return self._links[-1], (self.arm.links[-1] / 2, 0.0)

    def joints(self) -> tuple[float, float]:
        """Return the joint angles, rad."""
        upper, lower = self._links
        return upper.angle - self.arm.heading, lower.angle - upper.angle

    def rates(self) -> tuple[float, float]:
        """Return the joints' rates, rad/s."""
        upper, lower = self._links
        return upper.angular_velocity, lower.angular_velocity - upper.angular_velocity

    def tip(self) -> tuple[float, float]:
        """Return where the end effector is, m."""
        body, at = self.hand
        x, y = body.local_to_world(at)
        return x, y

    def drive(self, end: Sequence[float], duration: float, *, at_once: bool) -> None:
        """Set the motors to be at some joint angles after a duration.

        Motors are much quicker than the physics' steps, which move bodies at the rates that they have before they turn
        to the motors. So `at_once` gives the links their new rates as well; otherwise they take them up a step late.
        """
        fastest = _HEADROOM * self.arm.joint_speed
        turning = along_x = along_y = 0.0
        rows = zip(self._links, self._motors, self.arm.links, self.joints(), end, strict=True)
        for body, motor, length, here, stop in rows:
            turning += min(fastest, max(-fastest, (stop - here) / duration))
            # a motor's rate is that of the first body against the second
            motor.rate = -turning
            if at_once:
                x, y = -turning * length * sin(body.angle), turning * length * cos(body.angle)
                body.velocity = (along_x + x / 2.0, along_y + y / 2.0)
                body.angular_velocity = turning
                along_x, along_y = along_x + x, along_y + y

    def clearance(self, other: ArmBody) -> float:
        """Return how far this arm's shapes are from another's, m; below 0 where they overlap."""
        return min(
            _between(one, self._ends(one), two, other._ends(two))
            for one in self._shapes
            for two in other._shapes
        )

    def _ends(self, shape: pymunk.Segment) -> tuple[Vec2d, Vec2d]:
        body = self._links[self._shapes.index(shape)]
        return body.local_to_world(shape.a), body.local_to_world(shape.b)

    def remove(self) -> None:
        """Take the arm out of its space."""
        self._space.remove(*self._joints, *self._shapes, *self._links)


def _between(
    one: pymunk.Segment, one_ends: tuple[Vec2d, Vec2d], two: pymunk.Segment, two_ends: tuple[Vec2d, Vec2d]
) -> float:
    (a, b), (c, d) = one_ends, two_ends
    if (b - a).cross(c - a) * (b - a).cross(d - a) < 0.0 and (d - c).cross(a - c) * (d - c).cross(
        b - c
    ) < 0.0:
        return -one.radius - two.radius
    # of two segments that do not cross, an end of one is nearest to the other
    return min(
        shape.point_query(end).distance - other.radius
        for shape, other, ends in ((one, two, two_ends), (two, one, one_ends))
        for end in ends
    )


class ObjectBody:
    """Something small on the table that touches nothing."""

    def __init__(self, space: pymunk.Space, position: Sequence[float]) -> None:
        import pymunk

        self._space = space
        self._body = pymunk.Body(_OBJECT_MASS, pymunk.moment_for_circle(_OBJECT_MASS, 0.0, _OBJECT_RADIUS))
        self._body.position = (position[0], position[1])
        shape = pymunk.Circle(self._body, _OBJECT_RADIUS)
        shape.filter = pymunk.ShapeFilter(categories=_OBJECT, mask=0)
        self._grip: pymunk.PivotJoint | None = None
        space.add(self._body, shape)

    @property
    def held(self) -> bool:
        """Whether it is joined to an arm."""
        return self._grip is not None

    def position(self) -> tuple[float, float]:
        """Return where it is, m."""
        x, y = self._body.position
        return x, y

    def attach(self, arm: ArmBody) -> None:
        """Join it to an arm's end effector."""
        import pymunk

        body, at = arm.hand
        self._grip = pymunk.PivotJoint(body, self._body, at, (0.0, 0.0))
        self._space.add(self._grip)

    def detach(self) -> None:
        """Let it lie where it is."""
        if self._grip is not None:
            self._space.remove(self._grip)
            self._grip = None
        self._body.velocity = (0.0, 0.0)
        self._body.angular_velocity = 0.0


class Ghosts:
    """The shapes of arms in a space of their own, where nothing moves by itself, to try poses with."""

    def __init__(self, arms: Mapping[str, Arm]) -> None:
        import pymunk

        self._space = pymunk.Space()
        self._arms = dict(arms)
        self._bodies: dict[str, list[pymunk.Body]] = {}
        self._shapes: dict[str, list[pymunk.Segment]] = {}
        for group, (agent, arm) in enumerate(arms.items(), start=1):
            bodies = [pymunk.Body(body_type=pymunk.Body.KINEMATIC) for _ in arm.links]
            self._shapes[agent] = [
                pymunk.Segment(body, (0.0, 0.0), (length, 0.0), arm.radius + _SKIN)
                for body, length in zip(bodies, arm.links, strict=True)
            ]
            for shape in self._shapes[agent]:
                shape.filter = pymunk.ShapeFilter(group=group)
            self._bodies[agent] = bodies
            self._space.add(*bodies, *self._shapes[agent])

    def overlap(self, poses: Mapping[str, Sequence[float]]) -> bool:
        """Return whether any two of some arms would overlap, each in its pose."""
        placed = {agent: self._placed(self._arms[agent], joints) for agent, joints in poses.items()}
        if not any(_boxes_meet(one[1], two[1]) for one, two in combinations(placed.values(), 2)):
            return False
        for agent, (links, _) in placed.items():
            for body, (position, angle) in zip(self._bodies[agent], links, strict=True):
                body.position, body.angle = position, angle
                self._space.reindex_shapes_for_body(body)
        return any(
            hit.shape in self._shapes[other]
            for one, other in combinations(poses, 2)
            for shape in self._shapes[one]
            for hit in self._space.shape_query(shape)
        )

    @staticmethod
    def _placed(arm: Arm, joints: Sequence[float]) -> tuple[list[tuple[tuple[float, float], float]], _Box]:
        """Return where each link begins and points, and a box around the whole arm."""
        (x, y), angle = arm.base, arm.heading
        links = []
        xs, ys = [x], [y]
        for length, turn in zip(arm.links, joints, strict=True):
            angle += turn
            links.append(((x, y), angle))
            x, y = x + length * cos(angle), y + length * sin(angle)
            xs.append(x)
            ys.append(y)
        return links, (min(xs) - arm.radius, min(ys) - arm.radius, max(xs) + arm.radius, max(ys) + arm.radius)


def _boxes_meet(one: _Box, two: _Box) -> bool:
    return one[0] <= two[2] and two[0] <= one[2] and one[1] <= two[3] and two[1] <= one[3]
