"""How fast goal posteriors are: one core, next to the equations as printed, a filterpy bank, and a bare copy.

Run with ``python benchmarks/goal_posterior.py`` (a few minutes; ``--quick`` for a glance, ``--json`` for a
machine). A sample-goal is the belief in one goal at one sample. Everything runs in one process on one core: the
libraries' threads are limited to one before they are imported, and the process is pinned to a core where the
system allows. Only the runs from file to file are processes of their own, so that their peak memory is theirs.
"""

from __future__ import annotations

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))

import argparse
import json
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.linalg import solve_discrete_are

from ppinfer.goals import GoalDesign, GoalEvidence, GoalKalman, GoalLQR, OnlineGoalBelief, infer_goals
from ppinfer.goals.model import GoalModel
from ppinfer.studies import open_log, validate_log
from ppinfer.studies.checksums import content_digest
from ppinfer.studies.infer import infer_posterior

GOALS = 5
ROW = 200
DT = 0.1
LABELS = tuple("abcde")
DYNAMICS = ("single-integrator", "double-integrator")


@dataclass(frozen=True)
class Timing:
    """One row of the table: seconds for a number of sample-goals, by the clock and of the processor.

    On an idle machine the two agree; where others use the core as well, the processor's tell what the work takes.
    """

    name: str
    sample_goals: int
    least: float
    median: float
    processor_least: float
    processor_median: float


def timed(name: str, action: Callable[[], object], samples: int, repeats: int) -> Timing:
    """Time an action that handles so many samples, after once to warm up."""
    action()
    clock, processor = [], []
    for _ in range(repeats):
        begin, worked = time.perf_counter(), time.process_time()
        action()
        clock.append(time.perf_counter() - begin)
        processor.append(time.process_time() - worked)
    median = statistics.median
    return Timing(name, samples * GOALS, min(clock), median(clock), min(processor), median(processor))


def model_of(dynamics: str, stay: float = 1.0) -> GoalLQR:
    """Return the model whose motion is simulated and inferred."""
    return GoalLQR(dynamics=dynamics, control_weight=5.0, rationality=0.5, stay=stay)


