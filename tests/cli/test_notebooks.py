import json
import os
import subprocess
import sys

import pytest

from ppinfer.cli import notebook_copies
from ppinfer.cli.notebook_copies import RECORD, copy_notebooks, shipped_folder, shipped_notebooks

from .commands import checked_json, run_one

nbformat = pytest.importorskip("nbformat", reason="notebooks need the extra 'notebooks'")
pytest.importorskip("jupytext", reason="notebooks need the extra 'notebooks'")

SHIPPED = shipped_notebooks(shipped_folder())


@pytest.fixture
def one_shipped(tmp_path, monkeypatch):
    """Return a folder that ships one notebook and one log, as ppinfer would."""
    shipped = tmp_path / "shipped"
    (shipped / "notebooks").mkdir(parents=True)
    (shipped / "data").mkdir()
    (shipped / "data" / "log.nc").write_bytes(b"a log")
    (shipped / "notebooks" / "ask.py").write_text("# %% [markdown]\n# # Ask\n\n# %%\n1 + 1\n")
    (shipped / "notebooks" / "manifest.toml").write_text(
        '[[notebook]]\nfile = "ask.py"\ntitle = "Ask"\nasks = "what is 1 + 1?"\ntimeout_s = 9\n'
    )
    monkeypatch.setattr(notebook_copies, "_candidates", lambda: iter([shipped]))
    return shipped


def fates(copies):
    return {each.path: each.fate for each in copies}


def test_all_notebooks_are_copied_for_jupyter_with_the_data_beside_them(tmp_path, capsys):
    assert run_one("notebooks", tmp_path / "mine", "--copy-only", "--json") == 0
    told = checked_json("notebooks", capsys.readouterr().out)
    assert told["folder"] == str(tmp_path / "mine")
    assert [each["title"] for each in told["notebooks"]] == [each.title for each in SHIPPED]
    assert {each["fate"] for each in told["files"]} == {"copied"}
    there = {path.relative_to(tmp_path / "mine").as_posix() for path in (tmp_path / "mine").rglob("*.*")}
    assert there == {each["path"] for each in told["files"]} | {RECORD}
    assert {f"notebooks/{each.copy}" for each in SHIPPED} < there
    assert "data/reaching-small.nc" in there
    for each in SHIPPED:
        copy = nbformat.read(tmp_path / "mine" / "notebooks" / each.copy, as_version=4)
        nbformat.validate(copy)
        assert copy.cells[0].source.startswith(f"# {each.title}")
        assert copy.metadata.kernelspec.name == "python3"
        # links lead to copies
        assert not any(f"]({other.file})" in cell.source for other in SHIPPED for cell in copy.cells)


def test_copying_again_changes_nothing(one_shipped, tmp_path):
    assert fates(copy_notebooks(tmp_path / "mine")) == {
        "notebooks/ask.ipynb": "copied",
        "data/log.nc": "copied",
    }
    assert set(fates(copy_notebooks(tmp_path / "mine")).values()) == {"unchanged"}


def test_what_a_reader_changed_is_named_and_kept(one_shipped, tmp_path, capsys):
    mine = tmp_path / "mine"
    copy_notebooks(mine)
    (mine / "notebooks" / "ask.ipynb").write_text("my own")
    assert run_one("notebooks", mine, "--copy-only") == 0
    assert "kept as you changed them: notebooks/ask.ipynb (--force replaces them)" in capsys.readouterr().err
    assert (mine / "notebooks" / "ask.ipynb").read_text() == "my own"
    # also where what ships has changed since
    (one_shipped / "notebooks" / "ask.py").write_text("# %% [markdown]\n# # Ask more\n")
    assert fates(copy_notebooks(mine))["notebooks/ask.ipynb"] == "kept"
    assert fates(copy_notebooks(mine, force=True))["notebooks/ask.ipynb"] == "updated"
    assert "Ask more" in (mine / "notebooks" / "ask.ipynb").read_text()


def test_a_copy_that_nobody_changed_follows_what_ships(one_shipped, tmp_path):
    copy_notebooks(tmp_path / "mine")
    (one_shipped / "notebooks" / "ask.py").write_text("# %% [markdown]\n# # Ask more\n")
    assert fates(copy_notebooks(tmp_path / "mine")) == {
        "notebooks/ask.ipynb": "updated",
        "data/log.nc": "unchanged",
    }


