"""Every notebook is listed, is what it says, and runs where `ppinfer notebooks` copies it to."""

import os
import tomllib
from pathlib import Path

import pytest

from ppinfer.cli.notebook_copies import copy_notebooks

pytest.importorskip("jupytext", reason="notebooks need the extra 'notebooks'")
pytest.importorskip("nbclient", reason="notebooks need the extra 'notebooks'")
pytest.importorskip("ipykernel", reason="notebooks need the extra 'notebooks'")
pytest.importorskip("ipywidgets", reason="notebooks need the extra 'notebooks'")

ROOT = Path(__file__).parents[2]
NOTEBOOKS = ROOT / "notebooks"
LISTED = tomllib.loads((NOTEBOOKS / "manifest.toml").read_text(encoding="utf-8"))["notebook"]
LONGEST = 220


@pytest.fixture(scope="module")
def copied(tmp_path_factory):
    """Return a folder of notebooks, and their data beside it, as a reader gets them."""
    folder = tmp_path_factory.mktemp("mine")
    copy_notebooks(folder)
    return folder / "notebooks"


def test_every_notebook_is_listed_and_every_listed_one_is_there():
    there = {path.name for path in NOTEBOOKS.rglob("*") if path.suffix in (".py", ".ipynb", ".md")}
    assert there == {entry["file"] for entry in LISTED}


def test_notebooks_are_few_short_and_quick():
    assert len(LISTED) <= 8
    for entry in LISTED:
        assert entry["timeout_s"] <= 120, entry["file"]
        lines = (NOTEBOOKS / entry["file"]).read_text(encoding="utf-8").splitlines()
        assert len(lines) <= LONGEST, entry["file"]


def test_the_documentation_lists_every_notebook_with_what_it_asks():
    page = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    for entry in LISTED:
        assert f"| [{entry['title']}](../notebooks/{entry['file']}) | {entry['asks']} |" in page


@pytest.mark.parametrize("entry", LISTED, ids=lambda entry: entry["file"])
@pytest.mark.filterwarnings("default::DeprecationWarning")
@pytest.mark.filterwarnings("ignore:.*IPC:UserWarning")
def test_a_notebook_runs_from_top_to_bottom(entry, copied, tmp_path, monkeypatch):
    import nbformat
    from nbclient import NotebookClient

    if "needs" in entry and not os.environ.get(entry["needs"]):
        pytest.skip(f"{entry['file']} needs {entry['needs']}, the folder of the real recordings")
    # kernels write where they please; here, and as figures that need no window
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path))
    monkeypatch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    notebook = nbformat.read(copied / Path(entry["file"]).with_suffix(".ipynb"), as_version=4)
    assert notebook.cells[0].source.startswith(f"# {entry['title']}\n")
    client = NotebookClient(
        notebook,
        timeout=entry["timeout_s"],
        kernel_name="python3",
        resources={"metadata": {"path": str(copied)}},
    )
    client.execute()
    outputs = [
        output for cell in notebook.cells if cell.cell_type == "code" for output in cell.get("outputs", ())
    ]
    assert any("image/png" in output.get("data", {}) for output in outputs), "a notebook shows figures"
    assert [output["text"] for output in outputs if output.get("name") == "stderr"] == []
