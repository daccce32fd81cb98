"""The `ppsim` command: one module a subcommand, found here by name."""

from __future__ import annotations

import importlib
from collections.abc import Sequence

from ppinfer.cli import OneLineParser, run_command

COMMANDS = ("study", "reach", "watch", "record", "examples", "crossing")


def build_parser() -> OneLineParser:
    """Return the parser of the whole command."""
    from ppinfer import __version__

    parser = OneLineParser(
        prog="ppsim",
        description="Small worlds of two agents whose minds are known, played, watched and recorded as study logs for "
        "ppinfer.",
        epilog="Each command has its own help with examples, e.g. 'ppsim study --help'.",
    )
    parser.add_argument("--version", action="version", version=f"ppsim {__version__}")
    commands = parser.add_subparsers(title="commands", dest="command", metavar="COMMAND", required=True)
    for name in COMMANDS:
        importlib.import_module(f"ppsim.cli.{name}").add_parser(commands)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the `ppsim` command and return its exit status."""
    return run_command(build_parser(), argv)
