"""Safe control along candidate trajectories: the cheapest that is safe in the long term (Algorithm 3 with a check)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from ppinfer.safety.candidates import Candidates, candidate_trajectories
from ppinfer.safety.choosing import choose_safe_plan
from ppinfer.safety.control import SafeControl
from ppinfer.safety.motion import LinearAgent, Mover
from ppinfer.safety.obstacles import StaticObstacle
from ppinfer.safety.potential_field import check_pushable
from ppinfer.safety.uncertainty import Growth


@dataclass(frozen=True, eq=False)
class CandidateController:
    """Algorithm 3, and a look at the probability of what it proposes.

    1. Generate candidate trajectories past the others' modes and synthetic obstacles, and the pursuit without pushes.
    2. Price them: `state_weight` times the squared distance of the state from the target, plus `control_weight` times
       the squared control, over the horizon.
    3. Do the first control of the cheapest one that stays safe with probability 1 - eps (`choose_safe_plan`); the
       printed tube about the modes is no part of that, since it bounds no probability. Where there is none the
       candidate of the largest count, flagged.

    Parameters
    ----------
    robot : LinearAgent
        How it moves: one control for each dimension of its position.
    eps, confidence, distance, horizon, rollouts, static
        As of `SafeController`; the plan is looked at up to the horizon.
    obstacles, obstacle_radius, goal_clearance, strength, growth
        Of `candidate_trajectories`.
    method : {"fresh", "bonferroni"}
        Of `choose_safe_plan`.
    state_weight, control_weight : float
        The price.

    Raises
    ------
    SafetyError
        Where the robot cannot be pushed.

    Examples
    --------
    >>> walker = LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1), noise=0.0004 * np.eye(2))
    >>> human = Mover(walker, np.array([3.0, 0.0]), np.array([[-4.0, 0.0]]), np.array([1.0]))
    >>> controller = CandidateController(LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1)), strength=3.0)
    >>> did = controller.control(np.array([-3.0, 0.0]), np.array([4.0, 0.0]), [human], np.random.default_rng(0))
    >>> did.flagged, did.plan.shape
    (False, (21, 2))
    """

    robot: LinearAgent
    eps: float = 0.05
    confidence: float = 0.99
    distance: float = 1.0
    horizon: int = 20
    rollouts: int = 1000
    obstacles: int = 64
    obstacle_radius: float = 2.0
    goal_clearance: float = 1.0
    strength: float = 10.0
    growth: Growth = "sqrt"
    method: Literal["fresh", "bonferroni"] = "fresh"
    state_weight: float = 10.0
    control_weight: float = 1.0
    static: tuple[StaticObstacle, ...] = ()

    def __post_init__(self) -> None:
        check_pushable(self.robot)

    def candidates(
        self,
        state: Float[np.ndarray, " n"],
        target: Float[np.ndarray, " n"],
        others: Sequence[Mover],
        rng: np.random.Generator,
    ) -> Candidates:
        """Return the trajectories to choose from."""
        return candidate_trajectories(
            self.robot, state, target, others, obstacles=self.obstacles, radius=self.obstacle_radius,
            goal_clearance=self.goal_clearance, strength=self.strength, horizon=self.horizon, distance=self.distance,
            growth=self.growth, eps=self.eps, static=self.static, pursuit=True, rng=rng,
        )  # fmt: skip

    def costs(self, made: Candidates, target: Float[np.ndarray, " n"]) -> Float[np.ndarray, " candidate"]:
        """Return the price of every candidate."""
        off = made.states - target
        price: np.ndarray = self.state_weight * np.einsum("cti,cti->c", off, off)
        price += self.control_weight * np.einsum("cti,cti->c", made.controls, made.controls)
        return price

    def control(
        self,
        state: Float[np.ndarray, " n"],
        target: Float[np.ndarray, " n"],
        others: Sequence[Mover],
        rng: np.random.Generator,
    ) -> SafeControl:
        """Return the control now, with the plan that it begins and that plan's certificate.

        Raises
        ------
        SafetyError
            Where shapes or spaces do not fit.
        """
        made = self.candidates(state, target, others, rng)
        plans = made.positions
        choice = choose_safe_plan(
            plans, self.costs(made, target), others, method=self.method, eps=self.eps, confidence=self.confidence,
            distance=self.distance, rollouts=self.rollouts, static=self.static, robot=self.robot, rng=rng,
        )  # fmt: skip
        return SafeControl(
            made.controls[choice.plan, 0], plans[choice.plan], choice.certificate, None, choice.flagged
        )
