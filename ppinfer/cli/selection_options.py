"""The arguments that choose which segments and participants of a posterior count, shared by commands."""

from __future__ import annotations

import argparse


def add_selection_arguments(parser: argparse.ArgumentParser) -> None:
    """Add ``--min-samples``, ``--min-distance``, ``--participants`` and ``--exclude``."""
    group = parser.add_argument_group("which segments count")
    group.add_argument(
        "--min-samples", type=int, metavar="N", help="segments of at least N samples (never fewer than 3)"
    )
    group.add_argument(
        "--min-distance",
        type=float,
        metavar="D",
        help="segments that start at least D from their true goal, in the log's units of position",
    )
    group.add_argument("--participants", nargs="+", metavar="ID", help="these participants only")
    group.add_argument("--exclude", nargs="+", metavar="ID", help="all participants but these")


def add_share_argument(parser: argparse.ArgumentParser) -> None:
    """Add ``--at``, the shares of a segment after which it is scored."""
    parser.add_argument(
        "--at",
        type=float,
        nargs="+",
        default=[0.25, 0.5, 0.75],
        metavar="SHARE",
        help="shares of each segment seen, above 0 and at most 1 (default: 0.25 0.5 0.75)",
    )
