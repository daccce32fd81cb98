"""Candidate trajectories past others, spread out by synthetic obstacles (Algorithm 3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.errors import SafetyError
from ppinfer.safety.motion import LinearAgent, Mover
from ppinfer.safety.obstacles import StaticObstacle, stack_obstacles
from ppinfer.safety.potential_field import check_pushable
from ppinfer.safety.rollouts import nominal_motion
from ppinfer.safety.uncertainty import Coverage, Growth, coverage_factor, uncertainty_growth


@dataclass(frozen=True, eq=False)
class Candidates:
    """Trajectories to choose from; the first is the one without a synthetic obstacle.

    Parameters
    ----------
    states : (candidate, instant, n) float64
        From now on, t = 0..H.
    controls : (candidate, step, m) float64
        What leads from each to the next.
    safe : (candidate,) bool
        Whether it stays outside the others' uncertainty, at every t = 0..H.
    smallest_distance : (candidate,) float64
        From the nominal motion of any mode, at t = 1..H (m): no control changes t = 0.
    position_index : tuple of int
        Entries of a state that are the position.

    Examples
    --------
    >>> states = np.zeros((2, 2, 1))
    >>> made = Candidates(states, np.zeros((2, 1, 1)), np.array([False, False]), np.array([0.3, 0.7]), (0,))
    >>> made.choose(np.array([1.0, 2.0]))
    (1, True)
    """

    states: Float[np.ndarray, "candidate instant n"]
    controls: Float[np.ndarray, "candidate step m"]
    safe: Bool[np.ndarray, " candidate"]
    smallest_distance: Float[np.ndarray, " candidate"]
    position_index: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.safe)

    @property
    def positions(self) -> Float[np.ndarray, "candidate instant space"]:
        """Where each is from now on: what `plan_safe_probability` takes."""
        return np.ascontiguousarray(self.states[..., list(self.position_index)])

    @property
    def fallback(self) -> int:
        """The candidate whose smallest distance is largest: what is left where none is safe."""
        return int(np.argmax(self.smallest_distance))

    def choose(self, costs: Float[np.ndarray, " candidate"]) -> tuple[int, bool]:
        """Return the cheapest safe candidate and False; the fallback and True (flagged as unsafe) where none is."""
        if not self.safe.any():
            return self.fallback, True
        return int(np.argmin(np.where(self.safe, costs, np.inf))), False


def candidate_trajectories(
    robot: LinearAgent,
    state: Float[np.ndarray, " n"],
    target: Float[np.ndarray, " n"],
    others: Sequence[Mover],
    *,
    obstacles: int = 64,
    radius: float = 2.0,
    goal_clearance: float = 1.0,
    strength: float = 10.0,
    clip: float = 0.5,
    sigma: float = 0.1,
    horizon: int = 20,
    distance: float = 1.0,
    min_probability: float = 0.05,
    growth: Growth = "sqrt",
    coverage: Coverage = "instant",
    eps: float = 0.05,
    static: Sequence[StaticObstacle] = (),
    pursuit: bool = False,
    rng: np.random.Generator,
) -> Candidates:
    """Generate trajectories to a target that give way to the others' likely motion (Algorithm 3).

    1. Synthetic obstacles are drawn evenly from a disc about the robot, none near its target; one candidate each, and
       one without.
    2. Every candidate pursues the target, u = -K (x - target), and is pushed away by its obstacle and, in proportion
       to its probability, by each mode of the others' nominal motion (29).
    3. A candidate is safe where it stays farther from every mode than distance + kappa sigma_t (28).

    Parameters
    ----------
    robot : LinearAgent
        Whose noise is left out here.
    state, target : (n,) float64
        Where it is, and the state it pursues.
    others : sequence of Mover
        The other agents; modes of at most `min_probability` are left out.
    obstacles : int
        M, synthetic ones; fewer where there is no room for as many.
    radius, goal_clearance : float
        Of the disc they are drawn from, and their least distance from the target (m).
    strength, clip : float
        gamma, and the distance below which a push grows no more (m).
    sigma, growth : float, {"sqrt", "closed-loop"}
        How the others' uncertainty grows; see `uncertainty_growth`.
    coverage, eps : {"sigma", "instant", "union"}, float
        What kappa covers; see `coverage_factor`. By default 1 - eps at each instant and mode by itself, kappa = 2.448
        in two dimensions.
    horizon : int
        H, steps.
    distance : float
        d_min (m).
    static : sequence of StaticObstacle
        What stands still: it pushes with the whole strength, and its own distance is required of it.
    pursuit : bool
        Whether to add, as the last candidate, the pursuit that nothing pushes. A push falls off as 1 / d only, so with
        somebody 10 m away all others come to rest some 0.4 m from the target.
    rng : numpy.random.Generator
        Where the obstacles come from.

    Raises
    ------
    SafetyError
        Where shapes, spaces or counts do not fit, or a push has no place among the robot's controls.

    Examples
    --------
    >>> walker = LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1))
    >>> human = Mover(walker, np.array([4.0, 0.1]), np.array([[-4.0, 0.1]]), np.array([1.0]))
    >>> made = candidate_trajectories(
    ...     walker, np.array([-4.0, 0.0]), np.array([4.0, 0.0]), [human], rng=np.random.default_rng(0)
    ... )
    >>> made.states.shape, bool(made.safe[0]), bool(made.safe.any())
    ((65, 21, 2), False, True)
    """
    # imported here: it compiles
    from ppinfer.safety.scans import repel_candidates

    check_pushable(robot)
    state, target = (np.ascontiguousarray(one, dtype=np.float64) for one in (state, target))
    if state.shape != (len(robot.A),) or target.shape != state.shape:
        raise SafetyError(
            f"state and target must have {len(robot.A)} entries; got {state.shape} and {target.shape}"
        )
    if obstacles < 0 or horizon < 1 or not clip > 0 or not radius > 0:
        raise SafetyError(
            f"obstacles must not be negative, horizon at least 1, clip and radius positive; got {obstacles!r}, "
            f"{horizon!r}, {clip!r} and {radius!r}"
        )
    position, goal = robot.position(state), robot.position(target)
    drawn = draw_obstacles(position, goal, obstacles, radius, goal_clearance, rng)
    modes, weight, required = _modes(
        others, horizon, distance, min_probability, growth, coverage, eps, sigma, len(position)
    )
    where, apart = stack_obstacles(static, len(position))
    if len(where):
        modes = np.concatenate([modes, np.repeat(where[:, None], horizon + 1, axis=1)])
        weight = np.concatenate([weight, np.ones(len(where))])
        required = np.concatenate([required, np.repeat(apart[:, None], horizon + 1, axis=1)])
    count = len(drawn) + 1 + int(pursuit)
    states = np.empty((count, horizon + 1, len(state)))
    controls = np.empty((count, horizon, robot.B.shape[1]))
    smallest, margin = np.empty(count), np.empty(count)
    limit = np.inf if robot.control_limit is None else float(robot.control_limit)
    index = np.array(robot.position_index, dtype=np.int64)
    repel_candidates(
        state, target, robot.A, robot.B, robot.gain, limit, index, drawn, modes, weight, required, float(strength),
        float(clip), states, controls, smallest, margin,
    )  # fmt: skip
    return Candidates(states, controls, margin > 0.0, smallest, robot.position_index)


def draw_obstacles(
    centre: Float[np.ndarray, " space"],
    goal: Float[np.ndarray, " space"],
    count: int,
    radius: float,
    clearance: float,
    rng: np.random.Generator,
) -> Float[np.ndarray, "obstacle space"]:
    """Draw points evenly from the ball about a centre, none nearer to the goal than the clearance.

    At most `count`: fewer where nearly all of the ball is too near to the goal.
    """
    space = len(centre)
    # twice as many first: rarely does a second lot have to be drawn
    found = np.empty((0, space))
    for _ in range(8):
        if len(found) >= count:
            break
        direction = rng.standard_normal((2 * count, space))
        length = radius * rng.random((2 * count, 1)) ** (1.0 / space)
        points = centre + length * direction / np.sqrt((direction * direction).sum(axis=1, keepdims=True))
        away = points - goal
        found = np.concatenate([found, points[(away * away).sum(axis=1) >= clearance * clearance]])
    return np.ascontiguousarray(found[:count])


def _modes(
    others: Sequence[Mover],
    horizon: int,
    distance: float,
    min_probability: float,
    growth: Growth,
    coverage: Coverage,
    eps: float,
    sigma: float,
    space: int,
) -> tuple[
    Float[np.ndarray, "mode instant space"], Float[np.ndarray, " mode"], Float[np.ndarray, "mode instant"]
]:
    """Return the nominal positions of all likely modes, their probability, and the distance required of each."""
    kappa = coverage_factor(coverage, eps=eps, horizon=horizon, space=space)
    modes, weight, required = [np.empty((0, horizon + 1, space))], [np.empty(0)], [np.empty((0, horizon + 1))]
    for other in others:
        likely = other.probability > min_probability
        targets = other.targets[likely]
        starts = np.repeat(other.state[None], len(targets), axis=0)
        positions = other.agent.position(nominal_motion(other.agent, starts, targets, horizon)[0])
        if positions.shape[2] != space:
            raise SafetyError(f"the robot moves in {space} dimensions, another agent in {positions.shape[2]}")
        tube = distance + kappa * uncertainty_growth(other.agent, horizon, growth=growth, sigma=sigma)
        modes.append(positions)
        weight.append(other.probability[likely])
        required.append(np.repeat(tube[None], len(targets), axis=0))
    return (
        np.ascontiguousarray(np.concatenate(modes)),
        np.concatenate(weight),
        np.ascontiguousarray(np.concatenate(required)),
    )
