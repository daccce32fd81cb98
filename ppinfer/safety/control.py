"""Safe control: on to the goal while that is safe, towards a safe state where it is not (Algorithm 2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from ppinfer.errors import SafetyError
from ppinfer.safety.long_term import long_term_safe_probability, plan_safe_probability
from ppinfer.safety.motion import LinearAgent, Mover
from ppinfer.safety.obstacles import StaticObstacle
from ppinfer.safety.potential_field import check_pushable, potential_field_control
from ppinfer.safety.probability import SafeProbability
from ppinfer.safety.rollouts import disturbance_root, nominal_motion
from ppinfer.safety.safe_state import SafeState, find_safe_state


@dataclass(frozen=True, eq=False)
class SafeControl:
    """What to do now, and what is known about its safety.

    Parameters
    ----------
    control : (m,) float64
        The control.
    plan : (instant, space) float64
        The positions that it begins, t = 0..H: what the certificate is about (m).
    certificate : SafeProbability
        Of that plan.
    safe_state : SafeState, optional
        Where it leads to, if going for the target is not safe; its own certificate is of a robot that is there already.
    flagged : bool
        True where 1 - eps cannot be claimed for the plan.
    """

    control: Float[np.ndarray, " m"]
    plan: Float[np.ndarray, "instant space"]
    certificate: SafeProbability
    safe_state: SafeState | None
    flagged: bool


@dataclass(frozen=True, eq=False)
class SafeController:
    """Algorithm 2: pursue the target while that is safe in the long term, else be drawn to a safe state.

    1. Estimate the probability that u = -K (x - target) from now on stays safe; if its lower bound reaches 1 - eps, do
       that.
    2. Else find a safe state near the robot, and add a control that draws there, -gamma / d^2 (x - x_safe), d clipped.
    3. The robot is not in that state, so the step itself is checked: it is followed by pursuing the target, or by
       pursuing the safe state and staying there. If neither is safe the pull is made stronger, by `stronger`. The first
       that is safe, with the correction for all that are looked at and for the look before, is done; otherwise the one
       with the largest count, flagged.

    Parameters
    ----------
    robot : LinearAgent
        How it moves: one control for each dimension of its position.
    eps, confidence : float
        What is claimed: a violation within the horizon has a probability of at most eps.
    distance : float
        d_min (m).
    horizon, rollouts : int
        H steps, and n.
    strength, clip : float
        gamma, and the distance below which a pull grows no more (m).
    stronger : tuple of float
        Factors on gamma, tried in this order.
    samples, radius, radius_step, radius_limit
        Of `find_safe_state`.
    static : tuple of StaticObstacle
        What stands still.

    Raises
    ------
    SafetyError
        Where the robot cannot be pushed, or a value is out of its range.

    Examples
    --------
    >>> walker = LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1), noise=0.0004 * np.eye(2))
    >>> human = Mover(walker, np.array([3.0, 0.0]), np.array([[-4.0, 0.0]]), np.array([1.0]))
    >>> controller = SafeController(LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1)))
    >>> rng = np.random.default_rng(0)
    >>> crossing = controller.control(np.array([-3.0, 0.0]), np.array([4.0, 0.0]), [human], rng)
    >>> crossing.safe_state is None, crossing.flagged
    (False, False)
    >>> leaving = controller.control(np.array([-3.0, 0.0]), np.array([-3.0, 4.0]), [human], rng)
    >>> leaving.safe_state is None, leaving.control
    (True, array([0., 4.]))
    """

    robot: LinearAgent
    eps: float = 0.05
    confidence: float = 0.99
    distance: float = 1.0
    horizon: int = 50
    rollouts: int = 1000
    strength: float = 50.0
    clip: float = 0.5
    stronger: tuple[float, ...] = (1.0, 2.0, 4.0)
    samples: int = 64
    radius: float = 1.0
    radius_step: float = 1.0
    radius_limit: float = 4.0
    static: tuple[StaticObstacle, ...] = ()

    def __post_init__(self) -> None:
        check_pushable(self.robot)
        if not self.stronger or not all(factor > 0 for factor in self.stronger) or not self.strength > 0:
            raise SafetyError(
                f"strength and the factors on it must be positive; got {self.strength!r} and {self.stronger!r}"
            )
        if self.robot.control_limit is not None and disturbance_root(self.robot).size:
            raise SafetyError(
                "the step towards a safe state cannot be checked for a robot with noise and a control limit: leave out "
                "the limit"
            )

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
        common: dict[str, Any] = {"distance": self.distance, "rollouts": self.rollouts, "static": self.static}
        certificate = long_term_safe_probability(
            self.robot, state, target, others, horizon=self.horizon, rng=rng, **common
        )
        states, controls = nominal_motion(self.robot, state[None], target[None], self.horizon)
        # two looks share what is left of the confidence: this one, and that at the steps
        if certificate.is_safe(self.eps, self.confidence, among=2):
            return SafeControl(controls[0, 0], self.robot.position(states[0]), certificate, None, False)
        safe_state = find_safe_state(
            self.robot, state, target, others, horizon=self.horizon, eps=self.eps, confidence=self.confidence,
            samples=self.samples, radius=self.radius, radius_step=self.radius_step, radius_limit=self.radius_limit,
            rng=rng, **common,
        )  # fmt: skip
        pulls, plans = self._steps(state, target, safe_state.state)
        counts = plan_safe_probability(plans, others, robot=self.robot, rng=rng, **common)
        enough = counts.is_safe(self.eps, self.confidence, among=2 * len(plans))
        best = int(np.argmax(enough)) if enough.any() else int(np.argmax(counts.safe))
        return SafeControl(pulls[best], plans[best], counts[best], safe_state, not enough[best])

    def _steps(
        self,
        state: Float[np.ndarray, " n"],
        target: Float[np.ndarray, " n"],
        safe_state: Float[np.ndarray, " n"],
    ) -> tuple[Float[np.ndarray, "step m"], Float[np.ndarray, "step instant space"]]:
        """Return controls towards the safe state, each with both ways to go on, and the positions that follow."""
        robot = self.robot
        pull = potential_field_control(
            robot.position(state), robot.position(safe_state), strength=-self.strength, clip=self.clip
        )
        pursuing = -robot.gain @ (state - target)
        pulls = np.repeat([pursuing + factor * pull for factor in self.stronger], 2, axis=0)
        if robot.control_limit is not None:
            length = np.linalg.norm(pulls, axis=1, keepdims=True)
            pulls *= np.minimum(1.0, robot.control_limit / np.maximum(length, robot.control_limit))
        following = state @ robot.A.T + pulls @ robot.B.T
        targets = np.tile([target, safe_state], (len(self.stronger), 1))
        later = nominal_motion(robot, following, targets, self.horizon - 1)[0]
        now = np.repeat(robot.position(state)[None, None], len(pulls), axis=0)
        return pulls, np.concatenate([now, robot.position(later)], axis=1)
