"""Games of the reaching world a second, and a step of Algorithm 1 next to Algorithm 1 as printed, in one process.

Run with ``python benchmarks/reaching.py`` (``--quick`` for a glance, ``--json`` for one JSON object). One process on
one core. Games have three goals and last 30 s: 300 steps, at each of which the human infers the robot's goal and the
robot infers the human's, models the human's mind and chooses; recording them is not in it. Steps of Algorithm 1 have
six goals; they are those of a game that is played first. Every row gives the least time of its repeats by the clock,
and of the processor, which stands when others use the machine as well.

The literal algorithm updates both beliefs (22)-(27), goal after goal; sums the reaction over all pairs of prior and
post goal, for each goal of the robot; and generates candidates for each of these, one obstacle, instant and mode after
another (`tests/goals/literal.py`, `tests/safety/literal.py`). Of the 65 candidates for a goal it is given a share,
since its time is linear in them. Its risk is the radius test of Algorithm 3; ours rolls the human out 1000 times
besides.
"""

from __future__ import annotations

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))

import argparse
import importlib.util
import json
import platform
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ppinfer.goals import BehaviourPredictor
from ppinfer.goals.choice import ExpectedCost, GoalSituation, JointChoice
from ppinfer.safety import Mover, uncertainty_growth
from ppinfer.safety.candidates import draw_obstacles
from ppsim.reaching import GameStudy, Movement

GOALS, OBSTACLES, HORIZON = 6, 64, 20
AIM_MS = 10.0


