"""``ppinfer report``: a log or a posterior as one page to read."""

from __future__ import annotations

import argparse
import sys

from ppinfer.cli.model_options import parse_settings
from ppinfer.cli.output import say
from ppinfer.cli.selection_options import add_selection_arguments, add_share_argument

_DESCRIPTION = """\
Write DIR/index.html, one self-contained page, readable without a network; the figures are also written
to DIR/figures. A page that an earlier run wrote to DIR is replaced; other files in it stay.

Every page has the same sections: the data sheet, faults, posteriors, calibration, metrics, tests, and how it
was made. What they hold depends on FILE:

a posterior over goals    its scores, the posterior through some trials, the participants, calibration
a posterior over theta    what was believed of whom, and the posterior through some trials
a log of parallel play    (a robot and a human, each with a task: 'ppsim study') what robots believed, times and
                          safety stops of every robot, paired differences, each Bayesian robot with each human
a log of two agents       (with goals in the plane: 'ppsim reach', 'ppsim record reaching', the reaching study)
  among goals             beliefs about the human's goal with and without the robot, their scores and calibration,
                          candidate trajectories and a risk map, the game's scores
any other log             all paths; where there are goals, the posterior that --model infers, its scores and
                          calibration

FILE may also be a recording (.jsonl) of a running study. Of a log that can be read but is not sound the page has
the data sheet and the faults, and nothing is concluded from it: exit status 1, as of 'ppinfer validate'.
A damaged file is refused.
"""

_EPILOG = """\
examples:
  ppinfer report POST.nc -o report --trials user3_cbp_0 user5_baseline_2
  ppinfer report LOG.nc -o report
  ppinfer report LOG.nc -o report --model MODEL.toml --human pedestrian
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    parser = commands.add_parser(
        "report",
        help="one self-contained page with figures about a log or a posterior",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "file",
        metavar="FILE",
        help="a posterior, as 'ppinfer infer' writes it, a study log (.nc, .zarr) or a recording (.jsonl)",
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
        "in which the robot makes most of a difference; without goals: by their places in the file)",
    )
    who = parser.add_argument_group("of a log")
    who.add_argument(
        "--model",
        metavar="MODEL",
        help="which model infers the goals: a name or a MODEL.toml (default: goal-lqr at its defaults, which nobody "
        "fitted; of two agents among goals it is scored beside the page's own beliefs)",
    )
    who.add_argument(
        "--set",
        nargs="+",
        action="extend",
        default=[],
        metavar="NAME=VALUE",
        dest="settings",
        help="parameters of the model, e.g. rationality=0.01 stay=0.98",
    )
    who.add_argument(
        "--robot", metavar="AGENT", help="which agent is the robot (default: the one called robot)"
    )
    who.add_argument(
        "--human",
        metavar="AGENT",
        help="which agent is the human, whose goals are inferred (default: the one called human)",
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
            args.file,
            args.output,
            trials=args.trials,
            at=args.at,
            min_samples=args.min_samples,
            min_distance=args.min_distance,
            participants=args.participants,
            exclude=args.exclude,
            model=args.model,
            parameters=parse_settings(args.settings),
            robot=args.robot,
            human=args.human,
            progress=progress,
        )
    for warning in report.warnings:
        say(f"ppinfer report: warning: {warning}", file=sys.stderr)
    if args.json:
        print_json(report.to_json())
    else:
        shown = f"; trials: {', '.join(report.trials)}" if report.trials else ""
        figures = len(report.figures)
        say(f"wrote {report.page} ({figures} figure{'s' * (figures != 1)}{shown})")
    return 1 if report.faults else 0
