"""A run that is killed: what was recorded is there, the next run completes it, and nothing is half written.

``PPINFER_KILLS=100`` in the environment kills whole commands at random times as well, so often in all.
"""

from __future__ import annotations

import os
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from ppinfer.studies import file_sha256, read_log, write_log
from ppinfer.studies.prediction_examples import ExampleStore
from ppinfer.studies.recording import load_recording
from ppinfer.testing import example_log, example_planned_log

from .killing import kill_at_any_time, killed

KILLS = int(os.environ.get("PPINFER_KILLS", "0"))
SEED = int(os.environ.get("PPINFER_FUZZ_SEED", "0"))

STUDIES = {
    "record": ("record", "reaching", "--trials", "5", "--duration", "2", "--seed", "3"),
    "study": (
        "study",
        "--scenes",
        "2",
        "--robots",
        "norm",
        "bayes",
        "--humans",
        "norm",
        "--seed",
        "1",
        "--resume",
    ),
    "reach": (
        *("reach", "--games", "2", "--robots", "naive", "reactive", "--humans", "waiting"),
        *("--duration", "3", "--seed", "1", "--resume"),
    ),
}
EXAMPLES = ("examples", "24", "--continuations", "2", "--limit", "2", "--seed", "2")


def command(program, *argv):
    """Return a function that runs a command in this process."""

    def run():
        from importlib import import_module

        assert import_module(f"{program}.cli").main([str(part) for part in argv]) == 0

    return run


def names(folder):
    return sorted(item.name for item in folder.iterdir())


@pytest.fixture(autouse=True)
def one_process(monkeypatch):
    # the process that reads files first is killed with the one that asks it, which has a test of its own
    monkeypatch.setenv("PPINFER_GUARD", "off")


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_that_is_killed_again_and_again_ends_as_if_it_had_not_been(tmp_path, name, capsys):
    (tmp_path / "whole").mkdir()
    command("ppsim", *STUDIES[name], "-o", tmp_path / "whole" / "log.nc")()
    whole = read_log(tmp_path / "whole" / "log.nc")
    folder = tmp_path / "killed"
    folder.mkdir()
    target, recording = folder / "log.nc", folder / "log.recording.jsonl"
    run = command("ppsim", *STUDIES[name], "-o", target)
    # while the header is written; a trial, whose line is torn; another, whose line is whole; before the log takes its
    # place; and before the recording goes
    points = [
        ("fsync", 1, True, 0),
        ("fsync", 3, True, 1),
        ("fsync", 1, False, 2),
        ("os.rename", 1, False, whole.sizes["trial"]),
        ("os.remove", 1, False, whole.sizes["trial"]),
    ]
    for event, number, torn, safe in points:
        of = ".jsonl" if event == "os.remove" else ""
        assert killed(run, folder, event, number, torn=torn, of=of), event
        if safe:
            kept = load_recording(recording).completed
            assert kept == tuple(whole["trial_id"].values[:safe].tolist())
        assert target.exists() == (event == "os.remove")
    run()
    assert names(folder) == ["log.nc"]
    assert read_log(target).attrs["content_sha256"] == whole.attrs["content_sha256"]


def test_examples_that_are_killed_again_and_again_end_as_if_they_had_not_been(tmp_path, capsys):
    (tmp_path / "whole").mkdir()
    command("ppsim", *EXAMPLES, "-o", tmp_path / "whole" / "e.zarr")()
    folder = tmp_path / "killed"
    folder.mkdir()
    run = command("ppsim", *EXAMPLES, "-o", folder / "e.zarr")
    deaths = 0
    for number in (1, 3, 17, 24, 30, 40):
        deaths += killed(run, folder, "write", number)
    assert deaths >= 4
    run()
    found = ExampleStore(folder / "e.zarr")
    assert len(found) == 24
    assert contents(found) == contents(ExampleStore(tmp_path / "whole" / "e.zarr"))


def contents(store):
    examples = store.read(0, len(store))
    parts = [
        getattr(examples, name)
        for name in ("human", "robot", "plan", "goals", "present", "frequency", "robot_goal")
    ]
    return [
        *(part.tolist() for part in parts),
        store.kinds(0, len(store)).tolist(),
        store.interaction(0, len(store)),
    ]


def sources(folder):
    """Write what commands read; return it by name."""
    from ppinfer.goals import GoalLQR
    from ppinfer.studies import infer_log
    from ppinfer.studies.posterior import write_posterior

    log = example_log(participants=2, trials=2)
    write_log(log, folder / "log.nc")
    write_log(example_planned_log(trials=2, replans=2), folder / "plays.nc")
    write_posterior(infer_log(log, GoalLQR()), folder / "post.nc")
    (folder / "obsmat.txt").write_text("0 1 0 0 0 0 0 0\n6 1 1 0 1 0 0 0\n12 1 2 0 2 0 0 0\n")
    (folder / "destinations.txt").write_text("5 0\n")
    return folder


