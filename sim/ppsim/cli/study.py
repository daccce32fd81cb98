"""`ppsim study`: every robot with every simulated human, in paired scenes, recorded and summed up."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppsim.cli.playing import add_playing_arguments, play_study

if TYPE_CHECKING:
    from ppinfer.studies.task_performance import TaskPerformance
    from ppsim.arms.study import ArmsStudy

DESCRIPTION = """\
Play a study of two arms that pick and place side by side: every robot with every simulated human in every
scene, each planning with OMPL in joint space, in a physical world with a safety stop. Trials of one scene
share the task and the seeds of all plans, so that robots are compared in pairs.

The table gives, for each robot, the mean over trials and its standard error (robust to what trials of a
scene share): seconds until both, the robot and the human had finished, safety stops, episodes of stops and
the share of trials that somebody did not finish. Below it are paired differences with intervals of a bootstrap
over scenes.

Trials are appended to LOG.recording.jsonl as they end, which becomes LOG.nc at the end; --resume goes on
with one that was interrupted, to the same log.
"""

EPILOG = """\
examples:
  ppsim study --scenes 20 --seed 1 --workers 2 -o LOG.nc
  ppsim study --scenes 200 --robots norm norm-committed bayes-risk --plan-sets independent --seed 1000 -o LOG.nc
  ppsim study --scenes 50 --robots norm my_policies:Polite --seed 1 -o LOG.nc       a policy of your own
  ppsim study --scenes 50 --collision-stride 0.8 --cost-unit 1 --seed 1 -o LOG.nc   as the paper has it
"""

AGAINST = ("norm", "norm-committed")


def add_parser(commands: argparse._SubParsersAction[Any]) -> None:
    """Add ``study``."""
    from ppinfer.coordination import POLICIES
    from ppsim.arms.execution import PLAN_SETS, Execution
    from ppsim.arms.robots import HUMANS, ROBOTS
    from ppsim.arms.study import ArmsStudy

    parser = commands.add_parser(
        "study",
        help="play two arms side by side, many times, and compare robots",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add(
        "--scenes",
        type=int,
        required=True,
        metavar="N",
        help="how many scenes; each is a trial for every pair",
    )
    add(
        "--robots",
        nargs="+",
        default=list(POLICIES),
        metavar="NAME",
        help=f"any of {', '.join(ROBOTS)}, or module:attribute of a Policy of your own "
        "(default: all of these but the ones that end in -clear)",
    )
    add(
        "--humans",
        nargs="+",
        default=list(HUMANS),
        metavar="NAME",
        help=f"any of {', '.join(HUMANS)}, or module:attribute (default: all of these)",
    )
    add(
        "--plan-sets",
        nargs="+",
        default=["shared"],
        metavar="NAME",
        choices=PLAN_SETS,
        help="shared: both agents look at the same plans; independent: each samples its own, as a person would "
        "(default: shared; both can be named)",
    )
    add_playing_arguments(parser, "trials")
    add(
        "--collision-stride",
        type=float,
        default=Execution.collision_stride,
        metavar="S",
        help="seconds between the instants at which profiles are checked for collisions (default: %(default)s; the "
        "paper's is 0.8, between which arms pass through each other)",
    )
    add(
        "--cost-unit",
        type=float,
        default=ArmsStudy.cost_unit,
        metavar="S",
        help="seconds that count as one unit of cost in the norm of 'bayes' (default: %(default)s; literally 1)",
    )
    add("--planner", default=Execution.planner, metavar="NAME", help="OMPL's planner (default: %(default)s)")
    add("--json", action="store_true", help="print one JSON object instead of text")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Play the study, and print what came out."""
    from ppinfer.cli.output import print_json
    from ppinfer.studies.task_performance import task_performance
    from ppsim.arms.execution import Execution
    from ppsim.arms.study import ArmsStudy

    study = ArmsStudy(
        scenes=args.scenes,
        robots=tuple(args.robots),
        humans=tuple(args.humans),
        plan_sets=tuple(args.plan_sets),
        seed=args.seed,
        cost_unit=args.cost_unit,
        execution=Execution(collision_stride=args.collision_stride, planner=args.planner),
    )
    recorded = play_study(study, study.trials, args, "trials")
    if recorded is None:
        return 130
    performance = task_performance(recorded.log)
    if args.json:
        print_json(
            {
                "output": str(args.output),
                "trials": study.trials,
                "trials_resumed": recorded.resumed,
                "pooled": performance.pooled(),
                "cells": performance.cells(),
                "differences": performance.differences(),
                "configuration": study.configuration(),
            }
        )
        return 0
    _print(performance, study, args.output, recorded.resumed)
    return 0


def _print(performance: TaskPerformance, study: ArmsStudy, output: Path, resumed: int) -> None:
    from ppinfer.cli.output import print_table
    from ppsim.cli.intervals import with_sem

    print(f"{output}: {study.trials} trials in {study.scenes} scenes, seed {study.seed}")
    if resumed:
        print(f"went on from {resumed} trials of an interrupted recording")
    metrics = ("total_s", "robot_s", "human_s", "stops", "stop_episodes", "failures")
    titles = ("total s", "robot s", "human s", "stops", "episodes", "failures")

    def told(row: dict[str, Any]) -> list[str]:
        return [with_sem(row[name], row[f"{name}_sem"], 2 if name.endswith("_s") else 3) for name in metrics]

    for plan_sets in study.plan_sets:
        pooled = [row for row in performance.pooled() if row["plan_sets"] == plan_sets]
        print_table(
            f"{plan_sets} plan sets, all humans",
            ("robot", *titles),
            [[row["robot"], *told(row)] for row in pooled],
        )
        cells = [row for row in performance.cells() if row["plan_sets"] == plan_sets]
        if len(study.humans) > 1:
            print_table(
                f"{plan_sets} plan sets, by human",
                ("robot", "human", *titles),
                [[row["robot"], row["human"], *told(row)] for row in cells],
            )
        rows = [
            row
            for row in performance.differences(AGAINST)
            if row["plan_sets"] == plan_sets and row["metric"] in ("total_s", "stops")
        ]
        if rows:
            print_table(
                f"{plan_sets} plan sets, paired differences [95 % interval]",
                ("robot", "less", "total s", "stops"),
                [
                    [times["robot"], times["against"], _difference(times), _difference(stops)]
                    for times, stops in zip(rows[::2], rows[1::2], strict=True)
                ],
            )
    print(
        f"next: ppinfer report {output} -o REPORT, or ppinfer infer {output} -o POST.nc --model personality"
    )


def _difference(row: dict[str, Any]) -> str:
    from ppsim.cli.intervals import with_interval

    return with_interval(row["mean"], row["low"], row["high"])
