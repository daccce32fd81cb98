"""How safe a robot is at a moment of an interaction: its candidate trajectories, and the risk all over the place."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float

from ppinfer.distributions import Axis, Distribution
from ppinfer.errors import LogError
from ppinfer.goals.choice.chooser import GoalSituation
from ppinfer.goals.choice.joint import VELOCITY_VARIANCE, point_agent
from ppinfer.safety import (
    Candidates,
    LinearAgent,
    Mover,
    PlanChoice,
    candidate_trajectories,
    choose_safe_plan,
    draw_rollouts,
    nominal_motion,
    plan_safe_probability,
)
from ppinfer.safety.candidates import draw_obstacles
from ppinfer.studies.interaction import Interaction

# of the candidates: synthetic obstacles, and where they lie (m)
_OBSTACLES, _RADIUS, _CLEARANCE = 64, 2.0, 1.0
# a trajectory that is no nearer to its goal costs nothing but this much effort (m per m^2/s^3)
_EFFORT = 1e-3


@dataclass(frozen=True, eq=False)
class RiskMap:
    """The probability of a violation for a robot that starts at rest in each of many places.

    Parameters
    ----------
    x, y : (column,), (row,) float64
        Where it starts (m).
    probability : (row, column) float64
        Share of the others' rollouts that came nearer than `distance` within `horizon` steps.
    target : (space,) float64
        Where it goes.
    others : tuple of Mover
        Who else moves.
    distance, horizon, rollouts
        What a violation is, how far ahead was looked, and how often.
    """

    x: Float[np.ndarray, " column"]
    y: Float[np.ndarray, " row"]
    probability: Float[np.ndarray, "row column"]
    target: Float[np.ndarray, " space"]
    others: tuple[Mover, ...]
    distance: float
    horizon: int
    rollouts: int


def risk_map(
    robot: LinearAgent,
    target: Float[np.ndarray, " 2"],
    others: tuple[Mover, ...],
    *,
    bounds: tuple[float, float, float, float],
    cells: int = 60,
    distance: float = 1.0,
    horizon: int = 20,
    rollouts: int = 1000,
    rng: np.random.Generator,
) -> RiskMap:
    """Return how likely a violation is from each cell of the workspace.

    All cells are candidates of one array program, against the same rollouts of the others.

    Parameters
    ----------
    robot : LinearAgent
        Who starts at rest in each cell, and goes for the target.
    target : (2,) float64
        Its goal (m).
    others : tuple of Mover
        Who avoids nobody.
    bounds : tuple of float
        Least and largest x, least and largest y (m).
    cells : int
        Along the longer side.
    distance, horizon, rollouts
        As in `plan_safe_probability`, in m and steps.

    Examples
    --------
    >>> agent = point_agent()
    >>> human = Mover(agent, np.zeros(4), np.array([[4.0, 0.0, 0.0, 0.0]]), np.array([1.0]))
    >>> found = risk_map(
    ...     agent, np.array([0.0, 4.0]), (human,), bounds=(-2.0, 6.0, -4.0, 4.0), cells=9, rollouts=10,
    ...     rng=np.random.default_rng(0),
    ... )
    >>> found.probability.shape, found.probability[4, 2], found.probability[0, 0]
    ((9, 9), np.float64(1.0), np.float64(0.0))
    """
    left, right, low, high = bounds
    step = max(right - left, high - low) / max(cells - 1, 1)
    x, y = (
        np.linspace(start, stop, max(2, round((stop - start) / step) + 1))
        for start, stop in ((left, right), (low, high))
    )
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    starts = _at_rest(robot, places)
    targets = np.repeat(_at_rest(robot, np.asarray(target, np.float64)[None]), len(starts), axis=0)
    states, _ = nominal_motion(robot, starts, targets, horizon)
    drawn = draw_rollouts(others, horizon, rollouts, rng)
    found = plan_safe_probability(robot.position(states), drawn, distance=distance, rng=rng)
    return RiskMap(
        x,
        y,
        1.0 - found.estimate.reshape(len(y), len(x)),
        np.asarray(target),
        others,
        distance,
        horizon,
        rollouts,
    )


def situation_at(interaction: Interaction, sample: int) -> GoalSituation:
    """Return what a robot that held these beliefs knew at a sample of an interaction, in the plane.

    Raises
    ------
    LogError
        Where either agent was not seen then, or the space is no plane.

    Examples
    --------
    >>> from ppinfer.studies import infer_log_conditional
    >>> from ppinfer.studies.interaction import read_interaction, stretches
    >>> from ppinfer.testing import example_interaction_log
    >>> log = example_interaction_log(trials=1)
    >>> one = read_interaction(log, infer_log_conditional(log), stretches(log, "human")[0])
    >>> situation_at(one, 12).previous
    1
    """
    position, velocity = interaction.position[sample], interaction.velocity[sample]
    if position.shape[1] != 2 or np.isnan(position).any():
        raise LogError(
            f"trial {interaction.trial_id!r}: at {interaction.time[sample]:g} s the two agents are not both seen in "
            "the plane"
        )
    places = interaction.places[sample]
    present = ~np.isnan(places).any(axis=1)
    axis = Axis("goal", interaction.goals)
    goal = int(interaction.partner_goal[sample])
    states = _at_rest(_usual_robot(), position)
    # [px, vx, py, vy]; a velocity across a dropout is not known
    states[:, [1, 3]] = np.nan_to_num(velocity)
    return GoalSituation(
        goals=np.where(present[:, None], places, 0.0),
        human=states[0],
        robot=states[1],
        human_position=position[0],
        robot_position=position[1],
        belief=_over(axis, interaction.belief[sample]),
        mental_model=_over(axis.rename("robot_goal"), interaction.mental_model[sample]),
        previous=goal if goal >= 0 and present[goal] else None,
        present=None if present.all() else present,
    )


def human_mover(
    situation: GoalSituation, post: Float[np.ndarray, " goal"], agent: LinearAgent | None = None
) -> Mover:
    """Return the human as somebody who moves towards each goal with a probability.

    Parameters
    ----------
    situation : GoalSituation
        Where they are.
    post : (goal,) float64
        b_post given a goal of the robot.
    agent : LinearAgent, optional
        How they move; default a double integrator under LQR control, disturbed.

    Examples
    --------
    >>> from ppinfer.testing import example_goal_situation
    >>> human_mover(example_goal_situation(), np.array([0.5, 0.25, 0.25])).modes
    3
    """
    moves = _usual_human() if agent is None else agent
    there = np.arange(len(post)) if situation.present is None else np.flatnonzero(situation.present)
    return Mover(
        moves, situation.human, _at_rest(moves, situation.goals[there]), post[there] / post[there].sum()
    )


@dataclass(frozen=True, eq=False)
class CandidatePaths:
    """The trajectories to a goal that a robot has to choose from (Algorithm 3), and the one that was chosen.

    Parameters
    ----------
    goal : int
        The robot's.
    place : (space,) float64
        Where it is (m).
    candidates : Candidates
        The trajectories; the first is that without a synthetic obstacle.
    obstacles : (obstacle, space) float64
        What spread them out (m).
    human : Mover
        Whom they give way to.
    choice : PlanChoice
        Which one, and how sure.
    distance, eps : float
        What a violation is (m), and which probability of it is tolerated.
    """

    goal: int
    place: Float[np.ndarray, " space"]
    candidates: Candidates
    obstacles: Float[np.ndarray, "obstacle space"]
    human: Mover
    choice: PlanChoice
    distance: float
    eps: float


def candidate_paths(
    situation: GoalSituation,
    goal: int,
    post: Float[np.ndarray, " goal"],
    *,
    robot: LinearAgent | None = None,
    human: LinearAgent | None = None,
    distance: float = 1.0,
    horizon: int = 20,
    rollouts: int = 1000,
    eps: float = 0.05,
    seed: int = 0,
) -> CandidatePaths:
    """Return the candidate trajectories to one goal, and the one that progresses most among the safe ones.

    1. Candidates give way to the human's motion under b_post (`candidate_trajectories`).
    2. Of those that stay outside its uncertainty (of all, where none does), the one that is nearest to the goal on
       average is taken whose probability of a violation is at most eps with 99 % confidence, on rollouts of its own
       (`choose_safe_plan`).
    3. Where there is none, the one that stayed clear of most rollouts is, and is flagged.

    Parameters
    ----------
    situation : GoalSituation
        Where everybody is.
    goal : int
        The robot's.
    post : (goal,) float64
        b_post given that goal.
    robot, human : LinearAgent, optional
        How they move; default double integrators under LQR control, the human disturbed.
    distance, horizon, rollouts, eps
        Of safety: in m, steps, how often, and which probability of a violation is tolerated.
    seed : int
        Of obstacles and rollouts.

    Examples
    --------
    >>> from ppinfer.testing import example_goal_situation
    >>> found = candidate_paths(example_goal_situation(), 0, np.array([0.1, 0.8, 0.1]), rollouts=400)
    >>> len(found.candidates), found.choice.flagged
    (65, False)
    """
    moves = _usual_robot() if robot is None else robot
    mover = human_mover(situation, post, human)
    place = situation.goals[goal]
    start = _at_rest(moves, place[None])[0]
    made = candidate_trajectories(
        moves,
        situation.robot,
        start,
        [mover],
        obstacles=_OBSTACLES,
        radius=_RADIUS,
        goal_clearance=_CLEARANCE,
        horizon=horizon,
        distance=distance,
        eps=eps,
        rng=np.random.default_rng(seed),
    )
    # the same generator draws the same obstacles again
    obstacles = draw_obstacles(
        situation.robot_position, place, _OBSTACLES, _RADIUS, _CLEARANCE, np.random.default_rng(seed)
    )
    costs = np.linalg.norm(made.positions - place, axis=-1).mean(axis=1)
    costs += _EFFORT * (made.controls**2).sum(axis=(1, 2))
    # where none keeps out of all that the human may do, rollouts say what that is worth
    choice = choose_safe_plan(
        made.positions,
        np.where(made.safe | ~made.safe.any(), costs, np.inf),
        [mover],
        eps=eps,
        distance=distance,
        rollouts=rollouts,
        rng=np.random.default_rng([seed, 1]),
    )
    return CandidatePaths(goal, place, made, obstacles, mover, choice, distance, eps)


@lru_cache(maxsize=1)
def _usual_robot() -> LinearAgent:
    return point_agent()


@lru_cache(maxsize=1)
def _usual_human() -> LinearAgent:
    return point_agent(velocity_variance=VELOCITY_VARIANCE)


def _at_rest(agent: LinearAgent, places: Float[np.ndarray, "place space"]) -> Float[np.ndarray, "place n"]:
    states = np.zeros((len(places), len(agent.A)))
    states[:, list(agent.position_index)] = places
    return states


def _over(axis: Axis, probability: Float[np.ndarray, " goal"]) -> Distribution:
    return Distribution.from_probabilities([axis], probability / probability.sum())
