"""`ppsim examples`: what simulated humans do next given the robot's plan, for learned prediction, streamed to disk."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

DESCRIPTION = """\
Generate examples for 'ppinfer learn' from the reaching game: the last second of motion of both agents, the
plan that the robot is about to follow, the goals, and how often the human then reaches each goal first, over
several continuations of the game from that instant.

Examples are appended to DATA.zarr as they come, in batches, and memory does not grow with them. If that is
interrupted, or more are wanted later, the same command continues. The first n examples depend on the seed
and the options only, whatever the number of workers.
"""

EPILOG = """\
examples:
  ppsim examples 10000 --seed 1 -o DATA.zarr
  ppsim examples 1000000 --seed 1 --workers 8 --humans moving --goals 3 -o DATA.zarr
"""

# option: (field of ExampleStudy, metavar, help); defaults and types are the field's
_OPTIONS = (
    ("seed", "S", "seed of the examples"),
    ("noise", "SD", "disturbance of the human's velocity, per dimension and step, m/s"),
    ("past", "STEPS", "steps of motion so far, the present one included"),
    ("horizon", "STEPS", "steps of the robot's plan"),
    ("continuations", "K", "how often the game goes on from each example"),
    ("limit", "S", "longest continuation, s; the goal nearest to a human who is at none then counts"),
    ("every", "S", "time between two examples of a game, s"),
    ("keep", "P", "probability that the robot keeps its goal from one example to the next"),
)


def add_parser(commands: argparse._SubParsersAction[Any]) -> None:
    """Add ``examples``."""
    from ppsim.reaching.examples import ExampleStudy
    from ppsim.reaching.many_games import KINDS

    parser = commands.add_parser(
        "examples",
        help="generate examples of what humans do next, given the robot's plan",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("examples", type=int, metavar="N", help="how many examples there are to be in the end")
    add("-o", "--output", type=Path, required=True, metavar="DATA.zarr", help="the folder to append to")
    defaults = ExampleStudy()
    for name, metavar, text in _OPTIONS:
        default = getattr(defaults, name)
        add(
            f"--{name}",
            type=type(default),
            default=default,
            metavar=metavar,
            help=f"{text} (default: {default})",
        )
    add(
        "--goals",
        type=int,
        nargs="+",
        default=list(defaults.goals),
        metavar="N",
        help="how many goals games have, drawn from these (default: 3 4 5)",
    )
    add(
        "--humans",
        nargs="+",
        choices=KINDS,
        default=list(KINDS),
        metavar="KIND",
        help=f"simulated humans, drawn from these: {', '.join(KINDS)} (default: all)",
    )
    add("--workers", type=int, default=1, metavar="W", help="processes (default: 1)")
    add("--json", action="store_true", help="print one JSON object instead of text")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Generate, and say what is there."""
    from ppinfer.cli.output import print_json
    from ppinfer.cli.progress import progress_bar
    from ppinfer.studies.prediction_examples import ExampleStore
    from ppsim.reaching.examples import ExampleStudy, record_examples

    options = {name: getattr(args, name) for name, _, _ in _OPTIONS}
    study = ExampleStudy(goals=tuple(args.goals), humans=tuple(args.humans), **options)
    try:
        with progress_bar("generating examples") as progress:
            resumed = record_examples(
                study, args.examples, args.output, workers=args.workers, progress=progress
            )
    except KeyboardInterrupt:
        print(
            f"ppsim examples: interrupted; {args.output} holds what came before: run the same command to go on",
            file=sys.stderr,
        )
        return 130
    store = ExampleStore(args.output)
    hours = store.interaction(0, len(store)) / 3600
    if args.json:
        print_json(
            {
                "output": str(args.output),
                "examples": len(store),
                "examples_resumed": resumed,
                "interaction_hours": hours,
                "configuration": store.header.configuration,
            }
        )
        return 0
    print(
        f"{args.output}: {len(store)} examples from {hours:.1f} h of simulated interaction, continuations included"
    )
    if resumed:
        print(f"went on from {resumed} examples that were there")
    print(f"next: ppinfer learn {args.output} -o MODEL.safetensors")
    return 0
