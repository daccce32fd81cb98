"""Commands that play a study and compare its robots: what they ask alike, and playing it so that it can go on."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ppsim.study import Recorded, Study


def add_playing_arguments(parser: argparse.ArgumentParser, trials: str) -> None:
    """Add ``--seed``, ``-o``, ``--workers``, ``--cluster`` and ``--resume``; `trials` is what the world calls them."""
    add = parser.add_argument
    add("--seed", type=int, default=0, metavar="S", help="seed of the study (default: 0)")
    add("-o", "--output", type=Path, required=True, metavar="LOG.nc", help="the log: .nc or .zarr")
    add(
        "--workers",
        type=int,
        default=1,
        metavar="W",
        help="processes; the log does not depend on them (default: 1)",
    )
    add(
        "--cluster",
        metavar="ADDRESS",
        help=f"play the {trials} on a Dask cluster, to the same log (extra: cluster)",
    )
    add(
        "--resume",
        action="store_true",
        help="go on with the recording that an interrupted run left beside the log",
    )


def play_study(study: Study, count: int, args: argparse.Namespace, trials: str) -> Recorded | None:
    """Play a study as these arguments say; None where it was interrupted, which has been told.

    Raises
    ------
    SimulationError
        Where there is nothing to resume, and as `ppsim.study.record_study`.
    """
    from ppinfer.cli.progress import progress_bar
    from ppsim.errors import SimulationError
    from ppsim.study import record_study, recording_path

    path = recording_path(args.output)
    if args.resume and args.output.exists() and not path.exists():
        raise SimulationError(
            f"{args.output}: is there, with no interrupted recording beside it: nothing to resume; leave out "
            "--resume to play it anew"
        )
    try:
        with progress_bar(f"playing {trials}") as progress:
            return record_study(
                study,
                count,
                args.output,
                workers=args.workers,
                cluster=args.cluster,
                resume=args.resume,
                progress=progress,
            )
    except KeyboardInterrupt:
        left = (
            f"the {trials} that ended are in {path}: add --resume to go on"
            if path.exists()
            else "none had ended"
        )
        print(f"ppsim {args.command}: interrupted; {left}", file=sys.stderr)
        return None
