"""Small valid files of every format that is read, by the name of their reader: what mutations begin with."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

DATA = Path(__file__).parents[2] / "data"

MAPPING = """
title = "reaches"

[file]
delimiter = ";"

[columns]
trial = "g"
participant = "s"
time = "t"
condition = "c"
round = "n"

[agents.human]
x = "hx"
y = "hy"
true_goal = "tg"

[agents.robot]
x = "rx"
y = "ry"
vx = "rvx"
vy = "rvy"

[units]
time = "ms"
position = "cm"

[goals_file]
path = "goals.csv"
trial = "g"
goal = "goal"
x = "x"
y = "y"
from_time = "from"

[variables]
team_score = "score"
layout = {column = "place", per = "trial", kind = "text"}
busy = "busy"
collision = "hit"
finish_time = {columns = {human = "hdone", robot = "rdone"}}
"""
MEASURES = "who;robot;score\n" + "".join(
    f"p{who};{robot};{1 + (who * 7 + index * 3) % 5}.5\n"
    for who in range(5)
    for index, robot in enumerate("abc")
)
INSTRUMENT = """
title = "Fluency"
columns = {subject = "who", condition = "robot"}
anchors = {1 = "Strongly Disagree", 3 = "Neutral", 5 = "Strongly Agree"}

[items.easy]
text = "The robot was easy to work with."

[items.slow]
text = "The robot was slow."
reversed = true

[scales.fluency]
items = ["easy", "slow"]
"""
ANSWERS = "who,robot,easy,slow\n" + "".join(
    f"p{who},{robot},{1 + (who * 3 + index) % 5},{'Strongly Agree' if who == 2 else 1 + (who + index * 2) % 5}\n"
    for who in range(6)
    for index, robot in enumerate("ab")
)
GAME = """NFG 1 R "Backward bend" { "Player 1" "Player 2" }

{ { "1" "2" }
{ "1" "2" }
}
"A comment"

