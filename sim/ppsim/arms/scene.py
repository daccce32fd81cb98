"""What each arm has to do: pick something up here and put it down there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from ppsim.arms.geometry import ARMS, Arm
from ppsim.errors import SimulationError

# METHODS' table: where objects are picked up and put down, m
_PICK_X = (-0.3, 0.3)
_PLACE_X = (0.1, 0.4)
_REACH = (0.3, 0.95)
_WIDTH = 0.5
_APART = 0.3
_DRAWS = 10_000


@dataclass(frozen=True, eq=False)
class Task:
    """What one arm has to do, as points on the table and as all the joint angles that reach them.

    Parameters
    ----------
    pick, place : (2,) float64
        Where its object is and where it goes, m.
    pick_joints, place_joints : (way, joint) float64
        The configurations in which the arm can pick it up and put it down, rad: one for either elbow that reaches.
    """

    pick: Float[np.ndarray, " 2"]
    place: Float[np.ndarray, " 2"]
    pick_joints: Float[np.ndarray, "way joint"]
    place_joints: Float[np.ndarray, "way joint"]

    def goals(self, *, holding: bool = False) -> tuple[Float[np.ndarray, "way joint"], ...]:
        """Return the joint angles that are still to be reached, in order: without the pick once it is done."""
        return (self.place_joints,) if holding else (self.pick_joints, self.place_joints)


@dataclass(frozen=True, eq=False)
class Scene:
    """The arms and what each has to do.

    Parameters
    ----------
    tasks : mapping from agent to Task
        In the order of the log.
    arms : mapping from agent to Arm
        Of the same agents.

    Raises
    ------
    SimulationError
        If the agents differ, or a task's joint angles are beyond the arm's limits or elsewhere than its points.

    Examples
    --------
    >>> scene = Scene.random(np.random.default_rng(1))
    >>> scene.agents
    ('robot', 'human')
    >>> task = scene.tasks["robot"]
    >>> bool(np.allclose(scene.arms["robot"].end_effector(task.pick_joints), task.pick, atol=1e-9))
    True
    """

    tasks: Mapping[str, Task]
    arms: Mapping[str, Arm] = field(default_factory=lambda: dict(ARMS))

    def __post_init__(self) -> None:
        for name in ("tasks", "arms"):
            object.__setattr__(self, name, dict(getattr(self, name)))
        if set(self.tasks) != set(self.arms):
            raise SimulationError(
                f"the scene has tasks for {', '.join(self.tasks)} and arms for {', '.join(self.arms)}"
            )
        for agent, task in self.tasks.items():
            arm = self.arms[agent]
            for what, point, joints in (
                ("pick", task.pick, task.pick_joints),
                ("place", task.place, task.place_joints),
            ):
                if (
                    not len(joints)
                    or not arm.within_limits(joints).all()
                    or not np.allclose(arm.end_effector(joints), point, atol=1e-6)
                ):
                    raise SimulationError(
                        f"{agent}'s {what} at {point} m is not where its joint angles {joints} rad put the end "
                        f"effector, or they are beyond its limits; Arm.configurations gives those that reach it"
                    )

    @property
    def agents(self) -> tuple[str, ...]:
        """Names of the agents, in the order of the log."""
        return tuple(self.tasks)

    @classmethod
    def random(cls, rng: np.random.Generator, arms: Mapping[str, Arm] | None = None) -> Scene:
        """Draw a scene: every arm picks up near the middle and puts down on the far side.

        In each arm's own view (x towards the other arm, the origin in the middle of the table) the pick has x in
        [-.3, .3] m and the place x in [.1, .4] m; both |y| <= .5 m, .3 to .95 m from the own base, and more than .3 m
        from each other. Nothing keeps the tasks of different arms apart: what they make of that is the study's
        question. At home the arms are well clear of each other.

        Parameters
        ----------
        rng : Generator
            All chance comes from it.
        arms : mapping from agent to Arm, optional
            By default the two of the study.

        Raises
        ------
        SimulationError
            If no such points are within reach of an arm.
        """
        chosen = dict(ARMS if arms is None else arms)
        return cls({agent: _draw_task(rng, agent, arm) for agent, arm in chosen.items()}, chosen)


def _draw_task(rng: np.random.Generator, agent: str, arm: Arm) -> Task:
    for _ in range(_DRAWS):
        pick = _to_table(arm, rng.uniform(*_PICK_X), rng.uniform(-_WIDTH, _WIDTH))
        place = _to_table(arm, rng.uniform(*_PLACE_X), rng.uniform(-_WIDTH, _WIDTH))
        reach = [float(np.linalg.norm(point - arm.base)) for point in (pick, place)]
        if np.linalg.norm(pick - place) <= _APART or min(reach) < _REACH[0] or max(reach) > _REACH[1]:
            continue
        ways = [arm.configurations(point) for point in (pick, place)]
        reached = [way[np.isfinite(way).all(axis=-1)] for way in ways]
        if all(len(way) for way in reached):
            return Task(pick, place, *reached)
    raise SimulationError(f"no pick and place within reach of {agent!r} in {_DRAWS} draws: {arm}")


def _to_table(arm: Arm, x: float, y: float) -> Float[np.ndarray, " 2"]:
    """Return where a point in an arm's own view is on the table."""
    ahead = np.array([np.cos(arm.heading), np.sin(arm.heading)])
    point: np.ndarray = x * ahead + y * np.array([-ahead[1], ahead[0]])
    return point
