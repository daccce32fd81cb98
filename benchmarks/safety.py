"""Rollouts and candidate trajectories a second, next to the literal Algorithms 2 and 3 in the same process.

Run with ``python benchmarks/safety.py`` (``--quick`` for a glance, ``--json`` for one JSON object). One process on one
core. The scene is the head-on crossing: a robot and a human swap places, both double integrators; the human may be
heading for one of five goals. Every row gives the least time of its repeats by the clock, and of the processor, which
stands when others use the machine as well. The literal algorithms are those of `tests/safety/literal.py`, one rollout,
instant and mode after another; of n rollouts they are given a share, since their time is linear in n.
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
from pathlib import Path
from typing import Any

import numpy as np

from ppinfer.goals import Dynamics, NoisilyRational
from ppinfer.safety import (
    CandidateController,
    LinearAgent,
    Mover,
    SafeController,
    candidate_trajectories,
    draw_rollouts,
    long_term_safe_probability,
    plan_safe_probability,
    uncertainty_growth,
)
from ppinfer.safety.candidates import draw_obstacles

ROLLOUTS, HORIZON = 1000, 50
OBSTACLES, MODES = 64, 5
AIM_STEPS, AIM_RATIO = 2.5e7, 500


def literal_algorithms() -> Any:
    """Load the literal algorithms from the tests."""
    path = Path(__file__).parents[1] / "tests" / "safety" / "literal.py"
    spec = importlib.util.spec_from_file_location("literal", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def scene() -> tuple[LinearAgent, np.ndarray, np.ndarray, Mover]:
    """Return the robot, its state and target, and the human."""
    dynamics = Dynamics.double_integrator(0.1)
    gain = NoisilyRational.lqr(dynamics, state_weight=10.0).K
    noise = np.diag([0.0, 0.09, 0.0, 0.09])
    robot = LinearAgent(dynamics.A, dynamics.B, gain, dynamics.position_index)
    walker = LinearAgent(dynamics.A, dynamics.B, gain, dynamics.position_index, noise=noise)
    goals = dynamics.goal_states(np.array([[-5.0, 0.0], [-5.0, 4.0], [0.0, 6.0], [2.0, -6.0], [5.0, 5.0]]))
    start, target = dynamics.goal_states(np.array([[-5.0, -1.6], [5.0, -1.6]]))
    state = dynamics.goal_states(np.array([[5.0, 0.0]]))[0]
    return robot, start, target, Mover(walker, state, goals, np.array([0.3, 0.2, 0.2, 0.2, 0.1]))


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


def measure(repeats: int, literal_rollouts: int, literal_candidates: int) -> list[dict[str, Any]]:
    """Time all rows."""
    robot, start, target, human = scene()
    rng, literal = np.random.default_rng(0), literal_algorithms()
    # nobody comes near: early ends would flatter the literal algorithm, which stops at a violation
    far = 0.01
    shared = draw_rollouts([human], 20, ROLLOUTS, rng)
    made = candidate_trajectories(robot, start, target, [human], horizon=20, obstacles=399, rng=rng)
    plans = made.positions
    obstacles = draw_obstacles(robot.position(start), robot.position(target), OBSTACLES, 2.0, 1.0, rng)

    def grown(agent: LinearAgent) -> np.ndarray:
        return 2.448 * uncertainty_growth(agent, HORIZON)

    safe_control, candidate_control = SafeController(robot), CandidateController(robot)
    head_on = start * [1.0, 1.0, 0.0, 1.0]
    rows: list[tuple[str, float, Callable[[], object], int]] = [
        (
            "long-term safe probability: literal",
            literal_rollouts * HORIZON,
            lambda: literal.draw_and_roll(robot, start, target, [human], far, HORIZON, literal_rollouts, rng),
            1,
        ),
        (
            "long-term safe probability: ours",
            ROLLOUTS * HORIZON,
            lambda: long_term_safe_probability(
                robot, start, target, [human], distance=far, horizon=HORIZON, rollouts=ROLLOUTS, rng=rng
            ),
            repeats,
        ),
        (
            "of it, normal numbers by NumPy",
            ROLLOUTS * HORIZON,
            lambda: rng.standard_normal((HORIZON, 2, ROLLOUTS)),
            repeats,
        ),
        (
            "candidates: literal",
            (literal_candidates + 1) * HORIZON * MODES,
            lambda: literal.traj_gen(
                robot, start, target, [human], obstacles[:literal_candidates], HORIZON, 1.0, grown, 10.0, 0.5
            ),
            1,
        ),
        (
            "candidates: ours",
            (OBSTACLES + 1) * HORIZON * MODES,
            lambda: candidate_trajectories(robot, start, target, [human], horizon=HORIZON, rng=rng),
            repeats,
        ),
        (
            "400 plans x 1000 rollouts x 20 steps, rollouts drawn",
            400 * ROLLOUTS * 20,
            lambda: plan_safe_probability(plans, shared, rng=rng),
            repeats,
        ),
        (
            "400 plans x 1000 rollouts x 20 steps",
            400 * ROLLOUTS * 20,
            lambda: plan_safe_probability(plans, [human], rng=rng),
            repeats,
        ),
        (
            "Algorithm 2, a decision: the pursuit is safe",
            1,
            lambda: safe_control.control(start, target, [human], rng),
            repeats,
        ),
        (
            "Algorithm 2, a decision: a safe state is looked for",
            1,
            lambda: safe_control.control(head_on, target, [human], rng),
            repeats,
        ),
        (
            "Algorithm 3 with a check, a decision",
            1,
            lambda: candidate_control.control(head_on, target, [human], rng),
            repeats,
        ),
    ]
    found = []
    for name, steps, action, times in rows:
        clock, cpu = least(action, times)
        found.append(
            {"name": name, "steps": steps, "least": clock, "least_cpu": cpu, "steps_per_second": steps / cpu}
        )
    return found


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
    rows = measure(*((3, 20, 1) if arguments.quick else (200, 300, 16)))
    rate = {row["name"]: row["steps_per_second"] for row in rows}
    ratios = {
        name: rate[f"{name}: ours"] / rate[f"{name}: literal"]
        for name in ("long-term safe probability", "candidates")
    }
    if arguments.json:
        print(json.dumps({"python": platform.python_version(), "rows": rows, "times_literal": ratios}))
        return
    print(
        f"Python {platform.python_version()}, NumPy {np.__version__}, one core; load {os.getloadavg()[0]:.1f}"
    )
    print(f"{'':<54} {'ms':>9} {'ms cpu':>9} {'steps/s':>9}")
    for row in rows:
        each = f"{row['steps_per_second']:9.2g}" if row["steps"] > 1 else ""
        print(f"{row['name']:<54} {1e3 * row['least']:>9.3f} {1e3 * row['least_cpu']:>9.3f} {each}")
    for name, ratio in ratios.items():
        print(f"{name}: {ratio:,.0f} times the literal algorithm (aim {AIM_RATIO})")
    print(f"rollout steps a second, aim {AIM_STEPS:.2g}: {rate['long-term safe probability: ours']:.2g}")


if __name__ == "__main__":
    main()
