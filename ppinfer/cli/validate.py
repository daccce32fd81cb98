"""``ppinfer validate``: is this log sound? Every fault at once, each with where it is and what to do."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ppinfer.cli.output import say
from ppinfer.errors import LogError, printable

_DESCRIPTION = """\
Check a study log (.nc, .zarr), a recording (.jsonl) or a posterior: structure, types, checksums,
times, positions, goals and segments. Exit status 0 when it is sound, 1 with the list of faults.
Warnings (implausible jumps) leave it sound.
"""

_EPILOG = """\
example:
  ppinfer validate LOG.nc --json
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    parser = commands.add_parser(
        "validate",
        help="check a study log, and list everything wrong with it",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("log", metavar="LOG", type=Path, help="a study log, a recording or a posterior")
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Validate and print what was found."""
    from ppinfer.cli.output import print_json

    found = _found(args.log)
    report = found["report"]
    if args.json:
        print_json(report)
        return 0 if report["ok"] else 1
    counts = [
        (report["sizes"][name], name)
        for name in ("trial", "sample", "segment", "replan")
        if name in report["sizes"]
    ]
    sizes = ", ".join(f"{count} {name}{'s' if count != 1 else ''}" for count, name in counts)
    faults, warnings = sum(report["fault_counts"].values()), sum(report["warning_counts"].values())
    verdict = "sound" if report["ok"] else f"{faults} fault{'s' if faults != 1 else ''}"
    if warnings:
        verdict += f", {warnings} warning{'s' if warnings != 1 else ''}"
    say(printable(f"{report['source']}: {verdict}" + (f" ({sizes})" if sizes else "")))
    for line in found["lines"]:
        say(line)
    return 0 if report["ok"] else 1


def _found(log: Path) -> dict[str, Any]:
    """Return what `Report.told` does; what reads logs is loaded here only where the other process cannot be asked."""
    from ppinfer.cli.progress import progress_bar
    from ppinfer.guarding import asked

    with progress_bar("checking samples") as progress:
        try:
            told: dict[str, Any] | None = asked("validate-file", log, progress=progress)
        except LogError as error:
            from ppinfer.studies.file_checks import unreadable_report

            return unreadable_report(log, error).told()
        if told is None:
            from ppinfer.studies.file_checks import validate_file

            told = validate_file(log, progress=progress).told()
    return told
