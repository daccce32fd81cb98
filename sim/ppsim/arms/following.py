"""One agent in a trial of two arms: what it decided, and how far it has come with it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from ppinfer.coordination import Decision, PlanSet, Policy
from ppsim.arms.plans import Rest, rest_of_plan
from ppsim.arms.world import STEP


@dataclass(eq=False)
class Follower:
    """One agent in a trial: its policy, what it remembers, and what it is doing."""

    agent: str
    policy: Policy
    memory: object = None
    #: what it is executing: where it is to be at every half step from the last replan on, and for how many steps
    #: it has been doing so
    course: Float[np.ndarray, "half joint"] = field(default_factory=lambda: np.empty((0, 2)))
    steps: int = 0
    #: the last plan that moves, and for how many steps it was followed
    plans: PlanSet | None = None
    plan: int = 0
    followed: int = 0
    moves: bool = False
    #: steps left of going home
    retreat: int = 0
    holding: bool = False
    #: the sample of its last replan; None before the first
    replanned: int | None = None

    def begin(self, plans: PlanSet, decision: Decision, half_steps: Float[np.ndarray, " half"]) -> None:
        """Start to do what was decided."""
        self.course, self.steps, self.memory = plans.positions(half_steps)[decision.plan], 0, decision.memory
        self.retreat = 0
        self.moves = decision.plan != plans.static
        if self.moves:
            self.plans, self.plan, self.followed = plans, decision.plan, 0

    def rest(self, position: Float[np.ndarray, " joint"]) -> Rest | None:
        """Return the rest of the unfinished plan; None if there is none."""
        return (
            None
            if self.plans is None
            else rest_of_plan(self.plans, self.plan, self.followed * STEP, position)
        )

    def next_poses(self) -> Float[np.ndarray, "2 joint"]:
        """Return where it wants to be half a step and a step from now."""
        return self.course[2 * self.steps + 1 : 2 * self.steps + 3]

    def go_home(self, home: PlanSet, steps: int) -> None:
        """Give up what it was doing and go home for so many steps."""
        self.course, self.steps, self.retreat = (
            home.positions(np.arange(2 * steps + 1) * (STEP / 2))[0],
            0,
            steps,
        )
        self.plans, self.moves = None, False

    def advance(self) -> None:
        """Count a step that was executed."""
        self.steps += 1
        if self.moves:
            self.followed += 1

    def count_down(self) -> bool:
        """Count a step of going home, held or not; return whether it was the last."""
        self.retreat = max(0, self.retreat - 1)
        return self.retreat == 0