def motion(model: GoalModel, samples: int, seed: int = 0) -> GoalEvidence:
    """Simulate rows of `ROW` samples among `GOALS` goals, states and controls logged."""
    rng = np.random.default_rng(seed)
    design = GoalDesign.random(rng, rows=max(1, samples // ROW), goals=GOALS, samples=ROW, dt=DT)
    return model.simulate(design, rng)


def positions_of(evidence: GoalEvidence) -> GoalEvidence:
    """Return the same motion with nothing but positions logged."""
    return replace(evidence, velocity=None, control=None)


def literal_loop(evidence: GoalEvidence, model: GoalLQR, rows: int) -> None:
    """(22)-(27) as printed, one sample and one goal after another."""
    dynamics = model.agent_at(DT).dynamics
    A, B, beta = dynamics.A, dynamics.B, model.rationality
    Q, R = model.state_weight * np.eye(dynamics.states), model.control_weight * np.eye(dynamics.controls)
    P = solve_discrete_are(A, B, Q, R)
    m = dynamics.controls
    assert evidence.control is not None
    for row in range(rows):
        goals = dynamics.goal_states(evidence.goals[row])
        belief = np.full(GOALS, 1 / GOALS)
        for t in range(row * ROW, (row + 1) * ROW):
            x, u = evidence.position[t], evidence.control[t]
            log_likelihood = np.empty(GOALS)
            for k, goal in enumerate(goals):
                following = A @ x + B @ u
                reward = -(x - goal) @ Q @ (x - goal) - u @ R @ u
                q_value = reward - (following - goal) @ P @ (following - goal)
                determinant = np.linalg.det(2 * beta * R + 2 * beta * B.T @ P @ B)
                log_normaliser = -beta * (x - goal) @ P @ (x - goal) + 0.5 * np.log(
                    (2 * np.pi) ** m / determinant
                )
                log_likelihood[k] = beta * q_value - log_normaliser
            belief = belief * np.exp(log_likelihood - log_likelihood.max())
            belief = belief / belief.sum()


def online(model: GoalModel, evidence: GoalEvidence, *, logged: bool) -> Callable[[], None]:
    """Return a run of the online object over the first row of the evidence."""
    belief = OnlineGoalBelief(model, dt=DT, labels=LABELS)
    control, velocity = (evidence.control, evidence.velocity) if logged else (None, None)

    def run() -> None:
        belief.restart(evidence.goals[0])
        for t in range(ROW):
            belief.observe(
                float(evidence.time[t]),
                evidence.position[t],
                velocity=None if velocity is None else velocity[t],
                control=None if control is None else control[t],
                control_order=evidence.control_order,
            )

    return run


def cases(dynamics: str) -> list[tuple[str, float, bool]]:
    """Return a name, the probability that goals stay, and whether velocities and controls are logged."""
    return [
        (f"{dynamics}, {'logged' if logged else 'positions'}, stay={stay:g}", stay, logged)
        for stay in (1.0, 0.98)
        for logged in (True, False)
    ]


def in_memory(samples: int, repeats: int) -> list[Timing]:
    """Time everything that touches no file."""
    table = []
    short = motion(model_of(DYNAMICS[0]), ROW)
    table.append(
        timed(
            "literal loop, (22)-(27)",
            lambda: literal_loop(short, model_of(DYNAMICS[0]), 1),
            ROW,
            min(repeats, 3),
        )
    )
    hidden = GoalKalman(rationality=0.5)
    noisy = motion(hidden, ROW)
    table.append(timed("filterpy bank, online", online(hidden, noisy, logged=False), ROW, min(repeats, 3)))
    many = motion(hidden, samples // 10)
    table.append(timed("Kalman bank, ours, batch", lambda: infer_goals(hidden, many), many.samples, repeats))
    for dynamics in DYNAMICS:
        row = motion(model_of(dynamics), ROW)
        for name, stay, logged in cases(dynamics):
            run = online(model_of(dynamics, stay), row, logged=logged)
            table.append(timed(f"online, {name}", run, ROW, 3 * repeats))
    for dynamics in DYNAMICS:
        everything = motion(model_of(dynamics), samples)
        positions = positions_of(everything)
        for name, stay, logged in cases(dynamics):
            infer = partial(infer_goals, model_of(dynamics, stay), everything if logged else positions)
            table.append(timed(f"batch, {name}", infer, samples, repeats))
    unchecked = motion(model_of(DYNAMICS[0]), samples)
    table.append(
        timed(
            f"batch, {DYNAMICS[0]}, logged, arrays checked as well",
            lambda: infer_goals(model_of(DYNAMICS[0]), replace(unchecked)),
            unchecked.samples,
            repeats,
        )
    )
    posterior = np.random.default_rng(0).normal(size=(samples, GOALS))
    room = np.zeros_like(posterior)
    table.append(timed("copy of the same bytes, into new memory", posterior.copy, samples, repeats))
    table.append(
        timed("copy of the same bytes, into old memory", lambda: np.copyto(room, posterior), samples, repeats)
    )
    return table


def write_long_log(path: Path, samples: int, block_rows: int = 500) -> None:
    """Write a sound study log of positions, block by block, in the format of docs/log-format.md."""
    import h5netcdf
    import h5py

    model = model_of(DYNAMICS[0])
    trials = max(1, samples // ROW)
    packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True}
    with h5netcdf.File(path, "w") as file:
        file.dimensions = {
            "trial": trials, "sample": trials * ROW, "agent": 1, "space": 2, "goal": GOALS, "segment": trials,
        }  # fmt: skip

        def new(name: str, dims: tuple[str, ...], dtype: str, values: object = None) -> h5netcdf.Variable:
            text = dtype == "text"
            long = {} if text or dims[0] not in ("sample", "trial", "segment") else packed
            if long:
                shape = tuple(file.dimensions[dim].size for dim in dims)
                long = {**long, "chunks": (min(shape[0], 32_768), *shape[1:])}
            variable = file.create_variable(name, dims, h5py.string_dtype() if text else dtype, **long)
            if values is not None:
                variable[...] = np.array(values, dtype=object if text else dtype)
            return variable

        new("agent", ("agent",), "text", ["human"])
        new("space", ("space",), "text", ["x", "y"])
        new("goal", ("goal",), "text", LABELS)
        new("trial_id", ("trial",), "text", [f"trial-{number}" for number in range(trials)])
        new("participant", ("trial",), "text", [f"person-{number % 20}" for number in range(trials)])
        new("row_size", ("trial",), "int64", np.full(trials, ROW)).attrs["sample_dimension"] = "sample"
        new("segment_trial", ("segment",), "int64", np.arange(trials))
        new("segment_agent", ("segment",), "text", ["human"] * trials)
        new("segment_start", ("segment",), "int64", np.zeros(trials))
        new("segment_stop", ("segment",), "int64", np.full(trials, ROW))
        new("goal_present", ("trial", "goal"), "int8", np.ones((trials, GOALS)))
        moving = {
            "time": new("time", ("sample",), "float64"),
            "position": new("position", ("sample", "agent", "space"), "float64"),
            "observed": new("observed", ("sample", "agent"), "int8"),
        }
        placed = new("goal_position", ("trial", "goal", "space"), "float64")
        moving["time"].attrs["units"] = "s"
        moving["position"].attrs["units"] = placed.attrs["units"] = "m"
        pursued = []
        rng = np.random.default_rng(0)
        for first in range(0, trials, block_rows):
            rows = min(block_rows, trials - first)
            design = GoalDesign.random(rng, rows=rows, goals=GOALS, samples=ROW, dt=DT)
            evidence = model.simulate(design, rng)
            at = slice(first * ROW, (first + rows) * ROW)
            moving["time"][at] = evidence.time
            moving["position"][at] = evidence.position[:, None]
            moving["observed"][at] = np.ones((rows * ROW, 1), np.int8)
            placed[first : first + rows] = design.goals
            pursued += [LABELS[goal] for goal in design.true_goal.tolist()]
        new("true_goal", ("segment",), "text", pursued)
        file.attrs.update(
            {
                "Conventions": "CF-1.11",
                "featureType": "trajectory",
                "ppinfer_format": "study-log",
                "ppinfer_format_version": 1,
            }
        )
    with open_log(path) as log:
        signature = content_digest(log)
    with h5netcdf.File(path, "a") as file:
        file.attrs["content_sha256"] = signature


def peak_memory() -> int:
    """Return the most memory this process has held, in bytes."""
    status = Path("/proc/self/status")
    if status.exists():
        # the kernel's count for the program itself: getrusage begins with that of the process that started it
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return 1024 * int(line.split()[1])
    import resource

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most


@dataclass(frozen=True)
class FileRun:
    """One inference from file to file."""

    samples: int
    seconds: float
    processor_seconds: float
    peak_bytes: int
    log_bytes: int


def infer_file(log: Path) -> FileRun:
    """Infer a log's posterior in this process."""
    begin, worked = time.perf_counter(), time.process_time()
    done = infer_posterior(log, log.with_name("posterior.nc"), model_of(DYNAMICS[0]))
    return FileRun(
        done.samples,
        time.perf_counter() - begin,
        time.process_time() - worked,
        peak_memory(),
        log.stat().st_size,
    )


def from_file_to_file(sizes: list[int]) -> list[FileRun]:
    """Infer generated logs of some sizes, each in a process of its own; the files are removed."""
    runs = []
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder, "log.nc")
        write_long_log(log, 10 * ROW)
        validate_log(log).raise_if_faulty()
        # the first time on a machine, this compiles
        infer_file(log)
        for samples in sizes:
            write_long_log(log, samples)
            child = subprocess.run(
                [sys.executable, __file__, "--infer-file", str(log)],
                check=True,
                capture_output=True,
                text=True,
            )
            runs.append(FileRun(**json.loads(child.stdout)))
    return runs


def show(table: list[Timing], runs: list[FileRun]) -> None:
    """Print both tables."""
    by_name = {row.name: row for row in table}

    def seconds_each(row: Timing) -> float:
        return row.processor_least / row.sample_goals

    literal = seconds_each(by_name["literal loop, (22)-(27)"])
    fresh = seconds_each(by_name["copy of the same bytes, into new memory"])
    print(
        f"Python {platform.python_version()}, NumPy {np.__version__}, one core; load {os.getloadavg()[0]:.1f} "
        f"of {os.cpu_count()}\n"
        f"{GOALS} goals, rows of {ROW} samples. Sample-goals a second by the least and the median time of the "
        "clock, and by\nthe least processor time; by the last, microseconds a sample, how many times as fast as "
        "the literal loop, and\nhow many times as long as a copy of the posterior's bytes into new memory.\n"
    )
    print(
        f"{'':<56} {'best':>8} {'median':>8} {'by CPU':>8} {'us/sample':>10} {'x literal':>10} {'x copy':>8}"
    )
    for row in table:
        each = seconds_each(row)
        print(
            f"{row.name:<56} {row.sample_goals / row.least:8.2g} {row.sample_goals / row.median:8.2g} "
            f"{1 / each:8.2g} {1e6 * GOALS * each:10.3g} {literal / each:10.3g} {each / fresh:8.3g}"
        )
    print(f"\n{'from file to file':<24} {'seconds':>9} {'of them CPU':>12} {'samples/s':>10} {'peak MiB':>9}")
    for run in runs:
        print(
            f"{run.samples:>16,} samples {run.seconds:9.2f} {run.processor_seconds:12.2f} "
            f"{run.samples / run.seconds:10.3g} {run.peak_bytes / 2**20:9.0f}"
        )


def main() -> None:
    """Run and print the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--samples", type=int, default=1_000_000, help="samples of a batch in memory")
    parser.add_argument(
        "--file-samples",
        type=int,
        nargs="*",
        default=[1_000_000, 3_000_000, 10_000_000],
        help="sizes of the logs inferred from file to file",
    )
    parser.add_argument("--repeats", type=int, default=9, help="of which the least and the median are shown")
    parser.add_argument(
        "--quick", action="store_true", help="small sizes and few repeats: a glance, not a measure"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--infer-file", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    if options.infer_file is not None:
        print(json.dumps(asdict(infer_file(options.infer_file))))
        return
    if options.quick:
        options.samples, options.file_samples, options.repeats = 10_000, [10_000, 20_000], 2
    runs = from_file_to_file(options.file_samples)
    table = in_memory(options.samples - options.samples % ROW, options.repeats)
    if options.json:
        result = {
            "goals": GOALS,
            "load": os.getloadavg()[0],
            "in_memory": [
                {**asdict(row), "sample_goals_per_second": row.sample_goals / row.least} for row in table
            ],
            "files": [asdict(run) for run in runs],
        }
        print(json.dumps(result))
        return
    show(table, runs)


if __name__ == "__main__":
    main()
