"""What one replan of one agent costs, stage by stage, and what its table costs by stepping the physical world.

Run with ``python benchmarks/replan.py`` (``--quick`` for a glance, ``--json`` for one JSON object). One process on one
core. The situations are those that a robot came to in trials that are played first, with both arms still there. Every
stage is repeated in each of them, of which the least counts, by the clock and of the processor (which stands when
others use the machine as well); the rows give the mean and the largest over situations. Plans are sampled for both
agents: 7 and the static one for BayesNash, 24 and the static one for BayesRisk.
"""

from __future__ import annotations

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))

import argparse
import json
import platform
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ppinfer.coordination import (
    BayesNash,
    BayesRisk,
    NormNash,
    PlanSet,
    Policy,
    Situation,
    coordination_equilibria,
)
from ppsim.arms import ArmsWorld, Scene, contact_tables, sample_plans
from ppsim.arms.playing import Played, Replanned, play

SCENES, REPEATS, STEPPED = 12, 9, 3
STEP = 0.1
AIMS_MS = {
    "bayes: table": 0.5,
    "bayes: equilibria and belief": 0.1,
    "bayes: whole replan": 3.0,
    "bayes-risk: whole replan": 8.0,
}


@dataclass(frozen=True)
class Moment:
    """A replan of a trial: where both arms were, what was still to be done, and what the robot remembered."""

    scene: Scene
    here: dict[str, np.ndarray]
    goals: dict[str, tuple[np.ndarray, ...]]
    replanned: Replanned
    memory: Any


def moments(policy: Policy, scenes: int) -> list[Moment]:
    """Play trials, and return the replans at which both arms were there."""
    found = []
    for seed in range(scenes):
        scene = Scene.random(np.random.default_rng(seed))
        played = play(scene, {"robot": policy, "human": NormNash()}, seed=seed, plan_sets="independent")
        memory = None
        for one in played.replans:
            if np.isfinite(played.position[one.sample]).all():
                found.append(moment(scene, played, one, memory))
            memory = one.decision.memory
    return found


def moment(scene: Scene, played: Played, one: Replanned, memory: Any) -> Moment:
    """Return what the robot planned from at a replan."""
    goals = {}
    for player, agent in enumerate(scene.agents):
        task = scene.tasks[agent]
        so_far = scene.arms[agent].end_effector(played.position[: one.sample + 1, player])
        goals[agent] = task.goals(holding=bool((np.linalg.norm(so_far - task.pick, axis=-1) <= 0.01).any()))
    here = dict(zip(scene.agents, played.position[one.sample], strict=True))
    return Moment(scene, here, goals, one, memory)


def plans_at(at: Moment, count: int) -> tuple[PlanSet, ...]:
    """Sample both agents' plans."""
    return tuple(
        sample_plans(at.scene.arms[agent], agent, at.here[agent], at.goals[agent], seed=player, count=count)
        for player, agent in enumerate(at.scene.agents)
    )


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


def stages(policy: Policy, at: Moment) -> dict[str, Callable[[], object]]:
    """Return what one replan does, stage by stage, and the whole of it."""
    arms = [at.scene.arms[agent] for agent in at.scene.agents]
    plans = plans_at(at, policy.samples)
    collision, contact = contact_tables(arms, plans)

    def situation_of(sampled: tuple[PlanSet, ...], touched: np.ndarray, near: np.ndarray) -> Situation:
        return Situation.from_contacts(
            sampled, touched, contact_time=near, motion=at.replanned.situation.motion
        )

    def whole() -> object:
        sampled = plans_at(at, policy.samples)
        return policy.decide(situation_of(sampled, *contact_tables(arms, sampled)), "robot", at.memory)

    situation = situation_of(plans, collision, contact)
    model: Any = policy.belief_model()
    return {
        "plans of both agents": lambda: plans_at(at, policy.samples),
        "table": lambda: contact_tables(arms, plans),
        "game": lambda: situation_of(plans, collision, contact),
        "equilibria": lambda: coordination_equilibria(situation.game),
        "equilibria and belief": lambda: model.observe(situation, "robot", at.memory),
        "decision, equilibria and belief within": lambda: policy.decide(situation, "robot", at.memory),
        "whole replan": whole,
    }


