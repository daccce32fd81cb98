"""The arguments that choose which segments and participants of a posterior count, shared by commands."""

from __future__ import annotations

import argparse

from ppinfer.cli.argument_types import distance, share, whole_number


def add_selection_arguments(parser: argparse.ArgumentParser) -> None:
    """Add ``--min-samples``, ``--min-distance``, ``--participants`` and ``--exclude``."""
    group = parser.add_argument_group("which segments count")
    add_segment_arguments(group)
    add_participant_arguments(group)


def add_segment_arguments(group: argparse._ArgumentGroup) -> None:
    """Add ``--min-samples`` and ``--min-distance``."""
    group.add_argument(
        "--min-samples",
        type=whole_number,
        metavar="N",
        help="segments of at least N samples (never fewer than 3)",
    )
    group.add_argument(
        "--min-distance",
        type=distance,
        metavar="D",
        help="segments that start at least D from their true goal, in the log's units of position",
    )


def add_participant_arguments(group: argparse._ArgumentGroup) -> None:
    """Add ``--participants`` and ``--exclude``."""
    group.add_argument("--participants", nargs="+", metavar="ID", help="these participants only")
    group.add_argument("--exclude", nargs="+", metavar="ID", help="all participants but these")


def add_share_argument(parser: argparse._ActionsContainer) -> None:
    """Add ``--at``, the shares of a segment after which it is scored."""
    parser.add_argument(
        "--at",
        type=share,
        nargs="+",
        default=[0.25, 0.5, 0.75],
        metavar="SHARE",
        help="shares of each segment seen, above 0 and at most 1 (default: 0.25 0.5 0.75)",
    )