OUTPUTS = {
    "infer": (("infer", "log.nc", "-o"), "made.nc"),
    "infer personality": (("infer", "plays.nc", "--model", "personality", "-o"), "made.nc"),
    "convert": (("convert", "obsmat.txt", "--from", "eth", "-o"), "made.nc"),
    "convert to zarr": (("convert", "obsmat.txt", "--from", "eth", "-o"), "made.zarr"),
    "report": (("report", "post.nc", "-o"), "made"),
    "metrics": (("metrics", "log.nc", "-o"), "made.csv"),
}


def arguments(name, folder, out):
    argv, made = OUTPUTS[name]
    return [str(folder / part) if (folder / part).is_file() else part for part in argv] + [str(out / made)]


@pytest.mark.parametrize("name", OUTPUTS)
def test_a_command_that_is_killed_leaves_nothing_half_written_and_nothing_in_the_way(tmp_path, name, capsys):
    folder, out = tmp_path / "in", tmp_path / "out"
    folder.mkdir()
    out.mkdir()
    run = command("ppinfer", *arguments(name, sources(folder), out))
    made = out / OUTPUTS[name][1]
    assert killed(run, out, "os.rename", 1)
    # what was being written is hidden, and under no name that anybody reads
    assert not made.exists()
    assert all(item.startswith(".") for item in names(out))
    run()
    assert names(out) == [made.name]
    before = file_sha256(made)
    assert killed(run, out, "os.rename", 1)
    assert file_sha256(made) == before
    run()
    assert names(out) == [made.name]


@pytest.mark.skipif(not KILLS, reason="set PPINFER_KILLS=100 to kill whole commands at random times")
@pytest.mark.parametrize("name", [*STUDIES, "record on two processes", "examples", *OUTPUTS])
def test_a_command_that_is_killed_at_any_time(tmp_path, name, monkeypatch):
    monkeypatch.delenv("PPINFER_GUARD")
    rng = np.random.default_rng([SEED, len(name)])
    wanted = -(-KILLS // (len(STUDIES) + 2 + len(OUTPUTS)))
    deaths = rounds = 0
    while deaths < wanted:
        rounds += 1
        folder = tmp_path / str(rounds)
        folder.mkdir()
        deaths += _killed_until_done(name, folder, rng, wanted - deaths)
    print(f"{name}: {deaths} kills in {rounds} runs")  # shown by pytest -rP


def _killed_until_done(name: str, folder: Path, rng: np.random.Generator, most: int) -> int:
    """Kill and go on until the command ends, or has been killed often enough; check what is there each time."""
    (folder / "in").mkdir()
    out = folder / "out"
    out.mkdir()
    if name in OUTPUTS:
        argv = ["ppinfer", *arguments(name, sources(folder / "in"), out)]
        made, whole = out / OUTPUTS[name][1], None
    elif name == "examples":
        made, whole = out / "e.zarr", folder / "in" / "e.zarr"
        argv = ["ppsim", *EXAMPLES, "-o", str(made)]
    else:
        made, whole = out / "log.nc", folder / "in" / "log.nc"
        argv = ["ppsim", *STUDIES[name.split(" ")[0]], "-o", str(made)]
        argv += ["--workers", "2"] * name.endswith("two processes")
    if whole is not None:
        command(argv[0], *[str(whole) if part == str(made) else part for part in argv[1:]])()
    program = [
        sys.executable,
        "-c",
        f"import sys; from {argv[0]}.cli import main; sys.exit(main(sys.argv[1:]))",
    ]
    deaths, safe = 0, 0
    while deaths < most:
        # a second or two pass before anything is written: time is counted from then on
        if not kill_at_any_time([*program, *argv[1:]], 0.3, rng, once=partial(_differs, out, _state(out))):
            break
        deaths += 1
        safe = _whole_or_not_there(out, made, safe)
    command(argv[0], *argv[1:])()
    assert names(out) == [made.name]
    if name == "examples":
        assert contents(ExampleStore(made)) == contents(ExampleStore(whole))
    elif whole is not None:
        assert read_log(made).attrs["content_sha256"] == read_log(whole).attrs["content_sha256"]
    return deaths


def _state(folder: Path) -> dict[str, tuple[int, int]]:
    try:
        return {str(item): (item.stat().st_size, item.stat().st_mtime_ns) for item in folder.rglob("*")}
    except FileNotFoundError:
        # something went while it was looked at: it is not as it was
        return {}


def _differs(folder: Path, before: dict[str, tuple[int, int]]) -> bool:
    return _state(folder) != before


def _whole_or_not_there(out: Path, made: Path, safe: int) -> int:
    """Hold what a killed command left to what it promises; return how many trials are safe."""
    recording = out / "log.recording.jsonl"
    if recording.exists() and recording.stat().st_size:
        # its first line may not be whole
        kept = len(load_recording(recording).completed) if b"\n" in recording.read_bytes() else 0
        assert kept >= safe, "a trial that was recorded is lost"
        safe = kept
    if made.suffix == ".nc" and made.exists():
        from ppinfer.studies.file_checks import validate_file

        assert validate_file(made).ok
    if made.name == "e.zarr" and made.exists():
        kept = len(ExampleStore(made)) if (made / "zarr.json").exists() else 0
        assert kept >= safe, "examples that were appended are lost"
        safe = kept
    return safe
