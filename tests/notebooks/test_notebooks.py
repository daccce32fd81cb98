"""Every notebook is listed, is what it says, and runs."""

import tomllib
from pathlib import Path

import pytest

pytest.importorskip("jupytext", reason="notebooks need the extra 'notebooks'")
pytest.importorskip("nbclient", reason="notebooks need the extra 'notebooks'")
pytest.importorskip("ipykernel", reason="notebooks need the extra 'notebooks'")

NOTEBOOKS = Path(__file__).parents[2] / "notebooks"
LISTED = tomllib.loads((NOTEBOOKS / "manifest.toml").read_text(encoding="utf-8"))["notebook"]


def test_every_notebook_is_listed_and_every_listed_one_is_there():
    there = {path.name for path in NOTEBOOKS.rglob("*") if path.suffix in (".py", ".ipynb", ".md")}
    assert there == {entry["file"] for entry in LISTED}


@pytest.mark.parametrize("entry", LISTED, ids=lambda entry: entry["file"])
@pytest.mark.filterwarnings("default::DeprecationWarning")
@pytest.mark.filterwarnings("ignore:.*IPC:UserWarning")
def test_a_notebook_runs_from_top_to_bottom(entry, tmp_path, monkeypatch):
    import jupytext
    from nbclient import NotebookClient

    # kernels write where they please; here, and as figures that need no window
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path))
    monkeypatch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    notebook = jupytext.read(NOTEBOOKS / entry["file"])
    assert notebook.cells[0].source.startswith(f"# {entry['title']}")
    client = NotebookClient(
        notebook,
        timeout=entry["timeout_s"],
        kernel_name="python3",
        resources={"metadata": {"path": str(NOTEBOOKS)}},
    )
    client.execute()
    drawn = [
        output
        for cell in notebook.cells
        if cell.cell_type == "code"
        for output in cell.outputs
        if "image/png" in output.get("data", {})
    ]
    assert drawn, "a notebook shows figures"
    complaints = [
        output["text"]
        for cell in notebook.cells
        if cell.cell_type == "code"
        for output in cell.outputs
        if output.get("name") == "stderr"
    ]
    assert complaints == []
