"""``ppinfer compare``: several posteriors on the same segments."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from ppinfer.cli.argument_types import whole_number
from ppinfer.cli.output import say
from ppinfer.cli.selection_options import add_selection_arguments, add_share_argument

if TYPE_CHECKING:
    from ppinfer.studies.comparison import Comparison

_DESCRIPTION = """\
Compare posteriors of the same trials, segment by segment: the accuracy and the mean log posterior of
the true goal of each, and for every posterior after the first its paired difference from the first
(positive = better than the first), with 95 % intervals by resampling participants.
"""

_EPILOG = """\
example:
  ppinfer compare nearest.nc lqr.nc --at 0.25 0.5 0.75 --min-samples 8
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    parser = commands.add_parser(
        "compare",
        help="paired differences between posteriors on the same segments",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("first", metavar="POST1.nc", help="the posterior that the others are compared with")
    parser.add_argument("others", nargs="+", metavar="POST2.nc", help="posteriors of the same trials")
    add_share_argument(parser)
    add_selection_arguments(parser)
    parser.add_argument(
        "--common",
        action="store_true",
        help="compare the segments that all share, instead of refusing others",
    )
    parser.add_argument(
        "--resamples", type=int, default=10_000, metavar="R", help="resamples (default: 10000)"
    )
    parser.add_argument(
        "--seed", type=whole_number, default=0, metavar="S", help="seed of the resamples (default: 0)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of tables")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Compare the posteriors and print the result."""
    from ppinfer.cli.output import print_json
    from ppinfer.errors import LogError
    from ppinfer.studies.comparison import compare_posteriors
    from ppinfer.studies.posterior import open_posterior

    paths = [args.first, *args.others]
    repeated = sorted({path for path in paths if paths.count(path) > 1})
    if repeated:
        raise LogError(f"{repeated[0]} is given {paths.count(repeated[0])} times; give each posterior once")
    with ExitStack() as files:
        comparison = compare_posteriors(
            {path: files.enter_context(open_posterior(path, verify=True)) for path in paths},
            at=args.at,
            min_samples=args.min_samples,
            min_distance=args.min_distance,
            participants=args.participants,
            exclude=args.exclude,
            common_only=args.common,
            resamples=args.resamples,
            seed=args.seed,
        )
    for warning in comparison.warnings:
        say(f"ppinfer compare: warning: {warning}", file=sys.stderr)
    if args.json:
        print_json(comparison.to_json())
    else:
        print_comparison(comparison)
    return 0


def print_comparison(comparison: Comparison) -> None:
    """Print tables for people."""
    from ppinfer.cli.output import print_table
    from ppinfer.studies.segment_selection import describe_left_out

    first = comparison.differences[0]
    names = _short_names([first.against, *(each.name for each in comparison.differences)])
    print_table(
        f"scores on the same {first.segments} segments of {first.participants} participants",
        ("posterior", "seen", "accuracy", "mean log posterior"),
        [
            (names[each.name], f"{each.at:.4g}", f"{each.accuracy:.3f}", f"{each.mean_log_posterior:.3f}")
            for each in comparison.scores
        ],
    )
    print_table(
        f"differences from {names[first.against]} (95 % interval over participants)",
        ("posterior", "seen", "accuracy", "mean log posterior"),
        [
            (
                names[each.name],
                f"{each.at:.4g}",
                _with_interval(each.accuracy, each.accuracy_low, each.accuracy_high),
                _with_interval(
                    each.mean_log_posterior, each.mean_log_posterior_low, each.mean_log_posterior_high
                ),
            )
            for each in comparison.differences
        ],
    )
    if left_out := describe_left_out(comparison.left_out):
        say(left_out)


def _short_names(paths: list[str]) -> dict[str, str]:
    # file names are enough unless two folders hold one of the same name
    distinct = dict.fromkeys(paths)
    files = [Path(path).name for path in distinct]
    return {
        path: name if files.count(name) == 1 else path for path, name in zip(distinct, files, strict=True)
    }


def _with_interval(value: float, low: float, high: float) -> str:
    # NaN is the interval of a single participant, or of a mean that is infinite
    return f"{value:+.3f}" if low != low else f"{value:+.3f} [{low:+.3f}, {high:+.3f}]"
