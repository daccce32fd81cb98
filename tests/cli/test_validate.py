import h5py
import pytest

from ppinfer.studies import write_log
from ppinfer.studies.posterior import write_posterior

from ..studies.logs import small_log
from ..studies.posteriors import make_posterior
from .commands import checked_json, run_one


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_a_sound_log_exits_with_zero(tmp_path, capsys, suffix):
    write_log(small_log(), tmp_path / f"log{suffix}")
    assert run_one("validate", tmp_path / f"log{suffix}") == 0
    assert "sound (2 trials, 7 samples, 2 segments)" in capsys.readouterr().out


def test_progress_is_drawn_on_a_terminal_and_nowhere_else(tmp_path, capsys, monkeypatch):
    write_log(small_log(), tmp_path / "log.nc")
    run_one("validate", tmp_path / "log.nc")
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("rich.console.Console.is_terminal", True)
    run_one("validate", tmp_path / "log.nc")
    quiet, drawn = capsys.readouterr()
    assert "checking samples" in drawn
    assert "checking" not in quiet


def test_an_unsound_log_exits_with_one_and_a_line_a_fault(tmp_path, capsys):
    log = small_log().copy(deep=True)
    log.time.values[2] = 0.0
    log.true_goal.values[0] = "spoon"
    write_log(log, tmp_path / "log.nc", validate=False)
    assert run_one("validate", tmp_path / "log.nc") == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].endswith("2 faults (2 trials, 7 samples, 2 segments)")
    assert len(lines) == 3


def test_json_is_as_its_schema_says(tmp_path, capsys):
    log = small_log().copy(deep=True)
    log.time.values[2] = 0.0
    write_log(log, tmp_path / "log.nc", validate=False)
    assert run_one("validate", tmp_path / "log.nc", "--json") == 1
    told = checked_json("validate", capsys.readouterr().out)
    assert told["fault_counts"] == {"time-not-increasing": 1}
    assert (told["faults"][0]["trial"], told["faults"][0]["sample"]) == ("a", 2)


@pytest.mark.parametrize("content", [b"", b"no log at all", b"\x89HDF\r\n\x1a\n" + b"\x00" * 50])
def test_a_file_that_cannot_be_read_is_one_fault(tmp_path, capsys, content):
    (tmp_path / "log.nc").write_bytes(content)
    assert run_one("validate", tmp_path / "log.nc", "--json") == 1
    told = checked_json("validate", capsys.readouterr().out)
    assert told["fault_counts"] == {"unreadable": 1}


def test_what_is_not_there_is_one_fault(tmp_path, capsys):
    assert run_one("validate", tmp_path / "nothing.nc") == 1
    assert "there is no such file" in capsys.readouterr().out
    assert run_one("validate", tmp_path) == 1


def test_a_posterior_is_checked_too(tmp_path, capsys):
    path = tmp_path / "post.nc"
    write_posterior(make_posterior(), path)
    assert run_one("validate", path, "--json") == 0
    assert checked_json("validate", capsys.readouterr().out)["sizes"]["trial"] == 4
    with h5py.File(path, "r+") as file:
        file["participant"][0] = "somebody else"
    assert run_one("validate", path) == 1
    assert "post.nc" in capsys.readouterr().out
