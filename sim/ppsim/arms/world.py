"""The physical world of two arms: bodies, joints and motors, which follow what they are told as well as they can."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from ppsim.arms.bodies import ArmBody, Ghosts, ObjectBody, new_space
from ppsim.arms.geometry import ARMS
from ppsim.arms.scene import Scene
from ppsim.errors import SimulationError

#: A step of the world, s, and the steps of the physics within it.
STEP = 0.1
SUBSTEPS = 10
#: The motors' rates are corrected every so many steps of the physics, counted from the end.
CORRECTED_EVERY = 5
#: An arm grasps what is this near to its end effector, m.
GRASP_DISTANCE = 0.02


@dataclass(frozen=True, eq=False)
class ArmsObservation:
    """What one agent sees of the table: everything but what the others want.

    Parameters
    ----------
    agent : str
        Who sees it.
    time : float
        Seconds since the start.
    position, velocity : mapping from agent to (2,) float64
        Joint angles, rad, and their rates, rad/s, of everybody still there.
    objects : mapping from agent to (2,) float64
        Where each agent's object is, m.
    holding : frozenset of str
        Who has grasped its object.
    """

    agent: str
    time: float
    position: Mapping[str, Float[np.ndarray, " 2"]]
    velocity: Mapping[str, Float[np.ndarray, " 2"]]
    objects: Mapping[str, Float[np.ndarray, " 2"]]
    holding: frozenset[str]


@dataclass(frozen=True)
class Touched:
    """Arms came into contact; told once until they are apart again."""

    time: float
    agents: tuple[str, str]


class ArmsWorld:
    """Arms on a table that pick and place; it follows `ppsim.protocol.World`.

    1. Every link is a body with a capsule for its shape, held by pivot joints; a motor turns each joint.
    2. A step takes 0.1 s, in which each arm is told where to be at its end. The motors turn at the rate that brings it
       there in time (what the plan asks for, and what is missing at a gain of 10 /s or more), never faster than the
       joints may by more than a quarter. They take up new rates at once. The physics runs in steps of 0.01 s.
    3. Grasping joins the end effector and the object with a pivot. Objects touch nothing.

    What is logged is what the bodies do, not what they were told: with plans at the joints' speed the difference stays
    under 1e-5 rad, and the shapes are where the kinematic model has them to 1e-5 m. The world keeps no safety stop of
    its own: whoever plays asks `would_collide` and holds. Two worlds told the same do the same.

    Parameters
    ----------
    scene : Scene, optional
        What is on the table. Without one, `reset` draws one from its seed.

    Examples
    --------
    >>> world = ArmsWorld(Scene.random(np.random.default_rng(1)))
    >>> home = world.position("robot")
    >>> seen, events = world.step({"robot": home + [0.02, -0.01], "human": world.position("human")})
    >>> (world.position("robot") - home).round(3), events
    (array([ 0.02, -0.01]), ())
    """

    def __init__(self, scene: Scene | None = None) -> None:
        self._given = scene
        self._agents = tuple(scene.agents if scene is not None else ARMS)
        self._arms: dict[str, ArmBody] = {}
        if scene is not None:
            self._begin(scene)

    @property
    def agents(self) -> tuple[str, ...]:
        """Names of the agents, in the order of the log."""
        return self._agents

    @property
    def active(self) -> tuple[str, ...]:
        """Names of the agents whose arms are still there."""
        return tuple(self._arms)

    @property
    def time(self) -> float:
        """Seconds since the start."""
        return self._steps * STEP

    @property
    def contacts(self) -> int:
        """How often arms have come into contact since the start."""
        return self._touches.count

    @property
    def holding(self) -> frozenset[str]:
        """Names of the agents that have grasped their object."""
        return frozenset(agent for agent, thing in self._objects.items() if thing.held)

    def reset(self, seed: int) -> dict[str, ArmsObservation]:
        """Begin anew, with both arms at home; the seed draws the scene unless one was given."""
        self._begin(
            self._given
            if self._given is not None
            else Scene.random(np.random.default_rng(np.random.SeedSequence(seed)))
        )
        return self._observations()

    def step(self, actions: Mapping[str, Any]) -> tuple[dict[str, ArmsObservation], tuple[Touched, ...]]:
        """Move every arm that is there for one time step.

        Parameters
        ----------
        actions : mapping from agent to (2,) float
            Joint angles to be at in 0.1 s, rad.

        Raises
        ------
        SimulationError
            Where the world was not reset, or an arm's joint angles are missing, unknown or not two finite numbers.
        """
        self._check_ready()
        if set(actions) != set(self._arms):
            raise SimulationError(
                f"expected joint angles for {', '.join(self._arms) or 'nobody'}; got them for "
                f"{', '.join(actions) or 'nobody'}"
            )
        told = {agent: self._checked(agent, joints) for agent, joints in actions.items()}
        return self._advance(told)

    def hold(self) -> tuple[dict[str, ArmsObservation], tuple[Touched, ...]]:
        """Stop all arms where they were last told to be, for one time step."""
        self._check_ready()
        return self._advance({agent: arm.told for agent, arm in self._arms.items()})

    def position(self, agent: str) -> Float[np.ndarray, " 2"]:
        """Return an arm's joint angles, rad."""
        return np.array(self._arm(agent).joints())

    def velocity(self, agent: str) -> Float[np.ndarray, " 2"]:
        """Return the rates of an arm's joints, rad/s."""
        return np.array(self._arm(agent).rates())

    def end_effector(self, agent: str) -> Float[np.ndarray, " 2"]:
        """Return where an arm's end effector is, m."""
        return np.array(self._arm(agent).tip())

    def object_position(self, agent: str) -> Float[np.ndarray, " 2"]:
        """Return where an agent's object is, m."""
        self._check_ready()
        if agent not in self._objects:
            raise SimulationError(f"there is no agent {agent!r}; there are {', '.join(self._agents)}")
        return np.array(self._objects[agent].position())

    def clearance(self) -> float:
        """Return how far apart the arms' capsules are, m, by queries of the shapes; inf where one arm is left.

        Where they overlap it is some number below 0.
        """
        self._check_ready()
        arms = list(self._arms.values())
        return min(
            (one.clearance(two) for i, one in enumerate(arms) for two in arms[i + 1 :]), default=float("inf")
        )

    def would_collide(self, poses: Mapping[str, Any]) -> bool:
        """Return whether the arms' shapes would touch in some poses; who is not named stays where it is.

        Closer than 0.04 mm counts as touching: so near, what bodies are off their pivots could make it true.

        Parameters
        ----------
        poses : mapping from agent to (2,) float
            Joint angles, rad.
        """
        self._check_ready()
        if len(self._arms) < 2:
            return False
        return self._ghosts.overlap(
            {agent: poses[agent] if agent in poses else arm.joints() for agent, arm in self._arms.items()}
        )

    def grasp(self, agent: str) -> None:
        """Join an arm's end effector to its object.

        Raises
        ------
        SimulationError
            If the object is out of grasp, or held already.
        """
        arm, thing = self._arm(agent), self._objects[agent]
        apart = float(np.hypot(*np.subtract(arm.tip(), thing.position())))
        if thing.held or apart > GRASP_DISTANCE:
            raise SimulationError(
                f"{agent} cannot grasp: its object is "
                + (
                    "held already"
                    if thing.held
                    else f"{apart:.3f} m away; it must be within {GRASP_DISTANCE} m"
                )
            )
        thing.attach(arm)

    def release(self, agent: str) -> None:
        """Let go of an agent's object, which stays where it is."""
        self._arm(agent)
        self._objects[agent].detach()

    def remove(self, agent: str) -> None:
        """Take an arm that has finished off the table; its object stays where it is."""
        self.release(agent)
        self._arms.pop(agent).remove()

    def _begin(self, scene: Scene) -> None:
        self.scene = scene
        self._agents = scene.agents
        self._space, self._touches = new_space()
        self._arms = {
            agent: ArmBody(self._space, scene.arms[agent], group)
            for group, agent in enumerate(scene.agents, start=1)
        }
        self._ghosts = Ghosts(scene.arms)
        self._objects = {
            agent: ObjectBody(self._space, scene.tasks[agent].pick.tolist()) for agent in scene.agents
        }
        self._steps = 0

    def _advance(
        self, told: Mapping[str, tuple[float, float]]
    ) -> tuple[dict[str, ArmsObservation], tuple[Touched, ...]]:
        inner = STEP / SUBSTEPS
        before = self._touches.count
        for left in range(SUBSTEPS, 0, -1):
            if left % CORRECTED_EVERY == 0:
                for agent, arm in self._arms.items():
                    arm.drive(told[agent], left * inner, at_once=left == SUBSTEPS)
            self._space.step(inner)
        for agent, arm in self._arms.items():
            arm.told = told[agent]
        self._steps += 1
        names = tuple(self._arms)
        events = tuple(Touched(self.time, (names[0], names[1])) for _ in range(self._touches.count - before))
        return self._observations(), events

    def _observations(self) -> dict[str, ArmsObservation]:
        position = {agent: self.position(agent) for agent in self._arms}
        velocity = {agent: self.velocity(agent) for agent in self._arms}
        objects = {agent: np.array(thing.position()) for agent, thing in self._objects.items()}
        for shared in (*position.values(), *velocity.values(), *objects.values()):
            shared.setflags(write=False)
        holding = self.holding
        return {
            agent: ArmsObservation(agent, self.time, position, velocity, objects, holding)
            for agent in self._arms
        }

    def _check_ready(self) -> None:
        if not hasattr(self, "_space"):
            raise SimulationError("reset the world before using it, or make it with a scene")

    def _arm(self, agent: str) -> ArmBody:
        self._check_ready()
        try:
            return self._arms[agent]
        except KeyError:
            what = "has left the table" if agent in self._agents else "is not in this world"
            raise SimulationError(
                f"{agent!r} {what}; there are {', '.join(self._arms) or 'no arms'}"
            ) from None

    def _checked(self, agent: str, joints: Any) -> tuple[float, float]:
        array = np.asarray(joints, np.float64)
        if array.shape != (2,) or not np.isfinite(array).all():
            raise SimulationError(f"the joint angles of {agent!r} must be 2 finite numbers; got {joints!r}")
        shoulder, elbow = array.tolist()
        return shoulder, elbow
