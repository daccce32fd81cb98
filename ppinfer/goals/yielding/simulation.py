"""The generative twin: humans who yield and humans who do not, among goals that a robot wants too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ppinfer.errors import ModelError
from ppinfer.goals.belief import infer_goals
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.lqr import GoalLQR
from ppinfer.goals.model import GoalDesign
from ppinfer.goals.yielding.evidence import EncounterEvidence
from ppinfer.goals.yielding.model import Yielding


@dataclass(frozen=True, eq=False)
class Encounter:
    """What to simulate: humans and robots among goals, row by row.

    Parameters
    ----------
    human, robot : (row, space) float64
        Where each starts, at rest (m).
    goals : (row, goal, space) float64
        Positions of the goals (m).
    goal, robot_goal : (row,) int64
        The human's goal at first, and the robot's, which it keeps.
    theta : (row,) int64
        0 where the human favours the robot, 1 where it favours itself.
    encounter : (row,) int64
        Which human it is.
    samples : int
        Of each row.
    dt : float
        Seconds between samples.
    """

    human: Float[np.ndarray, "row space"]
    robot: Float[np.ndarray, "row space"]
    goals: Float[np.ndarray, "row goal space"]
    goal: Int[np.ndarray, " row"]
    robot_goal: Int[np.ndarray, " row"]
    theta: Int[np.ndarray, " row"]
    encounter: Int[np.ndarray, " row"]
    samples: int = 40
    dt: float = 0.1

    @classmethod
    def random(
        cls,
        rng: np.random.Generator,
        *,
        encounters: int,
        rows: int = 1,
        goals: int = 3,
        samples: int = 40,
        dt: float = 0.1,
        extent: float = 10.0,
    ) -> Encounter:
        """Draw `rows` sets of goals for each human, places from a box of half-width `extent` (m), all else evenly."""
        count = encounters * rows
        return cls(
            human=rng.uniform(-extent, extent, (count, 2)),
            robot=rng.uniform(-extent, extent, (count, 2)),
            goals=rng.uniform(-extent, extent, (count, goals, 2)),
            goal=rng.integers(goals, size=count),
            robot_goal=rng.integers(goals, size=count),
            theta=np.repeat(rng.integers(2, size=encounters), rows),
            encounter=np.repeat(np.arange(encounters), rows),
            samples=samples,
            dt=dt,
        )


def simulate_encounters(
    model: Yielding, encounter: Encounter, rng: np.random.Generator
) -> tuple[EncounterEvidence, Int[np.ndarray, " sample"]]:
    """Return the motion of both agents drawn from the model, and the goal that the human was after at each sample.

    Raises
    ------
    ModelError
        Where the human's motion is no `GoalLQR`: nothing else here acts from any state towards a goal that changes.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> evidence, pursued = simulate_encounters(Yielding(), Encounter.random(rng, encounters=3, samples=20), rng)
    >>> evidence.human.rows, pursued.shape
    (3, (60,))
    """
    motion = model.motion
    if not isinstance(motion, GoalLQR):
        raise ModelError(f"humans are simulated as noisily rational LQR agents; got {type(motion).__name__}")
    rows, samples = len(encounter.goals), encounter.samples
    design = GoalDesign(
        encounter.robot, encounter.goals, encounter.robot_goal, np.full(rows, samples), encounter.dt
    )
    robot = model.robot_motion.simulate(design, rng)
    mental = np.exp(infer_goals(model.robot_motion, robot).log_posterior).reshape(rows, samples, -1)
    robot_position = robot.position.reshape(rows, samples, -1)
    agent = motion.agent_at(encounter.dt, encounter.human.shape[1])
    dynamics = agent.dynamics
    targets = dynamics.goal_states(encounter.goals)
    state = dynamics.goal_states(encounter.human)
    states = np.empty((rows, samples, dynamics.states))
    controls = np.empty((rows, samples, dynamics.controls))
    pursued = np.empty((rows, samples), dtype=np.int64)
    goal, each = encounter.goal, np.arange(rows)
    for t in range(samples):
        position = state[:, list(dynamics.position_index)]
        if t:
            moves = model.log_transitions(encounter.goals, position, robot_position[:, t], mental[:, t - 1])
            chances = np.exp(moves[each, encounter.theta, goal]).cumsum(axis=1)
            goal = (rng.random((rows, 1)) >= chances[:, :-1]).sum(axis=1)
        control = agent.sample_control(state, targets[each, goal], rng)
        states[:, t], controls[:, t], pursued[:, t] = state, control, goal
        state = dynamics.step(state, control)
    velocity = states[..., list(dynamics.velocity_index)] if dynamics.velocity_index else None
    human = GoalEvidence(
        time=design.time,
        position=states[..., list(dynamics.position_index)].reshape(rows * samples, -1),
        goals=encounter.goals,
        row_size=design.row_size,
        goal_labels=design.labels,
        velocity=None if velocity is None else velocity.reshape(rows * samples, -1),
        control=controls.reshape(rows * samples, -1),
        control_order=dynamics.order,
        time_step=encounter.dt,
    )
    return EncounterEvidence(human, robot, encounter.encounter), pursued.reshape(-1)
