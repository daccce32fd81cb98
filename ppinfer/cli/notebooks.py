"""``ppinfer notebooks``: a folder of one's own with the notebooks and their data, opened in JupyterLab."""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

from ppinfer.cli.output import say

DEFAULT_FOLDER = "ppinfer-notebooks"

_DESCRIPTION = """\
Copy ppinfer's notebooks to DIR/notebooks and the small logs that they read to DIR/data, and start JupyterLab
there. A copy that you changed is yours: it is named and kept, and JupyterLab opens on it (--force replaces it).
"""

_EPILOG = """\
examples:
  ppinfer notebooks
  ppinfer notebooks my-notebooks --copy-only
  ppinfer notebooks --no-browser --lab-options --port 8899
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    parser = commands.add_parser(
        "notebooks",
        help="copy the notebooks and start JupyterLab",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "folder",
        nargs="?",
        type=Path,
        default=Path(DEFAULT_FOLDER),
        metavar="DIR",
        help=f"the folder to copy to and to open (default: {DEFAULT_FOLDER})",
    )
    parser.add_argument("--list", action="store_true", help="say which notebooks there are, and copy nothing")
    parser.add_argument("--copy-only", action="store_true", help="copy, and start nothing")
    parser.add_argument(
        "--no-browser",
        action="store_true",
        help="start JupyterLab, and open no browser: it prints the address",
    )
    parser.add_argument("--force", action="store_true", help="replace copies that you changed")
    parser.add_argument(
        "--lab-options",
        nargs=argparse.REMAINDER,
        default=[],
        metavar="OPTION",
        help="all that follows is handed to JupyterLab, e.g. --port 8899",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object about what was copied")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """List, or copy and start JupyterLab."""
    from ppinfer.cli.notebook_copies import MISSING, Copy, copy_notebooks, shipped_folder, shipped_notebooks
    from ppinfer.cli.output import print_json, print_table
    from ppinfer.errors import PPInferError

    notebooks = shipped_notebooks(shipped_folder())
    copies: tuple[Copy, ...] = ()
    if not args.list:
        if not args.copy_only and not _installed("jupyterlab"):
            raise PPInferError(MISSING)
        copies = copy_notebooks(args.folder, force=args.force)
    if args.json:
        print_json(
            {
                "folder": None if args.list else str(args.folder),
                "notebooks": [
                    {"file": each.copy, "title": each.title, "asks": each.asks, "needs": each.needs or None}
                    for each in notebooks
                ],
                "files": [{"path": each.path, "fate": each.fate} for each in copies],
            }
        )
    elif args.list:
        print_table(
            "notebooks",
            ("notebook", "asks"),
            [
                (each.title, each.asks + (f" (needs {each.needs})" if each.needs else ""))
                for each in notebooks
            ],
        )
    else:
        new = sum(each.fate in ("copied", "updated") for each in copies)
        say(f"{args.folder}: {len(notebooks)} notebooks with their data, {new} of {len(copies)} files new")
    kept = [each.path for each in copies if each.fate == "kept"]
    if kept:
        say(
            f"ppinfer notebooks: kept as you changed them: {', '.join(kept)} (--force replaces them)",
            file=sys.stderr,
        )
    if args.list or args.copy_only:
        return 0
    # a start that waits for a browser is not to hold back what was printed
    sys.stdout.flush()
    return _start(args.folder, [*(["--no-browser"] if args.no_browser else []), *args.lab_options])


def _installed(module: str) -> bool:
    from importlib.util import find_spec

    return find_spec(module) is not None


def _start(folder: Path, options: list[str]) -> int:
    """Run JupyterLab in the folder until it ends, and return its exit status."""
    command = [
        *(sys.executable, "-m", "jupyterlab"),
        f"--notebook-dir={folder.resolve()}",
        "--LabApp.default_url=/lab/tree/notebooks",
        *options,
    ]
    with subprocess.Popen(command) as lab:
        while True:
            try:
                return lab.wait()
            except KeyboardInterrupt:
                # Ctrl-C reaches JupyterLab too, which asks whether to stop: it is the one to end first
                continue
