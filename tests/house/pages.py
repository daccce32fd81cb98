"""Run what a Markdown page shows: commands, Python and files, top to bottom, in a folder of the page's own.

    ```sh                   commands; each must end with status 0 (`sh exit=1`: with 1)
    ```console              `$ command` and what it prints; `...` stands for anything
    ```python               examples with `>>>`, or plain code; one namespace for the whole page
    ```toml name=m.toml     any language: the block is written to that file first
    ```text                 (and every other language) only read; a block without one that holds nothing but
                            our commands is taken for `sh`

The folder holds the repository's `data/`, and the small log once more as `LOG.nc`.

Only `ppinfer` and `ppsim` commands are run, in this process; lines that install, test or belong to other
programs (`OTHERS`) are for `.ci/run`, and any other command is an error, so that nothing shown goes untried.
"""

from __future__ import annotations

import contextlib
import doctest
import importlib
import io
import shlex
import shutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

ROOT = Path(__file__).parents[2]
OTHERS = (
    "python -m pip ",
    "python -m pytest",
    "git ",
    "cd ",
    "ruff ",
    "mypy",
    "lint-imports",
    ".ci/run",
    "jupyter ",
)
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its options, its text, and the line that its text begins on."""

    language: str
    options: dict[str, str]
    text: str
    line: int


@dataclass
class Command:
    """A command line as shown, with the output shown under it where there is any."""

    text: str
    line: int
    shown: list[str] = field(default_factory=list)


def read_blocks(page: Path) -> Iterator[Block]:
    """Yield the fenced blocks of a page."""
    fence: list[str] | None = None
    lines: list[str] = []
    start = 0
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), start=1):
        if not line.startswith("```"):
            lines.append(line)
        elif fence is None:
            fence, lines, start = line[3:].split(), [], number + 1
        else:
            options = dict(part.partition("=")[::2] for part in fence[1:])
            yield Block(fence[0] if fence else "", options, "\n".join(lines) + "\n", start)
            fence = None
    assert fence is None, f"{page.name}:{start - 1}: this block is never closed"


def read_commands(block: Block) -> list[Command]:
    """Return the command lines of a block, lines that end in a backslash joined."""
    commands: list[Command] = []
    continued = False
    for number, line in enumerate(block.text.splitlines(), start=block.line):
        if continued:
            commands[-1].text = commands[-1].text[:-1] + line.strip()
        elif block.language == "console" and not line.startswith("$ "):
            assert commands, f"line {number}: a console block begins with '$ command'"
            commands[-1].shown.append(line)
            continue
        elif line.strip() and not line.startswith("#"):
            commands.append(Command(line.removeprefix("$ ").strip(), number))
        continued = bool(commands) and commands[-1].text.endswith("\\")
    return commands


def run_command(line: str) -> tuple[int, str, str]:
    """Run a `ppinfer` or `ppsim` command in this process; return its status and what it printed."""
    program, *argv = shlex.split(line, comments=True)
    main = importlib.import_module({"ppinfer": "ppinfer.cli", "ppsim": "ppsim.cli"}[program]).main
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = main(argv)
        except SystemExit as stop:
            status = stop.code if isinstance(stop.code, int) else 1
    return int(status), out.getvalue(), err.getvalue()


def run_page(page: Path, folder: Path, monkeypatch: Any) -> int:
    """Run every block of a page in `folder`; return how many blocks and commands were run."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("COLUMNS", "100")
    shutil.copytree(ROOT / "data", folder / "data")
    shutil.copy(ROOT / "data" / "reaching-small.nc", folder / "LOG.nc")
    # a module, because dataclasses and Hypothesis look up the one that a class was defined in
    module = ModuleType("shown_on_page")
    monkeypatch.setitem(sys.modules, module.__name__, module)
    names = vars(module)
    done = 0
    for block in read_blocks(page):
        if "name" in block.options:
            Path(block.options["name"]).write_text(block.text, encoding="utf-8")
        elif block.language in ("sh", "console") or _is_all_commands(block):
            for command in read_commands(block):
                # `a && b` is two commands; a page needs no more of the shell than that
                for part in command.text.split(" && "):
                    done += _run_shown(part, command, block, page.name)
        elif block.language == "python":
            _run_python(block, names, page.name)
            done += 1
    return done


def _is_all_commands(block: Block) -> bool:
    lines = block.text.splitlines()
    return not block.language and all(line.startswith(("ppinfer ", "ppsim ")) for line in lines)


def _run_shown(line: str, command: Command, block: Block, page: str) -> int:
    if line.startswith(OTHERS):
        return 0
    where = f"{page}:{command.line}: {line}"
    assert line.split()[0] in ("ppinfer", "ppsim"), (
        f"{where}\nno test runs this command; see tests/house/pages.py"
    )
    status, out, err = run_command(line)
    wanted = int(block.options.get("exit", 0))
    assert status == wanted, f"{where}\nended with status {status}, not {wanted}\n{out}{err}"
    if block.language == "console":
        shown = "\n".join(command.shown).strip() + "\n"
        printed = "\n".join(text.rstrip() for text in (out + err).splitlines()).strip() + "\n"
        same = doctest.OutputChecker().check_output(shown, printed, FLAGS)
        assert same, f"{where}\nthe page shows\n{shown}\nit prints\n{printed}"
    return 1


def _run_python(block: Block, names: dict[str, Any], page: str) -> None:
    if ">>>" not in block.text:
        code = compile("\n" * (block.line - 1) + block.text, page, "exec")
        exec(code, names)
        return
    examples = doctest.DocTestParser().get_doctest(block.text, names, page, page, block.line - 1)
    report: list[str] = []
    runner = doctest.DocTestRunner(optionflags=FLAGS)
    runner.run(examples, out=report.append, clear_globs=False)
    names.update(examples.globs)
    assert not runner.failures, "".join(report)
