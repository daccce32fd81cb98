"""Algorithm 1's decision: a goal and a trajectory to it, chosen together."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from ppinfer.distributions import Distribution
from ppinfer.errors import ModelError
from ppinfer.goals.choice.chooser import GoalChooser, GoalDecision, GoalSituation
from ppinfer.goals.choice.distances import change_costs, human_distances, robot_distances
from ppinfer.goals.conditional import GoalConditional
from ppinfer.goals.dynamics import Dynamics
from ppinfer.goals.model import LARGEST, require_range
from ppinfer.goals.noisily_rational import NoisilyRational
from ppinfer.goals.reacted import ReactedConditional
from ppinfer.safety import (
    Candidates,
    LinearAgent,
    Mover,
    SafeProbability,
    candidate_trajectories,
    nominal_motion,
    plan_safe_probability,
)

#: Variance that a second of disturbance adds to each velocity (m^2/s^2): METHODS of Algorithm 2.
VELOCITY_VARIANCE = 0.7


def point_agent(
    dt: float = 0.1,
    *,
    state_weight: float = 10.0,
    control_weight: float = 1.0,
    velocity_variance: float = 0.0,
) -> LinearAgent:
    """Return a double integrator in the plane under LQR control, as safety wants it.

    Parameters
    ----------
    dt : float
        Seconds a step.
    state_weight, control_weight : float
        Q = state_weight I and R = control_weight I; the defaults are the study's.
    velocity_variance : float
        Variance that a second of disturbance adds to each velocity (m^2/s^2).

    Examples
    --------
    >>> point_agent().gain.shape
    (2, 4)
    """
    dynamics = Dynamics.double_integrator(dt)
    agent = NoisilyRational.lqr(dynamics, state_weight=state_weight, control_weight=control_weight)
    noise = np.zeros((dynamics.states, dynamics.states))
    noise[dynamics.velocity_index, dynamics.velocity_index] = velocity_variance * dt
    return LinearAgent(dynamics.A, dynamics.B, agent.K, dynamics.position_index, noise=noise)


@dataclass(frozen=True, eq=False)
class TrajectoryDecision(GoalDecision):
    """A goal, the trajectory to it that was chosen with it, and how safe that is.

    Parameters
    ----------
    goal, score, post
        As in `GoalDecision`; the score of a goal is J of its best trajectory, or where that was not needed, a bound
        from below.
    candidates : Candidates
        The trajectories to that goal.
    chosen : int
        Which of them.
    safe_probability : SafeProbability
        How many rollouts of the human it stayed clear of.
    among : int
        How many pairs of goal and trajectory there were to choose from: what its confidence has to be shared among.
    flagged : bool
        Whether safety could not be claimed for it.
    """

    candidates: Candidates
    chosen: int
    safe_probability: SafeProbability
    among: int
    flagged: bool

    @property
    def control(self) -> Float[np.ndarray, " m"]:
        """What to do now: the first control of the trajectory."""
        first: np.ndarray = self.candidates.controls[self.chosen, 0]
        return first


@dataclass(frozen=True, eq=False)
class JointChoice(GoalChooser):
    """The pair of a goal and a safe trajectory to it with the least cost J (Algorithm 1).

    1. For every goal r of the robot, candidate trajectories are generated that give way to the human's motion under
       b_post(. | r) (Algorithm 3), and the one that minds nobody: those that stay outside the human's discs, or where
       none does, all of them.
    2. J(trajectory, r) = sum_i b_post(i | r) [max(d_R(r) + lag, d_H(i)) + penalty [i = r]] +
       change_weight |theta_r - previous| + control_weight sum |u|^2 dt + violation_weight max(0, bound - eps),
       where lag is how many metres the trajectory is behind one that minds nobody, on average over the horizon, and
       bound the upper confidence bound on the probability that it comes nearer than `distance` to the human
       within the horizon. The bound holds for whichever pair is chosen (Bonferroni).
    3. The pair with the least J wins. Goals whose J without the last term is no better are not rolled out.

    A chooser of goals alone is the special case in which the trajectory minds nobody.

    Parameters
    ----------
    conditional : GoalConditional
        How the human reacts.
    robot, human : LinearAgent
        How the two move; the human's noise is what the rollouts are disturbed by.
    dt : float
        Seconds a step.
    penalty, change_weight : float
        As in `ExpectedCost`, in m and m per m.
    control_weight : float
        What an integral of |u|^2 of 1 m^2/s^3 costs (m).
    violation_weight : float
        What a probability of 1 beyond eps costs (m).
    eps, confidence : float
        The tolerated probability of a violation, and the confidence of the bound.
    distance : float
        d_min (m).
    obstacles, horizon, rollouts : int
        Synthetic obstacles, steps, and rollouts of the human, for each goal.
    seed : int
        Of a single decision; a robot that decides again and again gives it a generator (`with_generator`).

    Raises
    ------
    ModelError
        Where a weight is negative, or the states in a situation do not fit the agents.

    Examples
    --------
    >>> from ppinfer.testing import example_goal_situation
    >>> decision = JointChoice(obstacles=8, rollouts=400).choose(example_goal_situation())
    >>> decision.goal, decision.flagged, decision.control.shape
    (0, False, (2,))
    """

    name: ClassVar[str] = "joint"

    conditional: GoalConditional = field(default_factory=ReactedConditional)
    robot: LinearAgent = field(default_factory=point_agent)
    human: LinearAgent = field(default_factory=lambda: point_agent(velocity_variance=VELOCITY_VARIANCE))
    dt: float = 0.1
    penalty: float = 20.0
    change_weight: float = 0.1
    control_weight: float = 1e-3
    violation_weight: float = 1e3
    eps: float = 0.05
    confidence: float = 0.99
    distance: float = 1.0
    obstacles: int = 64
    horizon: int = 20
    rollouts: int = 1000
    seed: int = 0
    generator: np.random.Generator | None = None

    def __post_init__(self) -> None:
        for name in ("penalty", "change_weight", "control_weight", "violation_weight", "distance"):
            require_range(name, getattr(self, name), 0.0, LARGEST)
        for name in ("eps", "confidence"):
            require_range(name, getattr(self, name), 0.0, 1.0, open_low=True, open_high=True)

    def with_generator(self, rng: np.random.Generator) -> JointChoice:
        """Return the chooser that draws obstacles and rollouts of one decision after another from a generator."""
        return replace(self, generator=rng)

    def choose(self, situation: GoalSituation) -> TrajectoryDecision:
        """Return the best pair."""
        rng = np.random.default_rng(self.seed) if self.generator is None else self.generator
        if situation.human.shape != (len(self.human.A),) or situation.robot.shape != (len(self.robot.A),):
            raise ModelError(
                f"states of {situation.human.shape} and {situation.robot.shape} do not fit agents of "
                f"{len(self.human.A)} and {len(self.robot.A)} entries"
            )
        post = self.conditional.post(situation)
        routes = self._routes(situation, post, rng)
        among = sum(len(route.offered) for route in routes.values())
        lowest = np.array(
            [routes[goal].cost.min() if goal in routes else np.inf for goal in self._all(situation)]
        )
        score = lowest.copy()
        best: tuple[float, int, int, SafeProbability] | None = None
        for goal in np.argsort(lowest, kind="stable").tolist():
            if goal not in routes or (best is not None and best[0] <= lowest[goal]):
                break
            route = routes[goal]
            found = plan_safe_probability(
                route.candidates.positions[route.offered],
                [route.human],
                distance=self.distance,
                rollouts=self.rollouts,
                rng=rng,
            )
            bound = 1.0 - found.lower(self.confidence, among)
            cost = route.cost + self.violation_weight * np.maximum(bound - self.eps, 0.0)
            at = int(cost.argmin())
            score[goal] = cost[at]
            if best is None or cost[at] < best[0]:
                best = (float(cost[at]), goal, at, found[at])
        assert best is not None
        _, goal, at, safe = best
        return TrajectoryDecision(
            goal=goal,
            score=score,
            post=post,
            candidates=routes[goal].candidates,
            chosen=int(routes[goal].offered[at]),
            safe_probability=safe,
            among=among,
            flagged=not safe.is_safe(self.eps, self.confidence, among),
        )

    @staticmethod
    def _all(situation: GoalSituation) -> range:
        return range(len(situation.goals))

    def _routes(
        self, situation: GoalSituation, post: Distribution, rng: np.random.Generator
    ) -> dict[int, _Routes]:
        """Return, for every goal that is there, the trajectories to it and J without the risk."""
        present = situation.present
        probability = np.exp(post.log_values)
        there = np.arange(len(situation.goals)) if present is None else np.flatnonzero(present)
        human_targets = _states(self.human, situation.goals[there])
        robot_targets = _states(self.robot, situation.goals[there])
        starts = np.repeat(situation.robot[None], len(there), axis=0)
        heedless, _ = nominal_motion(self.robot, starts, robot_targets, self.horizon)
        way, human_way = robot_distances(situation), human_distances(situation)[there]
        change = change_costs(situation, self.change_weight)
        routes = {}
        for at, goal in enumerate(there.tolist()):
            share = probability[goal, there]
            human = Mover(self.human, situation.human, human_targets, share / share.sum())
            candidates = candidate_trajectories(
                self.robot,
                situation.robot,
                robot_targets[at],
                [human],
                obstacles=self.obstacles,
                horizon=self.horizon,
                distance=self.distance,
                eps=self.eps,
                # a push never vanishes: without this one the robot would stop short of its goal
                pursuit=True,
                rng=rng,
            )
            offered = np.flatnonzero(candidates.safe)
            if not len(offered):
                # discs about every likely mode claim less than rollouts can show
                offered = np.arange(len(candidates))
            target = situation.goals[goal]
            remaining = np.linalg.norm(candidates.positions[offered] - target, axis=-1).mean(axis=1)
            lag = remaining - np.linalg.norm(self.robot.position(heedless[at]) - target, axis=-1).mean()
            effort = (candidates.controls[offered] ** 2).sum(axis=(1, 2)) * self.dt
            cost = np.maximum((way[goal] + lag)[:, None], human_way) @ share
            cost += self.penalty * probability[goal, goal] + change[goal] + self.control_weight * effort
            routes[goal] = _Routes(candidates, offered, cost, human)
        return routes


@dataclass(frozen=True, eq=False)
class _Routes:
    """The trajectories to one goal that are offered, what each costs without its risk, and the human meanwhile."""

    candidates: Candidates
    offered: np.ndarray
    cost: Float[np.ndarray, " offered"]
    human: Mover


def _states(agent: LinearAgent, positions: Float[np.ndarray, "goal space"]) -> Float[np.ndarray, "goal n"]:
    states = np.zeros((len(positions), len(agent.A)))
    states[:, list(agent.position_index)] = positions
    return states