@pytest.mark.parametrize("record", ["", "[1]", "no json", "{"])
def test_without_a_sound_record_whatever_differs_is_its_readers(one_shipped, tmp_path, record):
    mine = tmp_path / "mine"
    copy_notebooks(mine)
    (mine / RECORD).write_text(record)
    (one_shipped / "data" / "log.nc").write_bytes(b"another log")
    assert fates(copy_notebooks(mine)) == {"notebooks/ask.ipynb": "unchanged", "data/log.nc": "kept"}


def test_ppinfers_own_notebooks_are_no_place_for_copies(one_shipped, capsys):
    assert run_one("notebooks", one_shipped, "--copy-only") == 1
    assert "holds ppinfer's own notebooks" in capsys.readouterr().err
    assert not list(one_shipped.rglob("*.ipynb"))


@pytest.mark.parametrize("where", [".", "data", "notebooks", "notebooks/ask.ipynb"])
def test_what_is_in_the_way_is_one_line(one_shipped, tmp_path, capsys, where):
    mine = tmp_path / "mine"
    if where.endswith(".ipynb"):
        (mine / where).mkdir(parents=True)
    else:
        (mine / where).parent.mkdir(exist_ok=True)
        (mine / where).write_text("a file")
    assert run_one("notebooks", mine, "--copy-only") == 1
    (told,) = capsys.readouterr().err.splitlines()
    assert where.endswith(".ipynb") or "is a file; name a folder" in told


def test_an_installation_without_notebooks_is_one_line(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(notebook_copies, "_candidates", lambda: iter([tmp_path]))
    assert run_one("notebooks", "--list") == 1
    assert "no notebooks beside this ppinfer" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("missing", "argv"), [("jupytext", ["--copy-only"]), ("jupyterlab", []), ("jupytext", [])]
)
def test_without_the_extra_the_command_says_how_to_get_it(tmp_path, capsys, monkeypatch, missing, argv):
    monkeypatch.setitem(sys.modules, missing, None)
    assert run_one("notebooks", tmp_path / "mine", *argv) == 1
    err = capsys.readouterr().err
    assert err == "ppinfer notebooks: needs Jupyter: pip install 'ppinfer[notebooks]'\n"
    assert not (tmp_path / "mine").exists()


def test_a_list_copies_nothing(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run_one("notebooks", "--list") == 0
    out = capsys.readouterr().out
    assert all(each.title in out for each in SHIPPED)
    assert run_one("notebooks", "--list", "--json") == 0
    told = checked_json("notebooks", capsys.readouterr().out)
    assert (told["folder"], told["files"]) == (None, [])
    assert not list(tmp_path.iterdir())


def test_jupyterlab_is_started_in_the_folder_and_its_status_is_ours(one_shipped, tmp_path, monkeypatch):
    fake = tmp_path / "fake"
    fake.mkdir()
    (fake / "jupyterlab.py").write_text(
        "import json, os, sys\njson.dump(sys.argv[1:], open(os.environ['SEEN'], 'w'))\nsys.exit(3)\n"
    )
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(fake), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.setenv("SEEN", str(tmp_path / "seen.json"))
    monkeypatch.syspath_prepend(fake)
    assert run_one("notebooks", tmp_path / "mine", "--no-browser") == 3
    seen = json.loads((tmp_path / "seen.json").read_text())
    assert f"--notebook-dir={tmp_path / 'mine'}" in seen
    assert "--no-browser" in seen
    assert run_one("notebooks", tmp_path / "mine", "--lab-options", "--port", "8899", "--allow-root") == 3
    seen = json.loads((tmp_path / "seen.json").read_text())
    assert "--no-browser" not in seen
    assert seen[-3:] == ["--port", "8899", "--allow-root"]


def test_ctrl_c_is_for_jupyterlab_which_asks_before_it_ends(one_shipped, tmp_path, monkeypatch):
    class Lab:
        """A JupyterLab that goes on after the first Ctrl-C, and ends well."""

        waits = 0

        def __init__(self, command):
            self.command = command

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def wait(self):
            self.waits += 1
            if self.waits == 1:
                raise KeyboardInterrupt
            return 0

    monkeypatch.setattr(subprocess, "Popen", Lab)
    monkeypatch.setattr("ppinfer.cli.notebooks._installed", lambda module: True)
    assert run_one("notebooks", tmp_path / "mine") == 0
