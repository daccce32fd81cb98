"""``ppinfer report``: a posterior, or a log of two agents, as one page to read."""

from __future__ import annotations

import argparse
import sys

from ppinfer.cli.selection_options import add_selection_arguments, add_share_argument

_DESCRIPTION = """\
Write DIR/index.html, one self-contained page, readable without a network; the figures are also written
to DIR/figures. A page that an earlier run wrote to DIR is replaced; other files in it stay.

of a posterior over goals   what it is, its scores, the posterior over time beside the paths of some trials,
                            calibration, accuracy against the share of the path seen, and the participants
of a log of parallel play   (a robot and a human, each with a task: 'ppsim study' writes such logs) times and
                            safety stops of every robot, paired differences, each Bayesian robot against each
                            human, what robots believed of whom, the posterior over theta through some trials
of a posterior over theta   what was believed of whom, and the posterior through some trials
of a log of two agents      (with goals in the plane: 'ppsim reach' and 'ppsim record reaching' write such, and the
  among goals               reaching study is one) the game's scores, the belief about the human's goal with and without
                            the robot through some interactions, beside those held live, the scores of all of
                            them, candidate trajectories and a risk map
"""

_EPILOG = """\
examples:
  ppinfer report POST.nc -o report --trials user3_cbp_0 user5_baseline_2
  ppinfer report LOG.nc -o report
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    parser = commands.add_parser(
        "report",
        help="one self-contained page with figures about a posterior or a log of two agents",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "posterior",
        metavar="POST.nc",
        help="a posterior, as 'ppinfer infer' writes it, or a log of two agents",
    )
    parser.add_argument(
        "-o", "--output", required=True, metavar="DIR", help="the folder that the page goes to"
    )
    parser.add_argument(
        "--trials",
        nargs="+",
        metavar="ID",
        help="trials to show (default: goals: the best, a typical and the worst scored one; theta: those whose belief "
        "is the highest, the lowest and changes most, and that with most safety stops; two agents among goals: those "
        "in which the robot makes most of a difference)",
    )
    add_share_argument(parser)
    add_selection_arguments(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object about what was written")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Write the page and say where it is."""
    from ppinfer.cli.output import print_json
    from ppinfer.cli.progress import progress_bar
    from ppinfer.report import write_report

    with progress_bar("drawing") as progress:
        report = write_report(
            args.posterior,
            args.output,
            trials=args.trials,
            at=args.at,
            min_samples=args.min_samples,
            min_distance=args.min_distance,
            participants=args.participants,
            exclude=args.exclude,
            progress=progress,
        )
    for warning in report.warnings:
        print(f"ppinfer report: warning: {warning}", file=sys.stderr)
    if args.json:
        print_json(report.to_json())
    else:
        print(f"wrote {report.page} ({len(report.figures)} figures; trials: {', '.join(report.trials)})")
    return 0
