"""A progress bar for long loops: on a terminal only, and never on standard output."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    # what reads logs is loaded with that package
    from ppinfer.studies.progress import ProgressCallback


@contextmanager
def progress_bar(description: str) -> Iterator[ProgressCallback]:
    """Yield a callback ``(done, total)`` that draws a bar on stderr when that is a terminal.

    Examples
    --------
    >>> with progress_bar("inferring") as report:
    ...     report(1, 2)
    """
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(description, total=None)

        def update(done: int, total: int, /) -> None:
            bar.update(task, completed=done, total=total)

        yield update