{
{ "11" 6, 7 }
{ "12" 6, 7 }
{ "21" 7.32, 6 }
{ "22" 1, 4/3 }
}
1 3 2 4
"""
PAYOFFS = 'NFG 1 D "Three" { "a" "b" "c" } { 2 2 1 }\n\n1 2 3 4.5 5 6 7/2 8 9 10 11 -12\n'


@dataclass(frozen=True)
class Case:
    """A reader, and how to hold it to the law."""

    name: str
    files: Mapping[str, bytes]
    read: Callable[[Path], Any]
    target: str | None = None
    options: Mapping[str, Any] = field(default_factory=dict)


def contents(folder: Path) -> dict[str, bytes]:
    """Return the content of every file below a folder, by relative name."""
    return {
        item.relative_to(folder).as_posix(): item.read_bytes()
        for item in sorted(folder.rglob("*"))
        if item.is_file()
    }


def made(make: Callable[[Path], Any]) -> dict[str, bytes]:
    """Return what a function writes into a folder."""
    with tempfile.TemporaryDirectory() as folder:
        make(Path(folder))
        return contents(Path(folder))


def converted(read: Callable[[Path], Any]) -> Callable[[Path], Any]:
    """Return a reader that refuses, as ``ppinfer convert`` does, what is no sound log."""
    from ppinfer.studies import validate_log

    def checked(path: Path) -> Any:
        log = read(path)
        replace(validate_log(log), source=str(path)).raise_if_faulty()
        return log

    return checked


def _log(name: str, log: Any) -> Case:
    from ppinfer.studies import read_log, write_log

    return Case(
        f"read_log {name}",
        made(lambda folder: write_log(log, folder / name)),
        read_log,
        name,
        {"signed": True},
    )


def logs() -> list[Case]:
    """Study logs of every kind, in both formats."""
    from ppinfer.studies import open_log
    from ppinfer.testing import example_interaction_log, example_log, example_planned_log

    small = example_log(participants=2, trials=2)
    named = [("log.nc", small), ("log.zarr", small), ("game.nc", example_interaction_log())]
    cases = [
        _log(name, log) for name, log in [*named, ("plays.nc", example_planned_log(trials=2, replans=2))]
    ]
    opened = replace(
        cases[0],
        name="open_log",
        read=lambda path: open_log(path, load=True, verify=True),
        # what it opens need not be sound: that is for validation to say
        options={"signed": True, "sound": lambda log: None},
    )
    return [*cases, opened]


def posteriors() -> list[Case]:
    """Posteriors over goals and over theta."""
    from ppinfer.goals import GoalLQR
    from ppinfer.studies import infer_log
    from ppinfer.studies.personality_inference import infer_log_personality
    from ppinfer.studies.posterior import open_posterior, write_posterior
    from ppinfer.studies.theta_posterior import read_theta_posterior, write_theta_posterior
    from ppinfer.testing import example_log, example_planned_log

    goals = infer_log(example_log(participants=2, trials=2), GoalLQR())
    theta = infer_log_personality(example_planned_log(trials=2, replans=2))
    return [
        Case(
            "open_posterior",
            made(lambda folder: write_posterior(goals, folder / "post.nc")),
            lambda path: open_posterior(path, load=True, verify=True),
            "post.nc",
            {"signed": True},
        ),
        Case(
            "read_theta_posterior",
            made(lambda folder: write_theta_posterior(theta, folder / "theta.nc")),
            read_theta_posterior,
            "theta.nc",
            {"signed": True},
        ),
    ]


def _record(path: Path) -> None:
    from ppinfer.studies import Segment, Trial
    from ppinfer.studies.recording import RecordingHeader, RecordingWriter

    rng = np.random.default_rng(2)
    header = RecordingHeader(agents=("human", "robot"), goals=("cup", "pan"), has_velocity=(True, False))
    with RecordingWriter(path, header) as recording:
        for index in range(4):
            velocity = rng.normal(size=(5, 2, 2))
            velocity[:, 1] = np.nan
            recording.append(
                Trial(
                    f"t{index}",
                    "p1",
                    time=np.arange(5) * 0.1,
                    position=rng.normal(size=(5, 2, 2)),
                    velocity=velocity,
                    goal_position=rng.normal(size=(2, 2)),
                    controller={"human": "person"},
                    segments=(Segment("human", 0, 4, "cup"),),
                    variables={"score": ((), np.float64(index), {"units": "1"})},
                )
            )


def recordings() -> list[Case]:
    """A recording, read as a log and as trials; and one that is resumed."""
    from ppinfer.studies.recording import load_recording, read_recording
    from ppinfer.studies.recording_lines import trial_line

    def lines(path: Path) -> Any:
        recording = load_recording(path)
        return recording.header, {trial_line(trial, recording.header) for trial in recording.trials}

    def kept(found: Any, original: Any) -> bool:
        # trials may be lost, visibly or with whole lines, but none is another than was recorded
        return bool(found[0] == original[0] and found[1] <= original[1])

    files = made(lambda folder: _record(folder / "study.jsonl"))
    return [
        Case("load_recording", files, lines, None, {"signed": True, "same": kept}),
        Case("read_recording", files, converted(read_recording)),
    ]


def tables() -> list[Case]:
    """Tidy tables, CSV and Parquet, with the mapping and the table of goals beside them; and measures."""
    import pyarrow.csv as arrow_csv
    import pyarrow.parquet as pq

    from ppinfer.studies import read_tidy
    from ppinfer.studies.readers.mapping import FileOptions
    from ppinfer.studies.statistics.reading import read_measures
    from ppinfer.studies.surveys.instrument import Instrument
    from ppinfer.studies.surveys.reading import read_survey

    rows = ["g;s;t;c;n;hx;hy;tg;rx;ry;rvx;rvy;score;place;busy;hit;hdone;rdone"]
    for trial in range(3):
        rows += [
            f"{trial};p{trial};{100 * step};near;{trial};{step};{2 * step};{'cup' if step else ''};{-step};0;1.5;-.5"
            f";{2.5 * trial};{'ab'[trial % 2]};{step};{step % 2};{100 * trial};"
            for step in range(6)
        ]
    text = "\n".join(rows) + "\n"
    goals = "g;goal;x;y;from\n" + "".join(
        f"{trial};{goal};{trial}.5;{index};0\n"
        for trial in range(3)
        for index, goal in enumerate(("cup", "pan"))
    )

    def parquet(folder: Path) -> None:
        (folder / "reaches.csv").write_text(text)
        (folder / "goals.csv").write_text(goals)
        (folder / "m.toml").write_text(MAPPING)
        table = arrow_csv.read_csv(
            folder / "reaches.csv", parse_options=arrow_csv.ParseOptions(delimiter=";")
        )
        pq.write_table(table, folder / "reaches.parquet")

    files = made(parquet)
    csv_files = {name: content for name, content in files.items() if name != "reaches.parquet"}
    parquet_files = {name: content for name, content in files.items() if name != "reaches.csv"}

    def read(path: Path) -> Any:
        return read_tidy(path, path.with_name("m.toml"))

    def measures(path: Path) -> Any:
        found = read_measures(
            path, ["score"], within=["robot"], subject="who", options=FileOptions(delimiter=";")
        )
        assert np.isfinite(found[0].values[~np.isnan(found[0].values)]).all()
        return {
            (subject, level): value
            for one in found
            for subject, row in zip(one.subjects, one.values.tolist(), strict=True)
            for level, value in zip(one.levels[0], row, strict=True)
        }

    survey = Instrument.parse(INSTRUMENT)

    def answers(path: Path) -> Any:
        found = read_survey(path, survey, keep_ids=True)
        people = [found.participants[index] for index in found.participant]
        told = zip(people, found.conditions, found.values.tolist(), strict=True)
        return {(who, condition): str(row) for who, condition, row in told}

    return [
        Case("read_survey", {"answers.csv": ANSWERS.encode()}, answers),
        Case("Instrument", {"instrument.toml": INSTRUMENT.encode()}, Instrument.load),
        Case("read_tidy csv", csv_files, converted(read), "reaches.csv", {"same": same_log_of_a_table}),
        Case(
            "read_tidy parquet",
            parquet_files,
            converted(read),
            "reaches.parquet",
            {"same": same_log_of_a_table},
        ),
        Case("read_measures", {"scores.csv": MEASURES.encode()}, measures),
    ]


def same_log_of_a_table(one: Any, other: Any) -> bool:
    """Return whether two logs say the same, but for the digest of their sources."""
    from ppinfer.testing.reader_laws import same_content

    # a folder is called as its input is numbered
    return same_content(one.assign_attrs(source=""), other.assign_attrs(source=""))


def _reaching_study(folder: Path) -> None:
    rng = np.random.default_rng(1)
    (folder / "trials").mkdir()
    for game in (1, 2):
        n = 12
        xh, xr = rng.normal(size=(2, n, 4))
        np.savez(
            folder / "trials" / f"user7_cbp_{game}.npz",
            xh=xh,
            xr=xr,
            goals=rng.normal(size=(n, 3, 4)),
            belief_nominal=np.full((n, 3), 1 / 3),
            belief_beta=np.full((n, 3, 2), 1 / 6),
            r_goal_idx=np.zeros(n, int),
            collision=np.arange(n) == 3,
            team_score=np.array(4),
            r_objective=np.array(["influence", "courtesy"] * (n // 2)),
        )
    (folder / "segments.csv").write_text(
        "user_id,robot_type,game_idx,seg,start,end,arrive,h_goal\n7,cbp,1,0,0,6,5,2\n7,cbp,2,0,1,6,6,0\n"
    )
    (folder / "trials.csv").write_text("user_id,robot_type,game_idx,T\n7,cbp,1,12\n7,cbp,2,12\n")


def _eth(folder: Path) -> None:
    lines = [
        f"{780 + 6 * step} {who} {step * 0.4 + who} 0 {who - step * 0.1} 1 0 0.5"
        for step in range(8)
        for who in (1, 2)
    ]
    (folder / "obsmat.txt").write_text("\n".join(lines) + "\n")
    (folder / "destinations.txt").write_text("5 0\n-5 0\n0 7.5\n")


def folders() -> list[Case]:
    """The reaching study's folder and an ETH scene: synthetic ones, and a part of the real ones where they are."""
    from ppinfer.studies.readers.eth import read_eth
    from ppinfer.studies.readers.reaching_study import read_reaching_study

    cases = [
        Case(
            "read_reaching_study",
            made(_reaching_study),
            converted(read_reaching_study),
            "",
            {"same": same_log_of_a_table},
        ),
        Case("read_eth", made(_eth), converted(read_eth), ""),
    ]
    root = Path(os.environ.get("PPINFER_DATA", "/nowhere"))
    if (root / "eth-pedestrians").is_dir():
        real = contents(root / "eth-pedestrians")
        real["obsmat.txt"] = b"\n".join(real["obsmat.txt"].split(b"\n")[:400]) + b"\n"
        cases.append(Case("read_eth real", real, converted(read_eth), ""))
    if (root / "reaching-study").is_dir():
        real = contents(root / "reaching-study")
        games = [name for name in real if name.endswith(".npz")][:2]
        some = {name: real[name] for name in games} | {"segments.csv": b"", "trials.csv": b""}
        stems = [Path(name).stem.removeprefix("user").split("_") for name in games]
        wanted = {(stem[0], "_".join(stem[1:-1]), stem[-1]) for stem in stems}
        for name in ("segments.csv", "trials.csv"):
            head, *rows = real[name].decode().splitlines()
            columns = head.split(",")
            where = [columns.index(column) for column in ("user_id", "robot_type", "game_idx")]
            kept = [row for row in rows if tuple(row.split(",")[index] for index in where) in wanted]
            some[name] = "\n".join([head, *kept, ""]).encode()
        cases.append(
            Case(
                "read_reaching_study real",
                some,
                converted(read_reaching_study),
                "",
                {"same": same_log_of_a_table},
            )
        )
    return cases


