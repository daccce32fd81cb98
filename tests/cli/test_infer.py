"""``ppinfer infer``: a short table, a JSON object, and one line where it cannot be done."""

import numpy as np
import pytest
import xarray as xr

from ppinfer.studies import write_log
from ppinfer.testing import example_log

from .commands import checked_json, run_one


@pytest.fixture
def log(tmp_path):
    write_log(example_log(participants=2, trials=3), tmp_path / "log.nc")
    return tmp_path / "log.nc"


def test_the_table_says_what_was_done_and_how_well(log, tmp_path, capsys):
    assert run_one("infer", log, "-o", tmp_path / "post.nc", "--model", "goal-lqr") == 0
    shown = capsys.readouterr().out
    assert "goal-lqr on log.nc" in shown
    assert "after 50% of a segment" in shown
    assert "control: logged" in shown


def test_settings_reach_the_model_and_the_file(log, tmp_path, capsys):
    arguments = ("--set", "rationality=0.5", "stay=0.9", "--mode", "smooth", "--seed", "3", "--json")
    assert run_one("infer", log, "-o", tmp_path / "post.nc", *arguments) == 0
    record = checked_json("infer", capsys.readouterr().out)
    assert record["parameters"]["rationality"] == 0.5
    posterior = xr.load_dataset(tmp_path / "post.nc")
    assert posterior.attrs["mode"] == "smooth"
    assert posterior.attrs["seed"] == 3


def test_a_fitted_model_is_taken_and_can_be_changed(log, tmp_path, capsys):
    assert run_one("fit", log, "-o", tmp_path / "m.toml", "--model", "nearest", "--folds", "0") == 0
    capsys.readouterr()
    assert run_one("infer", log, "-o", tmp_path / "a.nc", "--model", tmp_path / "m.toml", "--json") == 0
    assert checked_json("infer", capsys.readouterr().out)["model"] == "nearest"
    arguments = ("--model", tmp_path / "m.toml", "--set", "scale=9", "--json")
    assert run_one("infer", log, "-o", tmp_path / "b.nc", *arguments) == 0
    assert checked_json("infer", capsys.readouterr().out)["parameters"] == {"scale": 9.0}


def test_a_log_without_known_goals_is_inferred_all_the_same(tmp_path, capsys):
    log = example_log(participants=1, trials=2)
    log["true_goal"].values[:] = ""
    write_log(log, tmp_path / "log.nc")
    assert run_one("infer", tmp_path / "log.nc", "-o", tmp_path / "post.nc") == 0
    assert "accuracy" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--model", "goal-lqrr"), "did you mean 'goal-lqr'"),
        (("--model", "missing.toml"), "missing.toml: No such file"),
        (("--set", "rationality"), "--set takes NAME=VALUE; got 'rationality'"),
        (("--set", "stay=0.9", "stay=0.8"), "gives 'stay' twice"),
        (("--set", "stay=2"), "stay must lie in"),
        (("--agent", "dog"), "no agent 'dog'; it has 'human'"),
        (("--set", "evidence_floor=1"), "evidence_floor must lie in [0, 1); got 1.0"),
        (("--set", "rationality=1e300"), "rationality must lie in (0, 1e+30]"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_writes_nothing(log, tmp_path, capsys, arguments, message):
    assert run_one("infer", log, "-o", tmp_path / "post.nc", *arguments) == 1
    shown = capsys.readouterr()
    assert message in shown.err
    assert shown.err.count("\n") == 1
    assert shown.out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["log.nc"]


def test_what_is_read_is_never_written_over(log, tmp_path, capsys):
    before = log.read_bytes()
    assert run_one("infer", log, "-o", log) == 1
    assert "is both read and written" in capsys.readouterr().err
    assert run_one("infer", log, "-o", tmp_path / "notes.txt") == 1
    assert "the output is a .nc file" in capsys.readouterr().err
    assert run_one("fit", log, "-o", log, "--model", "nearest") == 1
    assert "the output is a .toml file" in capsys.readouterr().err
    assert log.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["log.nc"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("infer", "LOG", "-o", "p.nc", "--seed", "-1"), "expected a whole number, 0 or more; got '-1'"),
        (("fit", "LOG", "-o", "m.toml", "--folds", "-1"), "expected a whole number, 0 or more; got '-1'"),
        (("fit", "LOG", "-o", "m.toml", "--at", "1.5"), "expected a share above 0 and at most 1; got '1.5'"),
        (
            ("fit", "LOG", "-o", "m.toml", "--min-distance", "nan"),
            "expected a distance, 0 or more; got 'nan'",
        ),
        (("infer", "-o", "p.nc", "--set", "a=1", "LOG"), "put files first"),
    ],
)
def test_wrong_arguments_are_one_line_and_status_two(arguments, message, capsys):
    with pytest.raises(SystemExit) as stopped:
        run_one(*arguments)
    assert stopped.value.code == 2
    shown = capsys.readouterr().err
    assert message in shown
    assert shown.count("\n") == 1


def test_many_outliers_are_warned_of(tmp_path, capsys):
    write_log(example_log(participants=1, trials=2, positions_only=True), tmp_path / "log.nc")
    arguments = ("--model", "goal-kalman", "--set", "measurement_noise=1e-9", "rationality=1e9")
    assert run_one("infer", tmp_path / "log.nc", "-o", tmp_path / "post.nc", *arguments) == 0
    assert "were set aside as outliers; is measurement_noise" in capsys.readouterr().err


def test_a_file_that_is_no_log_is_named(tmp_path, capsys):
    (tmp_path / "log.nc").write_text("hello")
    assert run_one("infer", tmp_path / "log.nc", "-o", tmp_path / "post.nc") == 1
    assert "log.nc" in capsys.readouterr().err
    assert run_one("infer", tmp_path / "none.nc", "-o", tmp_path / "post.nc") == 1
    assert "none.nc" in capsys.readouterr().err


def test_a_damaged_log_is_refused_or_read_as_it_was(log, tmp_path, capsys):
    whole = log.read_bytes()
    run_one("infer", log, "-o", tmp_path / "whole.nc")
    expected = xr.load_dataset(tmp_path / "whole.nc")["log_posterior"].values
    capsys.readouterr()
    refused = 0
    for place in np.linspace(0, len(whole) - 1, 40).astype(int):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << (place % 8)
        log.write_bytes(bytes(damaged))
        status = run_one("infer", log, "-o", tmp_path / "post.nc")
        shown = capsys.readouterr()
        if status:
            refused += 1
            assert (status, shown.err.count("\n")) == (1, 1)
            assert not (tmp_path / "post.nc").exists()
        else:
            assert (xr.load_dataset(tmp_path / "post.nc")["log_posterior"].values == expected).all()
            (tmp_path / "post.nc").unlink()
    assert refused > 5