def measure(policies: dict[str, Policy], scenes: int, repeats: int) -> list[dict[str, Any]]:
    """Time the stages of each policy's replans, in seconds."""
    rows = []
    for name, policy in policies.items():
        clock: dict[str, list[float]] = {}
        cpu: dict[str, list[float]] = {}
        for at in moments(policy, scenes):
            for stage, action in stages(policy, at).items():
                seconds, worked = least(action, repeats)
                clock.setdefault(stage, []).append(seconds)
                cpu.setdefault(stage, []).append(worked)
        for stage, seconds in clock.items():
            rows.append(
                {
                    "name": f"{name}: {stage}",
                    "situations": len(seconds),
                    "mean": statistics.fmean(seconds),
                    "largest": max(seconds),
                    "mean_cpu": statistics.fmean(cpu[stage]),
                }
            )
    return rows


def stepped_table(scene: Scene, plans: tuple[PlanSet, ...]) -> np.ndarray:
    """Return when arms first touch, by letting the physical world carry out every profile from home."""
    table = np.full([len(own) for own in plans], np.inf)
    for profile in np.ndindex(table.shape):
        ends = [
            np.inf if one == own.static else own.duration[one]
            for own, one in zip(plans, profile, strict=True)
        ]
        if np.isinf(min(ends)):
            continue
        times = np.arange(1, round(min(ends) / STEP) + 1) * STEP
        courses = [own.restrict([one]).positions(times)[0] for own, one in zip(plans, profile, strict=True)]
        world = ArmsWorld(scene)
        for now, *poses in zip(times, *courses, strict=True):
            _, events = world.step(dict(zip(scene.agents, poses, strict=True)))
            if events:
                table[profile] = now
                break
    return table


def step_worlds(scenes: int) -> dict[str, Any]:
    """Time the tables of some first replans both ways, and count the profiles in which they agree."""
    seconds, agree, profiles = [], 0, 0
    for seed in range(scenes):
        scene = Scene.random(np.random.default_rng(seed))
        arms = [scene.arms[agent] for agent in scene.agents]
        plans = tuple(
            sample_plans(
                scene.arms[agent], agent, scene.arms[agent].home, scene.tasks[agent].goals(), seed=player
            )
            for player, agent in enumerate(scene.agents)
        )
        begin = time.process_time()
        table = stepped_table(scene, plans)
        seconds.append(time.process_time() - begin)
        agree += int((table == contact_tables(arms, plans)[0]).sum())
        profiles += table.size
    return {"tables": scenes, "mean_cpu": statistics.fmean(seconds), "profiles": profiles, "agree": agree}


def main() -> None:
    """Print the table, or the JSON object."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--quick", action="store_true", help="few situations and repeats: a glance, not a measure"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object, in seconds")
    arguments = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    scenes, repeats, stepped = (1, 2, 1) if arguments.quick else (SCENES, REPEATS, STEPPED)
    rows = measure({"bayes": BayesNash(), "bayes-risk": BayesRisk()}, scenes, repeats)
    worlds = step_worlds(stepped)
    if arguments.json:
        print(json.dumps({"python": platform.python_version(), "rows": rows, "stepping_pymunk": worlds}))
        return
    print(
        f"Python {platform.python_version()}, NumPy {np.__version__}, one core; load {os.getloadavg()[0]:.1f}"
    )
    print(f"milliseconds a replan\n{'':<52} {'mean':>8} {'largest':>8} {'mean cpu':>9} {'aim':>6}")
    for row in rows:
        aim = AIMS_MS.get(row["name"])
        print(
            f"{row['name']:<52} {1e3 * row['mean']:>8.3f} {1e3 * row['largest']:>8.3f} {1e3 * row['mean_cpu']:>9.3f}"
            f" {'' if aim is None else f'{aim:g}':>6}"
        )
    ours = next(row["mean_cpu"] for row in rows if row["name"] == "bayes: table")
    print(
        f"the table by stepping pymunk: {1e3 * worlds['mean_cpu']:,.0f} ms, {worlds['mean_cpu'] / ours:,.0f} times as "
        f"long; {worlds['agree']} of {worlds['profiles']} profiles first touch in the same 0.1 s"
    )


if __name__ == "__main__":
    main()
