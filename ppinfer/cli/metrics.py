"""``ppinfer metrics``: what each trial of a log came to, by condition, between conditions and over rounds."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

from ppinfer.cli.argument_types import distance, whole_number
from ppinfer.cli.output import say

if TYPE_CHECKING:
    from ppinfer.studies.metrics import TrialMetrics

_DESCRIPTION = """\
Measure every trial of a study log: times, stops and failures where robot and human each have a task; points,
collisions, picks and changes of goal where they pick goals; paths, speeds, and the fluency of the two (idle
time, concurrent activity, functional delay). What the log cannot say is left out, and said.

Means are over participants, each of them by the mean of its own trials, with standard errors (SEM) and 95 %
bootstrap intervals over participants; differences are paired, participant by participant.
"""

_EPILOG = """\
examples:
  ppinfer metrics LOG.nc --by condition
  ppinfer metrics LOG.nc --names score collisions --by condition --learning-by condition -o trials.csv
"""

# groups that are columns of one table; more have a row each
_SIDE_BY_SIDE = 6


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    parser = commands.add_parser(
        "metrics",
        help="times, scores, collisions, idle time ... of every trial, by condition and over rounds",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("log", metavar="LOG", help="a study log (.nc, .zarr) or a recording (.jsonl)")
    parser.add_argument(
        "-o", "--output", metavar="TABLE.csv", help="also write a table with a row for each trial"
    )
    parser.add_argument(
        "--by",
        metavar="COLUMN",
        help="what trials are grouped by: condition, participant, round, robot_controller, ... (default: not at all)",
    )
    parser.add_argument(
        "--names", nargs="+", metavar="NAME", help="these metrics only (default: all that the log can give)"
    )
    parser.add_argument(
        "--learning-by",
        metavar="COLUMN",
        help="also means by round, and slopes over rounds, in each group of trials of this column",
    )
    parser.add_argument(
        "--learning-over",
        metavar="COLUMN",
        help="what rounds are counted by: a column of whole numbers, or 'order', that of a participant's trials in a "
        "group (default: round where it changes within a group, else order)",
    )
    who = parser.add_argument_group("who is who, and who is idle")
    who.add_argument("--robot", metavar="AGENT", help="the robot's label in the log (default: robot)")
    who.add_argument(
        "--human", metavar="AGENT", help="the human's label in the log (default: human, or the only agent)"
    )
    who.add_argument(
        "--idle",
        choices=("auto", "flags", "motion"),
        default="auto",
        help="where idleness is taken from: the log's flags is_AGENT_waiting, motion, or flags where the log has some "
        "for both that change (default: auto)",
    )
    who.add_argument(
        "--idle-speed",
        type=distance,
        metavar="V",
        help="by motion, an agent that is seen is idle up to this speed, in the log's units of position a second "
        "(default: a tenth of the 95th percentile of its speeds in the log)",
    )
    parser.add_argument(
        "--resamples", type=whole_number, default=10_000, metavar="R", help="resamples (default: 10000)"
    )
    parser.add_argument(
        "--seed", type=whole_number, default=0, metavar="S", help="seed of the resamples (default: 0)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of tables")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Measure the log, write the table, and print the result."""
    from ppinfer.cli.output import print_json
    from ppinfer.cli.progress import progress_bar
    from ppinfer.cli.targets import check_output
    from ppinfer.errors import LogError, printable
    from ppinfer.studies.csv_writing import write_csv
    from ppinfer.studies.metrics import trial_metrics

    if args.learning_over and not args.learning_by:
        raise LogError("--learning-over says what rounds are counted by; give --learning-by too")
    if args.output:
        check_output(args.output, suffix=".csv", inputs=[args.log])
    with progress_bar("measuring") as progress:
        metrics = trial_metrics(
            args.log,
            names=args.names,
            robot=args.robot,
            human=args.human,
            idle=args.idle,
            idle_speed=args.idle_speed,
            progress=progress,
        )
    found = metrics.to_json(
        args.by,
        learning_by=args.learning_by,
        learning_over=args.learning_over,
        resamples=args.resamples,
        seed=args.seed,
    )
    found["output"] = args.output
    if args.output:
        write_csv(args.output, metrics.table())
    for warning in found["warnings"]:
        say(f"ppinfer metrics: warning: {printable(warning)}", file=sys.stderr)
    if args.json:
        print_json(found)
    else:
        print_metrics(args.log, metrics, found)
    return 0