def models() -> list[Case]:
    """Models as TOML, learned weights, stores of examples, and games."""
    from ppinfer.games import read_nfg
    from ppinfer.goals import GoalLQR
    from ppinfer.goals.configuration import read_model, write_model
    from ppinfer.studies.prediction_examples import ExampleStore
    from ppinfer.testing.prediction_examples import example_store

    def store(path: Path) -> Any:
        found = ExampleStore(path)
        examples = found.read(0, len(found))
        parts = [
            found.kinds(0, len(found)),
            examples.human,
            examples.plan,
            examples.goals,
            examples.frequency,
        ]
        return str(found.header), found.interaction(0, len(found)), [part.tolist() for part in parts]

    def game(path: Path) -> Any:
        found = read_nfg(path)
        return found.players, [(axis.name, axis.labels) for axis in found.plans], found.costs.tolist()

    cases = [
        Case(
            "read_model", made(lambda folder: write_model(GoalLQR(), folder / "model.toml", {})), read_model
        ),
        Case("ExampleStore", made(lambda folder: example_store(folder / "e.zarr", 6)), store, "e.zarr"),
        Case("read_nfg outcomes", {"bend.nfg": GAME.encode()}, game),
        Case("read_nfg payoffs", {"three.nfg": PAYOFFS.encode()}, game),
    ]
    try:
        import safetensors  # noqa: F401
        import torch
    except ImportError:
        return cases
    from ppinfer.goals.learned import GoalPredictor, NetworkConfiguration, read_predictor, write_predictor
    from ppinfer.goals.learned.network import build_network, weights_of

    configuration = NetworkConfiguration(past=4, horizon=8, hidden=8)
    torch.manual_seed(0)
    predictor = GoalPredictor(configuration, build_network(configuration))

    def weights(path: Path) -> Any:
        found = read_predictor(path)
        return found.configuration, {
            name: array.tolist() for name, array in weights_of(found.network).items()
        }

    files = made(lambda folder: write_predictor(predictor, folder / "w.safetensors"))
    return [*cases, Case("read_predictor", files, weights, None, {"signed": True})]


