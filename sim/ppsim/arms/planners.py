"""The planners of OMPL by name, each solve a function of its seed alone."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Int, UInt32

from ppsim.arms.geometry import Arm
from ppsim.errors import SimulationError

#: Planners by the name that OMPL gives them, with how often each may ask whether to go on before it must stop. Those
#: that seek any path stop at the first; those that seek a short one use up what they are given.
PLANNERS = {"RRT": 2000, "RRTConnect": 2000, "KPIECE1": 2000, "RRTstar": 200, "InformedRRTstar": 200}

_THREADS = "decides in a second thread when it is done, so that a seed does not fix its path"
# seen with OMPL 2.0.1 in a joint space without obstacles
_REFUSED = {
    "PRM": _THREADS,
    "PRMstar": _THREADS,
    "SORRTstar": "never returns where the straight line is the best path",
    "AORRTC": "gives back paths that do not lead from the start to the goal",
    "BITstar": "gives back paths that do not lead from the start to the goal",
}

_ATTEMPTS = 20
_LARGEST_SEED = 2**31 - 1
# OMPL's generator is global to the process
_LOCK = threading.Lock()


class _Problem(NamedTuple):
    """The objects of OMPL that are made once for every joint space, and what is called for every solve."""

    set_seed: Any
    condition: Any
    information: Any
    definition: Any
    start: Any
    goal: Any


class _Countdown:
    """Says stop when asked once too often."""

    def __init__(self, left: int) -> None:
        self.left = left

    def __call__(self) -> bool:
        self.left -= 1
        return self.left < 0


def solve_legs(
    arm: Arm,
    stops: Float[np.ndarray, "plan stop joint"],
    seeds: UInt32[np.ndarray, "plan leg"],
    planner: str = "RRT",
    planner_range: float | None = None,
) -> tuple[Float[np.ndarray, "vertex joint"], Int[np.ndarray, " path"]]:
    """Return the raw path of every plan from every stop to the next, end to end, and how many vertices each has.

    Parameters
    ----------
    arm : Arm
        Whose limits bound the joint space.
    stops : (plan, stop, joint) float64
        rad.
    seeds : (plan, leg) uint32
        One for every solve.
    planner : str
        One of `PLANNERS`.
    planner_range : float, optional
        Longest edge, rad; by default the planner's own choice.

    Raises
    ------
    SimulationError
        If the planner is unknown, or found no exact path.

    Examples
    --------
    >>> arm = Arm(base=(0.0, 0.0))
    >>> stops = np.array([[0.0, 0.0], [1.0, 2.0]])
    >>> vertices, sizes = solve_legs(arm, np.stack([stops, stops]), np.array([[7], [7]], np.uint32))
    >>> bool(sizes[0] == sizes[1] and np.array_equal(*np.split(vertices, 2)))
    True
    """
    make = _planner_class(planner)
    vertices: list[tuple[float, float]] = []
    sizes = []
    with _LOCK, _quiet():
        problem = _problem(arm.limits)
        for plan, along in zip(seeds.tolist(), stops.tolist(), strict=True):
            for seed, start, goal in zip(plan, along[:-1], along[1:], strict=True):
                path = _solve(problem, make, PLANNERS[planner], planner_range, start, goal, seed)
                vertices += path
                sizes.append(len(path))
    return np.array(vertices, np.float64).reshape(-1, stops.shape[2]), np.array(sizes, np.int64)


def _solve(
    problem: _Problem,
    make: Any,
    budget: int,
    longest: float | None,
    start: list[float],
    goal: list[float],
    seed: int,
) -> list[tuple[float, float]]:
    """Return the vertices of one path; where a planner finds none, the next seed is tried."""
    if start == goal:
        return [(goal[0], goal[1])]
    set_seed, condition, information, definition, here, there = problem
    here[0], here[1] = start
    there[0], there[1] = goal
    for attempt in range(_ATTEMPTS):
        # the seed goes in right before the planner is made, whose generators take theirs from it
        set_seed((seed + attempt) % _LARGEST_SEED + 1)
        solver = make(information)
        if longest is not None:
            solver.setRange(longest)
        definition.clearSolutionPaths()
        definition.setStartAndGoalStates(here, there)
        solver.setProblemDefinition(definition)
        solver.setup()
        solver.solve(condition(_Countdown(budget)))
        if definition.hasExactSolution():
            path = [(state[0], state[1]) for state in definition.getSolutionPath().getStates()]
            if path[0] == tuple(start) and path[-1] == tuple(goal):
                return path
    raise SimulationError(
        f"{solver.getName()} found no path from {start} to {goal} rad in {_ATTEMPTS} attempts of {budget} iterations; "
        "take a larger planner_range or another planner"
    )


@cache
def _problem(limits: tuple[float, float]) -> _Problem:
    from ompl.base import (
        AllValidStateValidityChecker,
        PlannerTerminationCondition,
        ProblemDefinition,
        RealVectorBounds,
        RealVectorStateSpace,
        SpaceInformation,
    )
    from ompl.util import RNG

    space = RealVectorStateSpace(len(limits))
    bounds = RealVectorBounds(len(limits))
    for joint, limit in enumerate(limits):
        bounds.setLow(joint, -limit)
        bounds.setHigh(joint, limit)
    space.setBounds(bounds)
    information = SpaceInformation(space)
    # nothing is in the way of one arm alone: no Python is called to check a state
    information.setStateValidityChecker(AllValidStateValidityChecker(information))
    information.setup()
    return _Problem(
        RNG.setSeed,
        PlannerTerminationCondition,
        information,
        ProblemDefinition(information),
        information.allocState(),
        information.allocState(),
    )


def check_planner(name: str) -> None:
    """Raise a SimulationError unless there is a planner of this name, and a seed fixes its path.

    Examples
    --------
    >>> check_planner("RRT")
    """
    if name not in PLANNERS:
        why = f"{name} {_REFUSED[name]}" if name in _REFUSED else f"there is no planner {name!r}"
        raise SimulationError(f"{why}; take one of {', '.join(PLANNERS)}")


def _planner_class(name: str) -> Any:
    check_planner(name)
    from ompl import geometric

    return getattr(geometric, name)


@contextmanager
def _quiet() -> Iterator[None]:
    """Turn OMPL's log off for a while: it remarks on every seed after the first."""
    from ompl.util import noOutputHandler, restorePreviousOutputHandler

    noOutputHandler()
    try:
        yield
    finally:
        restorePreviousOutputHandler()
