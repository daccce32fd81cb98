"""The `ppinfer` command: one module a subcommand, found here by name."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

from ppinfer.errors import PPInferError, printable
from ppinfer.guarding import start_early

COMMANDS = (
    "convert",
    "validate",
    "fit",
    "infer",
    "score",
    "compare",
    "metrics",
    "survey",
    "anova",
    "report",
    "learn",
    "notebooks",
)


class OneLineParser(argparse.ArgumentParser):
    """An argument parser whose complaint is a single line on stderr (exit status 2)."""

    def error(self, message: str) -> NoReturn:
        """Print what is wrong with the arguments and where help is, then exit with status 2."""
        if message.startswith("the following arguments are required"):
            message += "; flags that take several values take all that follow, so put files first"
        self.exit(2, f"{self.prog}: {message} (see '{self.prog} --help')\n")


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command, every subcommand included."""
    from ppinfer import __version__

    parser = OneLineParser(
        prog="ppinfer",
        description="Posteriors over what two agents in a shared workspace will do next, from logs of how they moved.",
        epilog="Each command has its own help with an example, e.g. 'ppinfer infer --help'.",
    )
    parser.add_argument("--version", action="version", version=f"ppinfer {__version__}")
    commands = parser.add_subparsers(title="commands", dest="command", metavar="COMMAND", required=True)
    for name in COMMANDS:
        importlib.import_module(f"ppinfer.cli.{name}").add_parser(commands)
    return parser


def run_command(parser: argparse.ArgumentParser, argv: Sequence[str] | None) -> int:
    """Parse, run, and turn every failure into one line on stderr and a non-zero status.

    ``PPINFER_DEBUG=1`` in the environment lets the traceback through.
    """
    args = parser.parse_args(argv)
    prefix = f"{parser.prog} {args.command}"
    try:
        # the process that reads files from elsewhere gets ready while the command loads what it needs
        start_early(*_values(args))
        status: int = args.run(args)
    except BrokenPipeError:
        # the reader of our output has gone (for example `| head`); Python must not complain at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print(f"{prefix}: interrupted", file=sys.stderr)
        return 130
    except Exception as error:
        if os.environ.get("PPINFER_DEBUG"):
            raise
        print(f"{prefix}: {printable(describe(error))}", file=sys.stderr)
        return 1
    return status


def _values(args: argparse.Namespace) -> list[object]:
    given: list[object] = []
    for value in vars(args).values():
        given.extend(value if isinstance(value, list | tuple) else [value])
    return given


def describe(error: Exception) -> str:
    """Say in one line what an exception means for the person at the terminal."""
    text = " ".join(str(error).split())
    if isinstance(error, PPInferError):
        return text
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror or text}"
    if isinstance(error, MemoryError):
        return "out of memory; process fewer trials at a time"
    return f"unexpected {type(error).__name__}: {text} (set PPINFER_DEBUG=1 for the traceback, and please report it)"


def main(argv: Sequence[str] | None = None) -> int:
    """Run the `ppinfer` command and return its exit status."""
    return run_command(build_parser(), argv)
