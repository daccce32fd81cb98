"""`ppsim record`: worlds that record study logs whose goals are known."""

from __future__ import annotations

import argparse
import sys
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ppsim.study import Recorded

_REACHING = """\
Record a simulated reaching study: a human and a robot, both noisily rational LQR agents, among goals
in a workspace of +-10 m. When both are within 0.5 m of distinct goals the team scores 2 points and the
goals are drawn anew. The log holds both agents, the goals, the segments with their true goals, and the
true parameters in its configuration.

Trials are appended to LOG.recording.jsonl as they end, which becomes LOG.nc at the end. If that is
interrupted, the same command continues it. Trial i depends on the seed and on i only.
"""

_REACHING_EPILOG = """\
examples:
  ppsim record reaching --trials 24 --seed 7 -o LOG.nc
  ppsim record reaching --trials 60 --seed 1 --noise 0.03 --dropouts 0.02 --outliers 0.002 -o LOG.nc
  ppsim record reaching --trials 1000 --seed 2 --dynamics single-integrator --workers 4 -o LOG.zarr
"""

# option: (field of ReachingStudy, metavar, help); defaults and types are the field's
_OPTIONS = (
    ("seed", "S", "seed of the study"),
    ("participants", "P", "how many take part, in turn"),
    ("goals", "N", "goals at a time"),
    ("separation", "M", "least distance between two goals, m"),
    ("duration", "S", "length of a trial, s"),
    ("dt", "S", "time between samples, s"),
    ("dynamics", "NAME", "double-integrator (actions are accelerations) or single-integrator (velocities)"),
    ("rationality", "BETA", "the human's inverse temperature, 1/cost: the median of the participants"),
    ("rationality_spread", "SD", "standard deviation of its logarithm over participants; 0: all alike"),
    ("robot_rationality", "BETA", "the robot's inverse temperature"),
    (
        "control_weight",
        "R",
        "weight of the control in both agents' costs, where a metre off the goal weighs 1",
    ),
    (
        "human",
        "CHOICE",
        "how the human chooses goals: near-goal (near ones are likelier), nearest-goal or random-goal",
    ),
    ("robot", "CHOICE", "how the robot does; it leaves a goal to the human who is at it"),
    ("stay", "P", "probability per sample that the human's goal stays what it is"),
    ("noise", "SD", "measurement noise of the logged positions, m"),
    ("dropouts", "SHARE", "share of samples at which an agent is not seen"),
    ("outliers", "SHARE", "share of samples whose position is anywhere"),
)


def add_parser(commands: argparse._SubParsersAction[Any]) -> None:
    """Add ``record`` and its worlds."""
    record = commands.add_parser("record", help="simulate a study of one world and write its log")
    worlds = record.add_subparsers(title="worlds", dest="world", metavar="WORLD", required=True)
    _add_reaching(worlds)


def _add_reaching(worlds: argparse._SubParsersAction[Any]) -> None:
    from ppsim.reaching import ReachingStudy

    parser = worlds.add_parser(
        "reaching",
        help="two agents among goals",
        description=_REACHING,
        epilog=_REACHING_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--trials", type=int, required=True, metavar="N", help="how many trials")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="LOG.nc", help="the log: .nc or .zarr"
    )
    defaults = {field.name: field.default for field in fields(ReachingStudy)}
    for name, metavar, text in _OPTIONS:
        parser.add_argument(
            f"--{name.replace('_', '-')}",
            type=type(defaults[name]),
            default=defaults[name],
            metavar=metavar,
            help=f"{text} (default: %(default)s)",
        )
    parser.add_argument(
        "--positions-only",
        action="store_true",
        help="leave out velocities and controls, which are logged only where there is no noise",
    )
    parser.add_argument(
        "--workers",
        type=int,
        default=1,
        metavar="W",
        help="processes; the log is the same for any number (default: 1)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")
    parser.set_defaults(run=run_record_reaching)


def run_record_reaching(args: argparse.Namespace) -> int:
    """Record a reaching study, and say what is in it."""
    from ppinfer.cli.output import print_json
    from ppinfer.cli.progress import progress_bar
    from ppsim.reaching import ReachingStudy
    from ppsim.study import record_study, recording_path

    study = ReachingStudy(**{field.name: getattr(args, field.name) for field in fields(ReachingStudy)})
    path = recording_path(args.output)
    try:
        with progress_bar("recording trials") as progress:
            recorded = record_study(study, args.trials, args.output, workers=args.workers, progress=progress)
    except KeyboardInterrupt:
        print(
            f"ppsim record: interrupted; the trials that ended are in {path}: run the same command to go on, or "
            f"'ppinfer convert {path} -o {args.output} --from recording' to keep what there is",
            file=sys.stderr,
        )
        return 130
    summary = _summary(recorded, args.output)
    if args.json:
        print_json(summary)
    else:
        _print_summary(summary)
    return 0


def _summary(recorded: Recorded, output: Path) -> dict[str, Any]:
    import json

    log = recorded.log
    agents = [str(agent) for agent in log["agent"].values]
    moved_by = log["segment_agent"].values.astype(str)
    return {
        "output": str(output),
        "world": "reaching",
        "trials": log.sizes["trial"],
        "trials_resumed": recorded.resumed,
        "samples": log.sizes["sample"],
        "participants": len(set(log["participant"].values.tolist())),
        "goals": log.sizes["goal"],
        "segments": {agent: int((moved_by == agent).sum()) for agent in agents},
        "mean_score": float(log["team_score"].values.mean()),
        "collisions": int(log["collision"].values.sum()),
        "samples_missing": int((log["observed"].values == 0).sum()),
        "configuration": json.loads(log.attrs["configuration"]),
    }


def _print_summary(summary: dict[str, Any]) -> None:
    segments = ", ".join(f"{count} of the {agent}" for agent, count in summary["segments"].items())
    print(
        f"{summary['output']}: {summary['trials']} trials of {summary['participants']} participants, "
        f"{summary['samples']} samples"
    )
    if summary["trials_resumed"]:
        print(f"went on from {summary['trials_resumed']} trials of an interrupted recording")
    print(f"segments: {segments}; goals: {summary['goals']}")
    print(f"mean score {summary['mean_score']:.1f}, collisions {summary['collisions']}")
    print(f"next: ppinfer infer {summary['output']} -o POST.nc --model goal-lqr")
