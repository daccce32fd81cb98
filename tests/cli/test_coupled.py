"""goal-coupled, beliefs that a log holds, and held-out predictions, from the command line."""

from __future__ import annotations

import numpy as np
import pytest

from ppinfer.goals import GoalCoupled
from ppinfer.goals.configuration import read_model
from ppinfer.studies import write_log
from ppinfer.studies.posterior import open_posterior
from ppinfer.testing import example_log

from .commands import checked_json, run_one


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("coupled") / "log.nc"
    made = example_log(participants=3, trials=4, model=GoalCoupled())
    made["logged_belief_robot"] = (("sample", "goal"), np.full((made.sizes["sample"], 3), 0.5))
    write_log(made, path)
    return path


def test_experts_are_chosen_by_name(log, tmp_path, capsys):
    options = ("--set", "experts=motion,distance", "stay=0.9", "distance.weight=0.4", "--json")
    assert run_one("infer", log, "-o", tmp_path / "p.nc", "--model", "goal-coupled", *options) == 0
    record = checked_json("infer", capsys.readouterr().out)
    assert record["parameters"]["experts"] == "motion,distance"
    assert record["parameters"]["distance.weight"] == 0.4


def test_a_partner_is_named(log, tmp_path, capsys):
    assert (
        run_one("infer", log, "-o", tmp_path / "p.nc", "--model", "goal-coupled", "--partner", "robot") == 0
    )
    assert "partner: robot" in capsys.readouterr().out
    assert run_one("infer", log, "-o", tmp_path / "q.nc", "--model", "goal-coupled", "--partner", "robt") == 1
    assert "no agent 'robt'" in capsys.readouterr().err


@pytest.mark.parametrize("options", [(), ("--model", "goal-coupled", "--set", "experts=motion,distance")])
@pytest.mark.parametrize("command", ["infer", "fit"])
def test_a_partner_for_a_model_that_looks_at_nobody_is_refused(command, options, log, tmp_path, capsys):
    target = tmp_path / ("p.nc" if command == "infer" else "m.toml")
    assert run_one(command, log, "-o", target, *options, "--partner", "robot") == 1
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "looks at no other agent" in told
    assert not target.exists()


def test_a_fit_writes_its_model_and_what_it_predicts_of_people_left_out(log, tmp_path, capsys):
    experts = "experts=motion,distance"
    held = ("motion.concentration=8", "motion.half_speed=2", "motion.outliers=0.05", "motion.tempering=0.3")
    where = ("-o", tmp_path / "m.toml", "--held-out", tmp_path / "h.nc", "--json")
    assert run_one("fit", log, "--model", "goal-coupled", *where, "--set", experts, *held) == 0
    record = checked_json("fit", capsys.readouterr().out)
    assert record["held_out"] == str(tmp_path / "h.nc")
    model = read_model(tmp_path / "m.toml")
    assert isinstance(model, GoalCoupled)
    assert model.parameters["motion.half_speed"] == 2.0
    with open_posterior(tmp_path / "h.nc", verify=True) as posterior:
        assert posterior.sizes["trial"] == 12
    assert run_one("infer", log, "-o", tmp_path / "p.nc", "--model", tmp_path / "m.toml") == 0
    assert run_one("compare", tmp_path / "p.nc", tmp_path / "h.nc") == 0
    assert "differences from" in capsys.readouterr().out


def test_predictions_of_people_left_out_need_some_left_out(log, tmp_path, capsys):
    where = ("-o", tmp_path / "m.toml", "--held-out", tmp_path / "h.nc")
    assert run_one("fit", log, "--model", "nearest", *where, "--folds", "0") == 1
    assert "--held-out needs a cross-validation" in capsys.readouterr().err
    assert not (tmp_path / "m.toml").exists()


def test_a_belief_of_the_log_becomes_a_posterior(log, tmp_path, capsys):
    assert run_one("infer", log, "-o", tmp_path / "live.nc", "--logged", "belief_robot", "--json") == 0
    record = checked_json("infer", capsys.readouterr().out)
    assert record["logged"] == {"variable": "logged_belief_robot", "zeros": 0, "normalised": 240}
    assert run_one("infer", log, "-o", tmp_path / "live.nc", "--logged", "belief_robot") == 0
    assert "did not sum to one" in capsys.readouterr().out
    assert run_one("score", tmp_path / "live.nc") == 0


@pytest.mark.parametrize("option", [("--set", "stay=1"), ("--model", "nearest"), ("--carry",)])
def test_a_belief_of_the_log_is_taken_as_it_is(option, log, tmp_path, capsys):
    assert run_one("infer", log, "-o", tmp_path / "live.nc", "--logged", "belief_robot", *option) == 1
    assert "--logged takes the belief as the log holds it" in capsys.readouterr().err
