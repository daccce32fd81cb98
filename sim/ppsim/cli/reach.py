"""`ppsim reach`: every robot with every simulated human in the reaching game, recorded and summed up."""

from __future__ import annotations

import argparse
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppsim.cli.playing import add_playing_arguments, play_study

if TYPE_CHECKING:
    from ppinfer.studies.game_performance import GamePerformance
    from ppsim.reaching import GameStudy

DESCRIPTION = """\
Play the reaching game: a robot and a human among N goals, for 30 s. When both are within 0.5 m of distinct
goals the team scores 2 points, and these two goals are drawn anew. Every robot plays with every simulated
human; games of one number share their starts and goals, so that robots are compared in pairs.

The tables give means over games and their standard errors (robust to what games of one number share): points,
collisions (nearer than 1 m, once per approach), how often the human and the robot turned to another goal
while the goals stayed, seconds until the first score (a game without one counts with its length), and the
share of games without a score. Below are paired differences with intervals of a bootstrap over games.

Games are appended to LOG.recording.jsonl as they end, which becomes LOG.nc at the end; --resume goes on
with one that was interrupted, to the same log. It takes room until then: about 290 MB for 1800 games.
"""

EPILOG = """\
examples:
  ppsim reach --games 20 --seed 1 --workers 2 -o LOG.nc
  ppsim reach --games 300 --goals 3 5 --seed 1000 --workers 2 -o LOG.nc
  ppsim reach --games 50 --robots reactive --reactive-threshold 0.5 --humans stubborn --seed 1 -o LOG.nc
  ppsim reach --games 50 --robots naive my_choosers:Polite --seed 1 -o LOG.nc        a GoalChooser of your own
"""

AGAINST = ("naive", "reactive")

# option: (field of GameStudy, metavar, help); defaults and types are the field's
_OPTIONS = (
    ("duration", "S", "length of a game, s"),
    ("reactive_threshold", "P", "how sure of the human's goal the reactive robot wants to be"),
    ("human_noise", "SD", "disturbance of the human's velocity per step, m/s"),
    ("control_weight", "R", "weight of the control in both agents' LQR; the more the slower they are"),
    ("rationality", "BETA", "with which agents infer each other's goals, 1/cost"),
    ("separation", "M", "least distance between two goals, m"),
    ("clearance", "M", "least distance of a new goal from an agent, and between starts, m"),
)


def add_parser(commands: argparse._SubParsersAction[Any]) -> None:
    """Add ``reach``."""
    from ppsim.reaching import GameStudy
    from ppsim.reaching.humans import HUMANS
    from ppsim.reaching.robots import GOAL_ROBOTS, KEEP_CLEAR, REACTIONS, ROBOTS
    from ppsim.reaching.world import REDRAWS

    parser = commands.add_parser(
        "reach",
        help="play the reaching game, many times, and compare robots",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add(
        "--games",
        type=int,
        required=True,
        metavar="N",
        help="how many games for every robot, human and number of goals",
    )
    add(
        "--robots",
        nargs="+",
        default=list(GOAL_ROBOTS),
        metavar="NAME",
        help=f"any of {', '.join(ROBOTS)}, or module:attribute of a GoalChooser of your own (default: all of these but "
        "joint, which takes about ten times as long)",
    )
    add(
        "--humans",
        nargs="+",
        default=list(HUMANS),
        metavar="NAME",
        help=f"any of {', '.join(HUMANS)} (default: all of these)",
    )
    add(
        "--goals",
        nargs="+",
        type=int,
        default=list(GameStudy.goals),
        metavar="N",
        help="goals at a time, one number or several (default: 3)",
    )
    add_playing_arguments(parser, "games")
    add(
        "--reaction",
        choices=tuple(REACTIONS),
        default=GameStudy.reaction,
        help="what influence and expected-cost take the human's reaction to their goal for: the paper's softmax, or "
        "that as long as the human does not know the goal (default: %(default)s)",
    )
    add(
        "--keep-clear",
        choices=KEEP_CLEAR,
        default=GameStudy.keep_clear,
        help="which robots swerve to keep clear of the human: those that predict a reaction (all but naive and "
        "reactive), all, or none (default: %(default)s)",
    )
    add(
        "--redraw",
        choices=REDRAWS,
        default=GameStudy.redraw,
        help="which goals are drawn anew when the team scores (default: %(default)s)",
    )
    defaults = {field.name: field.default for field in fields(GameStudy)}
    for name, metavar, text in _OPTIONS:
        add(
            f"--{name.replace('_', '-')}",
            type=float,
            default=defaults[name],
            metavar=metavar,
            help=f"{text} (default: %(default)s)",
        )
    add("--json", action="store_true", help="print one JSON object instead of text")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Play the study, and print what came out."""
    from ppinfer.cli.output import print_json
    from ppinfer.studies.game_performance import game_performance
    from ppsim.reaching import GameStudy

    study = GameStudy(
        **{field.name: getattr(args, field.name) for field in fields(GameStudy) if hasattr(args, field.name)}
    )
    recorded = play_study(study, study.trials, args, "games")
    if recorded is None:
        return 130
    performance = game_performance(recorded.log)
    if args.json:
        print_json(
            {
                "output": str(args.output),
                "games": study.games,
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


def _print(performance: GamePerformance, study: GameStudy, output: Path, resumed: int) -> None:
    from ppinfer.cli.output import print_table
    from ppinfer.studies.game_performance import GAME_METRICS
    from ppsim.cli.intervals import with_sem

    print(f"{output}: {study.trials} games, {study.games} of each robot with each human, seed {study.seed}")
    if resumed:
        print(f"went on from {resumed} games of an interrupted recording")
    titles = ("score", "collisions", "human's changes", "robot's changes", "first score s", "scoreless")

    def told(row: dict[str, Any]) -> list[str]:
        return [
            with_sem(row[name], row[f"{name}_sem"], 3 if name in ("collisions", "scoreless") else 2)
            for name in GAME_METRICS
        ]

    pooled, cells, differences = performance.pooled(), performance.cells(), performance.differences(AGAINST)
    for count in study.goals:
        print_table(
            f"{count} goals, all humans",
            ("robot", *titles),
            [[row["robot"], *told(row)] for row in pooled if row.get("goals", count) == count],
        )
        if len(study.humans) > 1:
            print_table(
                f"{count} goals, by human",
                ("robot", "human", *titles),
                [
                    [row["robot"], row["human"], *told(row)]
                    for row in cells
                    if row.get("goals", count) == count
                ],
            )
        rows = {
            metric: [
                row for row in differences if row["metric"] == metric and row.get("goals", count) == count
            ]
            for metric in ("score", "collisions", "first_score_s")
        }
        if rows["score"]:
            print_table(
                f"{count} goals, paired differences [95 % interval]",
                ("robot", "less", "score", "collisions", "first score s"),
                [
                    [row["robot"], row["against"], *(_difference(rows[metric][at]) for metric in rows)]
                    for at, row in enumerate(rows["score"])
                ],
            )
    print(f"next: ppinfer infer {output} -o POST.nc --model goal-coupled")


def _difference(row: dict[str, Any]) -> str:
    from ppsim.cli.intervals import with_interval

    return with_interval(row["mean"], row["low"], row["high"])
