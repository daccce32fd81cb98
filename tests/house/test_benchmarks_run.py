"""Each benchmark script runs, at a small size, and prints what its page says it does; how fast is not for tests."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def run(script, *arguments):
    done = subprocess.run(
        [sys.executable, ROOT / "benchmarks" / script, *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def quick():
    return json.loads(run("goal_posterior.py", "--quick", "--json"))


def test_goal_posteriors_are_timed_next_to_the_literal_loop_a_filter_bank_and_a_copy(quick):
    names = [row["name"] for row in quick["in_memory"]]
    for expected in ("literal loop", "filterpy bank", "online", "batch", "copy of the same bytes"):
        assert any(name.startswith(expected) for name in names)
    for row in quick["in_memory"]:
        assert row["sample_goals"] > 0
        assert 0 < row["least"] <= row["median"]
        assert row["sample_goals_per_second"] == row["sample_goals"] / row["least"]


def test_inference_from_file_to_file_says_its_time_and_its_peak_memory(quick):
    assert [run["samples"] for run in quick["files"]] == [10_000, 20_000]
    for run in quick["files"]:
        assert run["seconds"] > 0
        # an interpreter with NumPy takes more than this, and the aim is less than that
        assert 20 * 2**20 < run["peak_bytes"] < 2**30


def test_the_algebra_is_timed_next_to_bare_arithmetic():
    printed = run("algebra.py", "--quick")
    for expected in (
        "12x40x20: f * g",
        "normalise over all axes",
        "3 labels: update",
        "10,000 samples, 5 goals: filter",
    ):
        assert expected in printed


def test_equilibria_are_timed_next_to_numpy_a_loop_and_a_pass_over_the_bytes_and_pygambit_is_missed_aloud():
    done = json.loads(run("equilibria.py", "--quick", "--json"))
    names = [row["name"] for row in done["rows"]]
    for expected in (
        "ours: pure_equilibria(game), a factor",
        "one pass over the bytes of the costs: least",
        "plain NumPy, all games at once",
        "plain NumPy, one game after another",
    ):
        assert expected in names
    assert any(name.startswith("pygambit") for name in names) == (done["pygambit"] is not None)
    assert all(0 < row["least"] <= row["median"] and row["least_cpu"] >= 0 for row in done["rows"])
    printed = run("equilibria.py", "--quick")
    assert "microseconds a game; one core" in printed
    assert ("pygambit missing" in printed) == (done["pygambit"] is None)


def test_the_search_for_many_agents_is_timed_and_counted_against_the_table():
    rows = json.loads(run("many_agents.py", "--quick", "--json"))["rows"]
    assert [(row["agents"], row["plans"], row["profiles"]) for row in rows] == [(4, 8, 8**4), (8, 8, 8**8)]
    for row in rows:
        assert 0 < row["least"] <= row["median"]
        assert row["equilibria"] >= 1
    assert rows[0]["table_median"] > 0


def test_a_replan_is_timed_stage_by_stage_and_its_table_held_against_the_physical_world():
    done = json.loads(run("replan.py", "--quick", "--json"))
    names = [row["name"] for row in done["rows"]]
    for policy in ("bayes", "bayes-risk"):
        for stage in ("plans of both agents", "table", "equilibria", "equilibria and belief", "whole replan"):
            assert f"{policy}: {stage}" in names
    assert all(0 < row["mean"] <= row["largest"] for row in done["rows"])
    # profiles in which arms graze may differ by a step
    assert done["stepping_pymunk"]["agree"] >= done["stepping_pymunk"]["profiles"] - 2


def test_rollouts_and_candidates_are_timed_next_to_the_literal_algorithms():
    done = json.loads(run("safety.py", "--quick", "--json"))
    names = [row["name"] for row in done["rows"]]
    for what in ("long-term safe probability", "candidates"):
        assert {f"{what}: literal", f"{what}: ours"} <= set(names)
        assert done["times_literal"][what] > 0
    assert "400 plans x 1000 rollouts x 20 steps" in names
    for row in done["rows"]:
        assert row["least"] > 0
        assert row["steps_per_second"] == row["steps"] / row["least_cpu"]


def test_games_and_a_step_of_algorithm_1_are_timed_next_to_the_literal_one():
    done = json.loads(run("reaching.py", "--quick", "--json"))
    names = [row["name"] for row in done["rows"]]
    assert "a game: expected-cost" in names
    for part in ("beliefs", "choice of a goal", "choice of goal and trajectory", "whole Algorithm 1"):
        assert f"a step: {part}" in names
    assert {"literal: beliefs and reactions", "literal: candidates"} <= set(names)
    assert all(row["least"] > 0 and row["least_cpu"] >= 0 for row in done["rows"])
    assert done["times_literal"] > 0


def test_every_benchmark_script_says_what_it_takes():
    scripts = sorted(path.name for path in (ROOT / "benchmarks").glob("*.py"))
    assert {"algebra.py", "equilibria.py", "goal_posterior.py"} <= set(scripts)
    page = (ROOT / "docs" / "benchmarks.md").read_text()
    for script in scripts:
        assert f"benchmarks/{script}" in page
