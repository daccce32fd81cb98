"""`ppsim crossing`: two agents swap places, again and again, and one of them takes no notice of the other."""

from __future__ import annotations

import argparse
import math
from typing import Any

DESCRIPTION = """\
Head-on crossing: a robot at (-5, 0) m and a human at (5, 0) m swap places. The human is greedy: it goes for
its place, its velocity disturbed at every step of 0.1 s, and avoids nobody. Centres nearer than 1 m are a
violation. For each controller of the robot and each noise: how many runs had one, with an upper bound at 95 %
confidence, and whether and when the robot was at its place.

Safety is claimed for each decision: the plan that is accepted now would, if carried out to the end, meet a
violation with a probability of at most eps. What share of accepted plans would is told per decision; what
deciding anew at every step makes of it is told per run.

  none       straight on
  alg2       Algorithm 2: on while that is safe, else towards a safe state, that step being checked for itself
  alg3       Algorithm 3: candidate trajectories, of which the cheapest is taken that rollouts say is safe
  alg2-weak  Algorithm 2 with gamma = 10 and whatever its step towards a safe state is worth
  alg3-tube  Algorithm 3 with the printed check against growing discs only
"""

EPILOG = """\
examples:
  ppsim crossing --runs 1000 --seed 1 --workers 2
  ppsim crossing --runs 1000 --noise .1 .5 --controllers none alg2 alg3 --eps .05 --seed 1 --json
"""


def add_parser(commands: argparse._SubParsersAction[Any]) -> None:
    """Add ``crossing``."""
    from ppsim.reaching.crossing import CONTROLLERS

    parser = commands.add_parser(
        "crossing",
        help="let a robot and a human swap places, many times, and count violations",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--runs", type=int, default=1000, metavar="N", help="runs of each pair (default: %(default)s)")
    add(
        "--noise",
        type=float,
        nargs="+",
        default=[0.1, 0.5],
        metavar="SD",
        help="standard deviations of what disturbs the human's velocity, m/s a step (default: 0.1 0.5)",
    )
    add(
        "--controllers",
        nargs="+",
        default=["none", "alg2", "alg3"],
        choices=list(CONTROLLERS),
        metavar="NAME",
        help=f"any of {', '.join(CONTROLLERS)} (default: none alg2 alg3)",
    )
    add(
        "--eps",
        type=float,
        default=0.05,
        metavar="P",
        help="tolerated probability of a violation (default: %(default)s)",
    )
    add("--seed", type=int, default=0, metavar="S", help="seed of all runs (default: 0)")
    add(
        "--workers",
        type=int,
        default=1,
        metavar="W",
        help="processes; the outcome does not depend on them (default: 1)",
    )
    add("--json", action="store_true", help="print one JSON object instead of text")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Play all runs, and print what came out."""
    from ppinfer.cli.output import print_json
    from ppinfer.cli.progress import progress_bar
    from ppsim.naming import checked_names
    from ppsim.reaching.crossing import CONTROLLERS, Crossing, cross_many, summarise

    checked_names("controllers", args.controllers, CONTROLLERS)
    noises = [repr(noise) for noise in args.noise]
    checked_names("noises", noises, noises)
    cells: list[dict[str, Any]] = []
    # all are built before the first is played, so that a wrong value costs nothing
    crossings = [Crossing(noise, eps=args.eps) for noise in args.noise]
    for controller in args.controllers:
        for crossing in crossings:
            done = []
            with progress_bar(f"{controller} at {crossing.noise:g}") as progress:
                for crossed in cross_many(
                    crossing, controller, args.runs, seed=args.seed, workers=args.workers
                ):
                    done.append(crossed)
                    progress(len(done), args.runs)
            cells.append({"controller": controller, "noise": crossing.noise, **summarise(done, args.eps)})
    if args.json:
        print_json(
            {
                "runs": args.runs,
                "seed": args.seed,
                "eps": args.eps,
                "confidence": crossings[0].confidence,
                "distance": crossings[0].distance,
                "cells": cells,
            }
        )
        return 0
    _print(cells, args)
    return 0


def _print(cells: list[dict[str, Any]], args: argparse.Namespace) -> None:
    from ppinfer.cli.output import print_table

    print_table(
        f"head-on crossing, {args.runs} runs each, eps = {args.eps:g}, seed {args.seed}",
        (
            "robot",
            "noise",
            "violations",
            "95 % bound",
            "at its place",
            "after s",
            "plans violated",
            "flagged",
        ),
        [
            [
                cell["controller"],
                f"{cell['noise']:g}",
                str(cell["violations"]),
                f"{cell['violation_upper']:.3f}" + (" kept" if cell["keeps_eps"] else ""),
                f"{cell['reached_rate']:.1%}",
                _time(cell),
                f"{cell['plan_violations']} of {cell['accepted']}" if cell["accepted"] else "none accepted",
                f"{cell['flagged']} of {cell['decisions']}",
            ]
            for cell in cells
        ],
    )
    print(
        "violations are counted in runs; plans violated: of the decisions accepted as safe, how many would have met a "
        "violation if carried out to the end"
    )


def _time(cell: dict[str, Any]) -> str:
    if not math.isfinite(cell["reached_s"]):
        return ""
    sem = f" ± {cell['reached_s_sem']:.2f}" if math.isfinite(cell["reached_s_sem"]) else ""
    return f"{cell['reached_s']:.2f}{sem}"