def literal_module(room: str) -> Any:
    """Load the literal algorithms of one room from the tests."""
    path = Path(__file__).parents[1] / "tests" / room / "literal.py"
    spec = importlib.util.spec_from_file_location(f"literal_{room}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def least(action: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Return the least seconds of some calls, by the clock and of the processor, after one that nobody counts."""
    action()
    clock, cpu = [], []
    for _ in range(repeats):
        begin, worked = time.perf_counter(), time.process_time()
        action()
        cpu.append(time.process_time() - worked)
        clock.append(time.perf_counter() - begin)
    return min(clock), min(cpu)


def play_all(study: GameStudy) -> None:
    """Play all games of a study."""
    for at in range(study.trials):
        study.trial(at)


def games(robots: tuple[str, ...], repeats: int) -> list[dict[str, Any]]:
    """Time a game of each robot with each human."""
    rows = []
    for robot in robots:
        study = GameStudy(robots=(robot,))
        clock, cpu = least(partial(play_all, study), repeats)
        rows.append(
            {
                "name": f"a game: {robot}",
                "least": clock / study.trials,
                "least_cpu": cpu / study.trials,
                "games_per_second": study.trials / cpu,
            }
        )
    return rows


class Step:
    """One step of a game with six goals: what was seen until then, and both ways to go on."""

    def __init__(self, seed: int) -> None:
        trial = GameStudy(goals=(GOALS,), robots=("expected-cost",), humans=("moving",), seed=seed).trial(0)
        self.position, self.velocity = trial.position[:10], np.asarray(trial.velocity)[:10]
        self.goals = np.asarray(trial.goal_position)[0]
        self.movement = Movement()
        self.chooser = JointChoice().with_generator(np.random.default_rng(seed))
        self.predictor = BehaviourPredictor(
            self.movement.model,
            self.movement.model,
            dt=self.movement.dt,
            labels=[str(goal) for goal in range(GOALS)],
        )
        self.predictor.restart(self.goals)
        for at in range(9):
            self.situation = self.observe(at)
        self.time = 9

    def observe(self, at: int, now: float | None = None) -> GoalSituation:
        """Let the robot see one sample."""
        seconds = 0.1 * (at if now is None else now)
        return self.predictor.observe(
            seconds,
            self.position[at, 0],
            self.velocity[at, 0],
            self.position[at, 1],
            self.velocity[at, 1],
            None,
        )

    def beliefs(self) -> GoalSituation:
        """Update both beliefs with one more sample (the same one again and again, later and later)."""
        self.time += 1
        self.situation = self.observe(9, self.time)
        return self.situation

    def whole(self) -> object:
        """Update the beliefs and choose a goal and a trajectory."""
        return self.chooser.choose(self.beliefs())


def literal_step(step: Step, candidates: int) -> tuple[Callable[[], None], Callable[[], None]]:
    """Return the beliefs and reactions of the literal step, and its candidates: a share of them."""
    goal_literal, safety_literal = literal_module("goals"), literal_module("safety")
    agent, chooser = step.movement.agent, step.chooser
    dynamics = agent.dynamics
    targets = dynamics.goal_states(step.goals)
    human, robot = step.situation.human, step.situation.robot
    even, control = np.full(GOALS, 1 / GOALS), np.zeros(2)
    matrices = (dynamics.A, dynamics.B, agent.Q, agent.R, agent.P)

    def beliefs() -> None:
        updated = []
        for seen in (human, robot):
            log_likelihood = [
                agent.rationality * goal_literal.literal_q(seen, control, target, *matrices)
                - goal_literal.literal_log_normaliser(seen, target, *matrices, agent.rationality)
                for target in targets
            ]
            weight = even * np.exp(np.array(log_likelihood) - max(log_likelihood))
            updated.append(weight / weight.sum())
        belief = updated[0]
        here = human[list(dynamics.position_index)]
        post = np.zeros((GOALS, GOALS))
        for own in range(GOALS):
            for prior in range(GOALS):
                weights = [
                    np.exp(
                        -0.5
                        * (
                            2 * np.linalg.norm(step.goals[goal] - here)
                            - 3 * np.linalg.norm(step.goals[goal] - step.goals[own])
                            + np.linalg.norm(step.goals[goal] - step.goals[prior])
                        )
                    )
                    for goal in range(GOALS)
                ]
                for goal in range(GOALS):
                    post[own, goal] += belief[prior] * weights[goal] / sum(weights)

    def grown(who: Any) -> np.ndarray:
        return 2.448 * uncertainty_growth(who, HORIZON)

    rng = np.random.default_rng(0)
    mover = Mover(chooser.human, human, targets, even)

    def generated() -> None:
        for target in targets:
            start, end = chooser.robot.position(robot), chooser.robot.position(target)
            obstacles = draw_obstacles(start, end, OBSTACLES, 2.0, 1.0, rng)[:candidates]
            safety_literal.traj_gen(
                chooser.robot, robot, target, [mover], obstacles, HORIZON, 1.0, grown, 10.0, 0.5
            )

    return beliefs, generated


def steps(repeats: int, literal_candidates: int) -> tuple[list[dict[str, Any]], float]:
    """Time one step of Algorithm 1, part by part, and the literal one; return how many times faster ours is."""
    step = Step(0)
    beliefs, generated = literal_step(step, literal_candidates)
    goal_choice = ExpectedCost()
    timed: list[tuple[str, Callable[[], object], int, float]] = [
        ("a step: beliefs", step.beliefs, repeats, 1.0),
        ("a step: choice of a goal", lambda: goal_choice.choose(step.situation), repeats, 1.0),
        ("a step: choice of goal and trajectory", lambda: step.chooser.choose(step.situation), repeats, 1.0),
        ("a step: whole Algorithm 1", step.whole, repeats, 1.0),
        ("literal: beliefs and reactions", beliefs, max(1, repeats // 10), 1.0),
        ("literal: candidates", generated, 1, (OBSTACLES + 1) / (literal_candidates + 1)),
    ]
    rows: list[dict[str, Any]] = []
    for name, action, times, share in timed:
        clock, cpu = least(action, times)
        rows.append({"name": name, "least": clock * share, "least_cpu": cpu * share})
    spent = {str(row["name"]): float(row["least_cpu"]) for row in rows}
    literal = spent["literal: beliefs and reactions"] + spent["literal: candidates"]
    return rows, literal / spent["a step: whole Algorithm 1"]


def main() -> None:
    """Print the table, or the JSON object."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="few repeats: a glance, not a measure")
    parser.add_argument("--json", action="store_true", help="one JSON object, in seconds")
    arguments = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    robots = ("expected-cost",) if arguments.quick else ("naive", "influence", "expected-cost", "joint")
    rows, ratio = steps(*((3, 1) if arguments.quick else (200, 7)))
    rows = games(robots, 1 if arguments.quick else 5) + rows
    if arguments.json:
        print(json.dumps({"python": platform.python_version(), "rows": rows, "times_literal": ratio}))
        return
    print(
        f"Python {platform.python_version()}, NumPy {np.__version__}, one core; load {os.getloadavg()[0]:.1f}"
    )
    print(f"{'':<40} {'ms':>9} {'ms cpu':>9} {'games/s':>9}")
    for row in rows:
        each = f"{row['games_per_second']:9.1f}" if "games_per_second" in row else ""
        print(f"{row['name']:<40} {1e3 * row['least']:>9.3f} {1e3 * row['least_cpu']:>9.3f} {each}")
    print(f"a step of Algorithm 1: {ratio:,.0f} times the literal one; aim: below {AIM_MS:g} ms")


if __name__ == "__main__":
    main()