def shipped() -> list[Case]:
    """The logs that the repository holds."""
    from ppinfer.studies import read_log

    return [
        Case(f"read_log {path.name}", {path.name: path.read_bytes()}, read_log, None, {"signed": True})
        for path in sorted(DATA.glob("*.nc"))
    ]


GROUPS: dict[str, tuple[Callable[[], list[Case]], tuple[str, ...]]] = {
    "logs": (
        logs,
        ("read_log log.nc", "read_log log.zarr", "read_log game.nc", "read_log plays.nc", "open_log"),
    ),
    "posteriors": (posteriors, ("open_posterior", "read_theta_posterior")),
    "recordings": (recordings, ("load_recording", "read_recording")),
    "tables": (tables, ("read_tidy csv", "read_tidy parquet", "read_measures", "read_survey", "Instrument")),
    "folders": (folders, ("read_reaching_study", "read_eth", "read_reaching_study real", "read_eth real")),
    "models": (
        models,
        ("read_model", "ExampleStore", "read_nfg outcomes", "read_nfg payoffs", "read_predictor"),
    ),
    "shipped": (
        shipped,
        ("read_log arms-small.nc", "read_log reach-games-small.nc", "read_log reaching-small.nc"),
    ),
}
"""What makes the cases of a kind, and their names: made when a test wants one, not when tests are collected."""


@cache
def group(name: str) -> dict[str, Case]:
    """Return the cases of a group by name, and hold that the names are those announced."""
    make, names = GROUPS[name]
    cases = {case.name: case for case in make()}
    assert set(cases) <= set(names), name
    return cases


def case(name: str) -> Case | None:
    """Return a case; None where it needs data or an extra that is not here."""
    return next(group(kind).get(name) for kind, (_, names) in GROUPS.items() if name in names)
