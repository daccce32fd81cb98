"""A folder of notebooks to work in: those that ship with ppinfer, as Jupyter's own files, beside the data they read."""

from __future__ import annotations

import hashlib
import json
import sysconfig
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any, Literal

from ppinfer.errors import PPInferError

MISSING = "needs Jupyter: pip install 'ppinfer[notebooks]'"
# what was copied, so that a later run can tell a copy that its reader changed from one that only is old
RECORD = ".copied.json"
_MANIFEST = "manifest.toml"

Fate = Literal["copied", "updated", "unchanged", "kept"]


@dataclass(frozen=True)
class Notebook:
    """One notebook that ships with ppinfer.

    Attributes
    ----------
    file
        Its Jupytext file.
    title, asks
        Its title, and the question that it answers.
    needs
        The environment variable without which it has nothing to show; "" = none.
    """

    file: str
    title: str
    asks: str
    needs: str = ""

    @property
    def copy(self) -> str:
        """The name of its copy for Jupyter."""
        return f"{Path(self.file).stem}.ipynb"


@dataclass(frozen=True)
class Copy:
    """One file of the folder, relative to it, and what became of it.

    ``kept`` is a file that its reader changed: it is left as it is.
    """

    path: str
    fate: Fate


def shipped_folder() -> Path:
    """Return the folder that holds ``notebooks`` and ``data``: a checkout, or below the prefix of an installation.

    Raises
    ------
    PPInferError
        Where neither is there.

    Examples
    --------
    >>> (shipped_folder() / "notebooks" / "manifest.toml").exists()
    True
    """
    candidates = list(_candidates())
    for folder in candidates:
        if (folder / "notebooks" / _MANIFEST).is_file():
            return folder
    raise PPInferError(
        f"no notebooks beside this ppinfer (looked in {', '.join(map(str, candidates))}): install it from a wheel or a "
        "checkout, both of which hold them"
    )


def _candidates() -> Iterator[Path]:
    above = Path(__file__).parents[2]
    yield above
    try:
        installed = distribution("ppinfer")
    except PackageNotFoundError:
        pass
    else:
        # whatever scheme it was installed by, its record of files says where they went
        for file in installed.files or ():
            if file.parts[-4:] == ("share", "ppinfer", "notebooks", _MANIFEST):
                yield Path(str(installed.locate_file(file))).resolve().parents[1]
    yield above / "share" / "ppinfer"
    yield Path(sysconfig.get_path("data")) / "share" / "ppinfer"


def shipped_notebooks(folder: Path) -> tuple[Notebook, ...]:
    """Return the notebooks of a folder that holds ``notebooks``, in the order in which to read them.

    Examples
    --------
    >>> shipped_notebooks(shipped_folder())[0].title
    'Explore a posterior'
    """
    manifest = tomllib.loads((folder / "notebooks" / _MANIFEST).read_text(encoding="utf-8"))
    return tuple(
        Notebook(each["file"], each["title"], each["asks"], each.get("needs", ""))
        for each in manifest["notebook"]
    )


def as_ipynb(source: Path, notebooks: tuple[Notebook, ...]) -> bytes:
    """Return a Jupytext file as a Jupyter notebook without outputs: the same bytes each time.

    Links to other notebooks lead to their copies.

    Raises
    ------
    PPInferError
        Where Jupytext is not installed.
    """
    try:
        jupytext = import_module("jupytext")
    except ImportError as error:
        raise PPInferError(MISSING) from error
    notebook = jupytext.read(source)
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"cell-{number}"
        if cell["cell_type"] == "markdown":
            for each in notebooks:
                cell["source"] = cell["source"].replace(f"]({each.file})", f"]({each.copy})")
    # how it is kept as text matters to nobody who has a copy
    notebook["metadata"].pop("jupytext", None)
    text: str = jupytext.writes(notebook, fmt="ipynb")
    return text.encode()


def copy_notebooks(target: Path, *, force: bool = False) -> tuple[Copy, ...]:
    """Copy all notebooks to ``target/notebooks``, and the data that they read to ``target/data``.

    Parameters
    ----------
    target : Path
        The folder; made where it is not there.
    force : bool
        Whether to replace copies that their reader changed, which are kept otherwise.

    Returns
    -------
    tuple of Copy
        Every file, and what became of it.

    Raises
    ------
    PPInferError
        Where the target is where ppinfer itself keeps its notebooks, or is no folder, or Jupytext is not installed;
        nothing is written then.
    """
    from ppinfer.studies.replacing import replacing

    shipped = shipped_folder()
    for folder in (target, target / "notebooks", target / "data"):
        if folder.exists() and not folder.is_dir():
            raise PPInferError(f"{folder}: is a file; name a folder for the notebooks")
    if target.resolve() == shipped.resolve():
        raise PPInferError(f"{target}: holds ppinfer's own notebooks; name another folder for the copies")
    notebooks = shipped_notebooks(shipped)
    whole = {
        f"notebooks/{each.copy}": as_ipynb(shipped / "notebooks" / each.file, notebooks) for each in notebooks
    }
    whole |= {
        f"data/{file.name}": file.read_bytes()
        for file in sorted((shipped / "data").iterdir())
        if file.is_file()
    }
    record = _read_record(target / RECORD)
    copies = []
    for name, content in whole.items():
        path = target / name
        fate = _fate(path, content, record.get(name), force=force)
        if fate in ("copied", "updated"):
            path.parent.mkdir(parents=True, exist_ok=True)
            with replacing(path) as temporary:
                temporary.write_bytes(content)
        if fate != "kept":
            record[name] = _digest(content)
        copies.append(Copy(name, fate))
    with replacing(target / RECORD) as temporary:
        temporary.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")
    return tuple(copies)


def _fate(path: Path, content: bytes, recorded: str | None, *, force: bool) -> Fate:
    if not path.exists():
        return "copied"
    if path.is_dir():
        raise PPInferError(f"{path}: is a folder where a file is to go; move it away")
    there = path.read_bytes()
    if there == content:
        return "unchanged"
    return "updated" if force or _digest(there) == recorded else "kept"


def _read_record(path: Path) -> dict[str, str]:
    try:
        record: Any = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        # without a sound record every copy that differs counts as its reader's own
        return {}
    return {str(key): str(value) for key, value in record.items()} if isinstance(record, dict) else {}


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
