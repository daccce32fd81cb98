"""``ppinfer convert``: other formats in, a checked study log out."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from ppinfer.cli.output import say

READER_NAMES = ("reaching-study", "eth", "tidy", "recording")

_DESCRIPTION = """\
Convert a study to a study log: NetCDF4 (.nc) or, for very large ones, Zarr (.zarr).
Everything wrong with the source is listed at once, and then nothing is written.

  reaching-study  the folder of the 2023 reaching study (trials/*.npz, segments.csv)
  eth             an ETH/BIWI folder (obsmat.txt, destinations.txt)
  tidy            a CSV or Parquet table; --mapping says what its columns are
  recording       a JSON-lines recording of a running study
"""

_EPILOG = """\
examples:
  ppinfer convert reaching-study -o reaching.nc --from reaching-study
  ppinfer convert reaches.csv -o reaches.nc --from tidy --mapping reaches.toml

a mapping, reaches.toml (all of it is in docs/log-format.md):
  [columns]
  trial = "game_id"
  participant = "subject"
  time = "t_ms"
  x = "px"
  y = "py"
  true_goal = "heads_for"

  [constants]
  agent = "human"

  [units]
  time = "ms"
  position = "cm"

  [goals]
  cup = [10.0, 42.5]
  pan = [-12.0, 40.0]
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    parser = commands.add_parser(
        "convert",
        help="make a study log from other formats",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("source", metavar="SOURCE", type=Path, help="the file or folder to read")
    parser.add_argument(
        "-o", "--output", metavar="LOG.nc", type=Path, required=True, help="the log: .nc or .zarr"
    )
    parser.add_argument("--from", dest="reader", choices=READER_NAMES, required=True, help="what SOURCE is")
    parser.add_argument("--mapping", metavar="M.toml", type=Path, help="what the columns are (only for tidy)")
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Convert, and say what came of it."""
    from ppinfer.cli.output import print_json
    from ppinfer.cli.progress import progress_bar
    from ppinfer.studies.faults import FaultyLogError
    from ppinfer.studies.readers import read_study
    from ppinfer.studies.storage import check_target, write_log
    from ppinfer.studies.validation import validate_log

    check_target(args.output)
    try:
        with progress_bar("reading") as progress:
            log = read_study(args.source, args.reader, mapping=args.mapping, progress=progress)
        with progress_bar("checking samples") as progress:
            report = validate_log(log, progress=progress)
        report.raise_if_faulty()
    except FaultyLogError as error:
        total = sum(error.counts.values())
        counted = "1 fault" if total == 1 else f"{total} faults"
        say(f"ppinfer convert: {args.source}: {counted}; nothing was written", file=sys.stderr)
        for line in error.lines:
            say(line, file=sys.stderr)
        return 1
    write_log(log, args.output, validate=False)
    summary: dict[str, Any] = {
        "output": str(args.output),
        "source": str(args.source),
        "reader": args.reader,
        "trials": log.sizes["trial"],
        "samples": log.sizes["sample"],
        "participants": len(set(log["participant"].values.tolist())),
        "segments": log.sizes.get("segment", 0),
        "agents": log["agent"].values.tolist(),
        "goals": log["goal"].values.tolist() if "goal" in log.coords else [],
        "notes": [line for line in str(log.attrs.get("notes", "")).split("\n") if line],
        "warnings": [str(warning) for warning in report.warnings],
        "warning_counts": report.warning_counts,
    }
    if args.json:
        print_json(summary)
    else:
        _print_summary(summary)
    return 0


def _print_summary(summary: dict[str, Any]) -> None:
    counts = [(summary[name], name) for name in ("trials", "samples", "participants", "segments")]
    told = ", ".join(f"{count} {name.removesuffix('s') if count == 1 else name}" for count, name in counts)
    say(f"{summary['output']}: {told}")
    say(f"agents: {', '.join(summary['agents'])}; goals: {', '.join(summary['goals']) or 'none'}")
    for note in summary["notes"]:
        say(f"note: {note}")
    for warning in summary["warnings"]:
        say(f"warning: {warning}")
