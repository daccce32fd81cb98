"""The folder of a report: written whole, and only over what an earlier report left there."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path

from ppinfer.errors import LogError
from ppinfer.report.figures import ReportFigure
from ppinfer.studies.replacing import temporary_beside

GENERATOR = "ppinfer report"
_MANIFEST = "ppinfer-report.json"


def refuse_foreign_folder(directory: Path) -> None:
    """Raise `LogError` if the folder is a file, or holds an index.html that is not ours."""
    if directory.exists() and not directory.is_dir():
        raise LogError(f"{directory}: is a file; a report is a folder, choose another name")
    page = directory / "index.html"
    if (
        page.exists()
        and f'content="{GENERATOR}"' not in page.read_text(encoding="utf-8", errors="replace")[:2000]
    ):
        raise LogError(f"{page}: was not written by ppinfer report and stays as it is; choose another folder")


def write_folder(directory: Path, page: str, figures: Sequence[ReportFigure]) -> None:
    """Write the page and its figures beside the folder first, then move them in.

    A new folder appears whole. In an existing one the files of an earlier report are replaced, and removed
    where this one has no such figure; everything else stays.
    """
    refuse_foreign_folder(directory)
    directory.parent.mkdir(parents=True, exist_ok=True)
    with temporary_beside(directory) as staged:
        (staged / "figures").mkdir(parents=True)
        names = [figure.name for figure in figures]
        for figure in figures:
            (staged / "figures" / figure.name).write_bytes(figure.png)
        (staged / "figures" / _MANIFEST).write_text(json.dumps(names) + "\n", encoding="utf-8")
        (staged / "index.html").write_text(page, encoding="utf-8")
        if not directory.exists():
            os.rename(staged, directory)
            return
        (directory / "figures").mkdir(exist_ok=True)
        for name in _earlier_figures(directory):
            if name not in names:
                (directory / "figures" / name).unlink(missing_ok=True)
        for name in (*names, _MANIFEST):
            os.replace(staged / "figures" / name, directory / "figures" / name)
        os.replace(staged / "index.html", directory / "index.html")


def _earlier_figures(directory: Path) -> list[str]:
    try:
        names = json.loads((directory / "figures" / _MANIFEST).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return []
    # a manifest is a file like any other: only plain names of pictures in this folder are taken from it
    return [
        name for name in names if isinstance(name, str) and name == Path(name).name and name.endswith(".png")
    ]