def print_metrics(path: str, metrics: TrialMetrics, found: dict[str, Any]) -> None:
    """Print tables for people."""
    from ppinfer.cli.output import print_table

    units = {metric.name: metric.units for metric in metrics.metrics}
    people = len(set(metrics.participant.tolist()))
    by = found["by"]
    title = f"{path}: {len(metrics.values):,} trials of {people:,} participants (mean ± SEM over participants"
    groups = list(dict.fromkeys(row["group"] for row in found["groups"]))
    if by and 1 < len(groups) <= _SIDE_BY_SIDE:
        cells = {(row["metric"], row["group"]): row for row in found["groups"]}
        print_table(
            f"{title}, by {by})",
            ("metric", *groups, "units"),
            [
                (
                    name,
                    *(
                        _with_error(row["mean"], row["sem"]) if row else ""
                        for row in _across(cells, name, groups)
                    ),
                    units[name],
                )
                for name in dict.fromkeys(row["metric"] for row in found["groups"])
            ],
        )
    else:
        print_table(
            f"{title}, {100 * found['options']['level']:g} % bootstrap interval)",
            ("metric", *([str(by)] if by else []), "mean", "interval", "units", "participants", "trials"),
            [
                (
                    row["metric"],
                    *([row["group"]] if by else []),
                    _with_error(row["mean"], row["sem"]),
                    _interval(row["low"], row["high"]),
                    units[row["metric"]],
                    str(row["participants"]),
                    str(row["trials"]),
                )
                for row in found["groups"]
            ],
        )
    if found["differences"]:
        print_table(
            f"differences by {by}, paired over participants",
            ("metric", "difference", "mean", "interval", "participants"),
            [
                (
                    row["metric"],
                    f"{row['a']} - {row['b']}",
                    _with_error(row["mean"], row["sem"]),
                    _interval(row["low"], row["high"]),
                    str(row["participants"]),
                )
                for row in found["differences"]
            ],
        )
    if found["learning"]:
        over = found["options"]["learning_over"]
        counted = "the order of a participant's trials" if over == "order" else over
        print_table(
            f"learning by {found['options']['learning_by']}: slopes over {counted} (95 % t interval over participants)",
            ("metric", "group", "first", "last", "slope", "interval", "p", "participants"),
            [
                (
                    row["metric"],
                    row["group"],
                    *(_with_error(end["mean"], end["sem"]) for end in _ends(row["rounds"])),
                    _with_error(row["slope"], row["sem"]),
                    _interval(row["low"], row["high"]),
                    _number(row["p"], ".3f"),
                    str(row["participants"]),
                )
                for row in found["learning"]
            ],
        )
    if found["not_available"]:
        say(f"not in this log: {', '.join(found['not_available'])}")
    if found["output"]:
        say(f"{found['output']}: {len(metrics.values):,} trials, {len(metrics.names)} metrics")


def _across(
    cells: dict[tuple[str, str], dict[str, Any]], name: str, groups: list[str]
) -> list[dict[str, Any] | None]:
    return [cells.get((name, group)) for group in groups]


def _ends(rounds: list[dict[str, Any]]) -> list[dict[str, Any]]:
    nothing = {"mean": float("nan"), "sem": float("nan")}
    return [rounds[0], rounds[-1]] if rounds else [nothing, nothing]


def _number(value: float, form: str = ".4g") -> str:
    return "" if value != value else f"{value:{form}}"


def _with_error(value: float, error: float) -> str:
    return f"{_number(value)} ± {_number(error, '.2g')}" if error == error else _number(value)


def _interval(low: float, high: float) -> str:
    return f"[{_number(low)}, {_number(high)}]" if low == low else ""
