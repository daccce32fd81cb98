"""Head-on crossing: two agents swap places, and one of them takes no notice of the other."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import numpy as np
from jaxtyping import Float

from ppinfer.goals import Dynamics
from ppinfer.goals.choice import point_agent
from ppinfer.safety import (
    CandidateController,
    LinearAgent,
    Mover,
    SafeControl,
    SafeController,
    SafeProbability,
    clopper_pearson_upper,
    nominal_motion,
    plan_safe_probability,
)
from ppsim.errors import SimulationError
from ppsim.seeds import streams, trial_seed
from ppsim.workers import in_order

_DT = 0.1
# what goes straight on has no certificate: no rollout was made
_UNKNOWN = SafeProbability(0, 1)


@dataclass(frozen=True)
class Crossing:
    """The experiment: a robot at (-5, 0) and a human at (5, 0), in m, who want to be where the other is.

    Both are double integrators under the LQR gain of Q = 10 I, R = I, with steps of 0.1 s. The human is greedy: it goes
    for its place, its velocity disturbed at every step, and avoids nobody. The robot knows where the human is heading
    and how it is disturbed, and nothing of what will disturb it.

    Parameters
    ----------
    noise : float
        Standard deviation of what disturbs the human's velocity, m/s a step and dimension.
    eps, confidence : float
        What the robot's controller is to keep to.
    distance : float
        Centres nearer than this are a violation (m).
    reached : float
        A place is reached within this distance (m).
    duration : float
        A run ends when both have reached their places, or after this time (s).

    Raises
    ------
    SimulationError
        Where a value is out of its range.

    Examples
    --------
    >>> Crossing(noise=0.1).human.modes
    1
    """

    noise: float
    eps: float = 0.05
    confidence: float = 0.99
    distance: float = 1.0
    reached: float = 0.5
    duration: float = 10.0

    def __post_init__(self) -> None:
        for name in ("noise", "distance", "reached", "duration"):
            value = getattr(self, name)
            # its square is a variance
            if not (math.isfinite(value * value) and value > 0) and not (name == "noise" and value == 0):
                raise SimulationError(f"{name} must be positive and finite, its square too; got {value!r}")
        for name in ("eps", "confidence"):
            if not 0.0 < getattr(self, name) < 1.0:
                raise SimulationError(f"{name} must lie in (0, 1); got {getattr(self, name)!r}")

    @cached_property
    def robot(self) -> LinearAgent:
        """How the robot moves."""
        return _agent(0.0)

    @cached_property
    def human(self) -> Mover:
        """The human at the start."""
        dynamics = Dynamics.double_integrator(_DT)
        start, target = dynamics.goal_states(np.array([[5.0, 0.0], [-5.0, 0.0]]))
        return Mover(_agent(self.noise), start, target[None], np.ones(1))


@lru_cache(maxsize=16)
def _agent(noise: float) -> LinearAgent:
    disturbance = np.diag([0.0, noise**2, 0.0, noise**2]) if noise else None
    return replace(point_agent(_DT), noise=disturbance)


Control = Callable[[np.ndarray, np.ndarray, Sequence[Mover], np.random.Generator], SafeControl]


def _none(crossing: Crossing) -> Control:
    def control(
        state: np.ndarray, target: np.ndarray, others: Sequence[Mover], rng: np.random.Generator
    ) -> SafeControl:
        states, controls = nominal_motion(crossing.robot, state[None], target[None], 1)
        return SafeControl(controls[0, 0], crossing.robot.position(states[0]), _UNKNOWN, None, True)

    return control


def _printed_choice(crossing: Crossing) -> Control:
    maker = CandidateController(crossing.robot, eps=crossing.eps, distance=crossing.distance)

    def control(
        state: np.ndarray, target: np.ndarray, others: Sequence[Mover], rng: np.random.Generator
    ) -> SafeControl:
        made = maker.candidates(state, target, others, rng)
        chosen, flagged = made.choose(maker.costs(made, target))
        return SafeControl(made.controls[chosen, 0], made.positions[chosen], _UNKNOWN, None, flagged)

    return control


def _safe_controller(crossing: Crossing, **settings: object) -> Control:
    return SafeController(
        crossing.robot,
        eps=crossing.eps,
        confidence=crossing.confidence,
        distance=crossing.distance,
        **settings,  # type: ignore[arg-type]
    ).control


def _candidate_controller(crossing: Crossing) -> Control:
    return CandidateController(
        crossing.robot, eps=crossing.eps, confidence=crossing.confidence, distance=crossing.distance
    ).control


CONTROLLERS: dict[str, Callable[[Crossing], Control]] = {
    "none": _none,
    "alg2": _safe_controller,
    "alg3": _candidate_controller,
    "alg2-weak": partial(_safe_controller, strength=10.0, stronger=(1.0,)),
    "alg3-tube": _printed_choice,
}


@dataclass(frozen=True)
class Crossed:
    """What came of one run.

    Parameters
    ----------
    violated : bool
        Whether the centres came nearer than the distance at any step.
    smallest_distance : float
        Between the centres (m).
    reached_s : float
        When the robot first was at its place (s); NaN where it never was.
    decisions, accepted : int
        Controls decided on, and those whose plan was accepted as safe.
    plan_violations : int
        How many of the accepted plans, carried out to the end, would have met a violation with one human drawn afresh
        for each.
    """

    violated: bool
    smallest_distance: float
    reached_s: float
    decisions: int
    accepted: int
    plan_violations: int


def cross(crossing: Crossing, controller: str, seed: int) -> Crossed:
    """Play one run: a function of the experiment, the controller and the seed alone.

    What disturbs the human is the same for all controllers, and for all noises but for its scale.

    Raises
    ------
    SimulationError
        Where nobody knows the controller.

    Examples
    --------
    >>> cross(Crossing(noise=0.1), "none", seed=0).violated
    True
    """
    if controller not in CONTROLLERS:
        raise SimulationError(f"unknown controller {controller!r}: expected any of {', '.join(CONTROLLERS)}")
    disturbing, deciding, looking = streams(seed, 3)
    steer, robot, human = CONTROLLERS[controller](crossing), crossing.robot, crossing.human
    target, state = human.state.copy(), human.targets[0].copy()
    target.setflags(write=False)
    steps = round(crossing.duration / _DT)
    root = human.agent.noise_root
    disturbance = disturbing.standard_normal((steps, len(root)))
    smallest = _apart(robot, state, human.state)
    reached_s, there = math.nan, False
    decisions = accepted = plan_violations = 0
    for step in range(steps):
        did = steer(state, target, [human], deciding)
        decisions += 1
        if not did.flagged:
            accepted += 1
            fresh = plan_safe_probability(
                did.plan[None], [human], distance=crossing.distance, rollouts=1, rng=looking
            )
            plan_violations += 1 - int(fresh.safe[0])
        state = robot.A @ state + robot.B @ did.control
        pursued = human.agent.closed_loop @ (human.state - human.targets[0]) + human.targets[0]
        human = Mover(human.agent, pursued + root @ disturbance[step], human.targets, human.probability)
        smallest = min(smallest, _apart(robot, state, human.state))
        there = there or _apart(robot, human.state, human.targets[0]) <= crossing.reached
        if math.isnan(reached_s) and _apart(robot, state, target) <= crossing.reached:
            reached_s = (step + 1) * _DT
        if there and not math.isnan(reached_s):
            break
    return Crossed(smallest < crossing.distance, smallest, reached_s, decisions, accepted, plan_violations)


def _apart(robot: LinearAgent, one: Float[np.ndarray, " n"], other: Float[np.ndarray, " n"]) -> float:
    return float(np.linalg.norm(robot.position(one - other)))


def cross_many(
    crossing: Crossing, controller: str, runs: int, *, seed: int, workers: int = 1
) -> Iterator[Crossed]:
    """Yield many runs, in order; run i depends on the seed and on i only, whoever of the workers played it.

    Raises
    ------
    SimulationError
        Where there are no runs or workers, the seed is negative, or nobody knows the controller.

    Examples
    --------
    >>> sum(run.violated for run in cross_many(Crossing(noise=0.5), "none", 5, seed=1))
    5
    """
    if runs < 1:
        raise SimulationError(f"runs must be at least 1; got {runs}")
    if seed < 0:
        raise SimulationError(f"seed must not be negative; got {seed}")
    yield from in_order(partial(_run, crossing, controller, seed), range(runs), workers=workers)


def _run(crossing: Crossing, controller: str, seed: int, index: int) -> Crossed:
    return cross(crossing, controller, trial_seed(seed, index))


def summarise(runs: Sequence[Crossed], eps: float) -> dict[str, float | int | bool]:
    """Return what many runs of one controller came to.

    Both rates are there: eps is about that per decision, of accepted plans if they were carried out to the end; that
    per episode is what planning anew at every step makes of it.

    Examples
    --------
    >>> runs = [Crossed(False, 1.2, 3.0, 30, 30, 1)] * 99 + [Crossed(True, 0.9, 3.5, 30, 28, 0)]
    >>> told = summarise(runs, eps=0.05)
    >>> told["violations"], round(told["violation_upper"], 3), told["keeps_eps"]
    (1, 0.047, True)
    """
    count = len(runs)
    violations = sum(run.violated for run in runs)
    times = np.array([run.reached_s for run in runs])
    reached = times[np.isfinite(times)]
    decisions, accepted = sum(run.decisions for run in runs), sum(run.accepted for run in runs)
    failed = sum(run.plan_violations for run in runs)
    upper = float(clopper_pearson_upper(violations, count))
    return {
        "violations": violations,
        "violation_rate": violations / count,
        "violation_upper": upper,
        "keeps_eps": upper <= eps,
        "reached_rate": len(reached) / count,
        "reached_s": float(reached.mean()) if len(reached) else math.nan,
        "reached_s_sem": float(reached.std(ddof=1) / math.sqrt(len(reached)))
        if len(reached) > 1
        else math.nan,
        "smallest_distance": float(np.mean([run.smallest_distance for run in runs])),
        "decisions": decisions,
        "accepted": accepted,
        "flagged": decisions - accepted,
        "plan_violations": failed,
        "plan_violation_rate": failed / accepted if accepted else math.nan,
    }
