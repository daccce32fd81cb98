import json
import math
from dataclasses import astuple
from importlib.resources import files

import jsonschema
import numpy as np
import pytest

from ppsim.cli import main
from ppsim.errors import SimulationError
from ppsim.reaching.crossing import CONTROLLERS, Crossing, cross, cross_many, summarise


def told(runs):
    """Return the runs as tuples that can be compared: NaN equals nothing, not even itself."""
    return [tuple("never" if value != value else value for value in astuple(run)) for run in runs]


def test_straight_on_agents_who_swap_places_meet():
    runs = list(cross_many(Crossing(0.1), "none", 10, seed=3))
    assert all(run.violated and run.accepted == 0 for run in runs)
    assert all(math.isfinite(run.reached_s) for run in runs)


@pytest.mark.parametrize("noise", [0.1, 0.5])
@pytest.mark.parametrize("controller", ["alg2", "alg3"])
def test_safe_control_keeps_apart_and_gets_there(controller, noise):
    # a thousand runs, of which docs/safety.md tells, are too many for a test
    found = summarise(list(cross_many(Crossing(noise), controller, 8, seed=3)), 0.05)
    assert found["violations"] == 0
    assert found["reached_rate"] == 1.0
    assert found["reached_s"] < 4.0
    assert found["plan_violation_rate"] <= 0.05
    assert found["accepted"] >= 0.95 * found["decisions"]


def test_a_step_towards_a_safe_state_that_nobody_checks_is_not_safe():
    weak = summarise(list(cross_many(Crossing(0.5), "alg2-weak", 10, seed=3)), 0.05)
    assert weak["violations"] >= 2


def test_the_printed_tube_keeps_apart_too_and_flags_more():
    tube = summarise(list(cross_many(Crossing(0.5), "alg3-tube", 6, seed=3)), 0.05)
    checked = summarise(list(cross_many(Crossing(0.5), "alg3", 6, seed=3)), 0.05)
    assert tube["violations"] == 0
    assert tube["flagged"] > checked["flagged"]


def test_a_run_depends_on_the_seed_and_its_number_alone_whoever_plays_it():
    crossing = Crossing(0.5)
    alone = list(cross_many(crossing, "alg3", 3, seed=5))
    assert told(alone) == told(cross_many(crossing, "alg3", 3, seed=5, workers=2))
    assert told(alone)[:2] == told(cross_many(crossing, "alg3", 2, seed=5))
    assert told(alone) != told(cross_many(crossing, "alg3", 3, seed=6))


def test_a_run_is_a_function_of_its_seed():
    first, second = (cross(Crossing(0.5), "none", seed=9) for _ in range(2))
    assert told([first]) == told([second])
    assert set(CONTROLLERS) == {"none", "alg2", "alg3", "alg2-weak", "alg3-tube"}


def test_values_out_of_range_are_refused():
    with pytest.raises(SimulationError, match="noise must be positive and finite"):
        Crossing(-0.1)
    with pytest.raises(SimulationError, match="noise must be positive and finite, its square too"):
        Crossing(1e200)
    with pytest.raises(SimulationError, match="seed must not be negative"):
        list(cross_many(Crossing(0.1), "none", 1, seed=-1))
    with pytest.raises(SimulationError, match=r"eps must lie in \(0, 1\)"):
        Crossing(0.1, eps=0.0)
    with pytest.raises(SimulationError, match="unknown controller 'alg4'"):
        cross(Crossing(0.1), "alg4", seed=0)
    with pytest.raises(SimulationError, match="runs must be at least 1"):
        list(cross_many(Crossing(0.1), "none", 0, seed=0))


def test_the_json_fits_its_schema(capsys):
    line = "crossing --runs 3 --noise .5 --controllers none alg3 alg3-tube --seed 2 --json"
    assert main(line.split()) == 0
    printed = capsys.readouterr()
    found = json.loads(printed.out)
    schema = json.loads((files("ppsim") / "schemas" / "crossing.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(found, schema, cls=jsonschema.Draft202012Validator)
    assert printed.err == ""
    assert [cell["controller"] for cell in found["cells"]] == ["none", "alg3", "alg3-tube"]
    assert found["cells"][0]["plan_violation_rate"] is None
    assert np.isclose(found["cells"][0]["violation_upper"], 1.0)


def test_the_table_says_what_was_counted(capsys):
    assert main(["crossing", "--runs", "2", "--noise", ".1", "--controllers", "none", "--seed", "2"]) == 0
    out = capsys.readouterr().out
    assert "head-on crossing, 2 runs each, eps = 0.05, seed 2" in out
    assert "none accepted" in out


def test_bad_options_are_one_line(capsys):
    assert main(["crossing", "--runs", "0", "--controllers", "none"]) == 1
    assert "runs must be at least 1; got 0" in capsys.readouterr().err
    for twice in (["--noise", ".1", ".1"], ["--controllers", "none", "none"]):
        assert main(["crossing", "--runs", "1", *twice]) == 1
        told = capsys.readouterr().err
        assert told.count("\n") == 1
        assert "is named twice" in told
    with pytest.raises(SystemExit):
        main(["crossing", "--controllers", "alg4"])
    assert capsys.readouterr().err.count("\n") == 1
