"""The 2023 reaching study: a person's wrist and a robot among goals, an ``.npz`` file a game of 45 s."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Shaped

from ppinfer.errors import LogError
from ppinfer.studies.checksums import file_sha256
from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.progress import ProgressCallback, silent
from ppinfer.studies.readers.npz import read_npz
from ppinfer.studies.readers.text_shape import check_lines
from ppinfer.studies.trials import Segment, Trial, log_of_trials

AGENTS = ("human", "robot")
SAMPLES_PER_SECOND = 10
"""The study logged no timestamps; its loop ran at about 10 Hz."""

_NAME = re.compile(r"user(?P<user>[^_]+)_(?P<robot>.+)_(?P<round>\d+)\.npz")

# array in the file -> (name in the log, dimensions of the log after trial, meaning)
_PER_SAMPLE: dict[str, tuple[str, tuple[str, ...], str]] = {
    "belief_nominal": (
        "logged_belief_nominal",
        ("sample", "goal"),
        "the study's own belief over the human's goal, without the robot's plan",
    ),
    "belief_robot": (
        "logged_belief_robot",
        ("sample", "goal"),
        "the study's own belief over the human's goal, given the robot's plan",
    ),
    "belief_beta": (
        "logged_belief_rationality",
        ("sample", "goal", "rationality"),
        "the study's own joint belief over goal and rationality",
    ),
    "r_goal_idx": ("robot_goal_index", ("sample",), "index of the goal that the robot heads for"),
    "h_goal_reached": ("human_pick", ("sample",), "index of the goal that the human picks here; -1 = none"),
    "r_goal_reached": ("robot_pick", ("sample",), "index of the goal that the robot picks here; -1 = none"),
    "is_robot_waiting": ("is_robot_waiting", ("sample",), "1 = the robot waits"),
    "is_human_waiting": ("is_human_waiting", ("sample",), "1 = the human waits"),
    "collision": ("collision", ("sample",), "1 = the two collide"),
    "r_objective": ("robot_objective", ("sample",), "what the robot's plan aims at"),
}
_PER_TRIAL: dict[str, tuple[str, str]] = {
    "team_score": ("team_score", "goals picked by both together"),
    "n_collisions": ("n_collisions", "collisions in the trial"),
}
_REQUIRED = ("xh", "xr", "goals")
_SEGMENT_COLUMNS = ("user_id", "robot_type", "game_idx", "start", "arrive", "h_goal")


@dataclass(frozen=True)
class _Game:
    name: str
    user: str
    robot: str
    round: int
    arrays: Mapping[str, Shaped[np.ndarray, "*_"]]

    @property
    def n_samples(self) -> int:
        return int(self.arrays["xh"].shape[0])


def read_reaching_study(folder: str | os.PathLike[str], *, progress: ProgressCallback = silent) -> xr.Dataset:
    """Read the reaching study's folder.

    It holds ``trials/user<ID>_<robot>_<n>.npz``, ``segments.csv`` and ``trials.csv``. A game is a trial with
    agents ``human`` and ``robot``, in workspace units and at 10 Hz. A row of ``segments.csv`` is a human
    segment [start, arrive) whose ``true_goal`` is ``h_goal``; rows with arrive <= start are left out and
    listed in the attribute ``notes``. An agent's velocity that is zero throughout the study while the agent
    moves was not logged (``has_velocity`` is 0).

    Parameters
    ----------
    folder
        Where the study is.
    progress
        Told how many games are read, of how many.

    Raises
    ------
    FaultyLogError
        Listing everything wrong with the folder: files that cannot be read or that hold pickled objects,
        arrays that are missing or of the wrong shape, rows of the tables that do not fit the games.

    Examples
    --------
    >>> read_reaching_study("nowhere")
    Traceback (most recent call last):
        ...
    ppinfer.errors.LogError: nowhere: has no trials/*.npz; give the folder of the reaching study
    """
    source = Path(folder)
    faults, notes = Faults(), Faults()
    files = sorted((source / "trials").glob("*.npz")) if source.is_dir() else []
    if not files:
        raise LogError(f"{source}: has no trials/*.npz; give the folder of the reaching study")
    games: dict[str, _Game] = {}
    for done, path in enumerate(files, start=1):
        game = _read_game(path, source, faults)
        if game is not None:
            games[game.name] = game
        progress(done, len(files))
    _check_goal_counts(games, faults)
    unread = {path.stem for path in files} - set(games)
    _check_lengths(source / "trials.csv", games, unread, faults, notes)
    segments = _read_segments(source / "segments.csv", games, unread, faults, notes)
    faults.raise_if_any(str(source))

    kept = [name for name in _PER_SAMPLE if all(name in game.arrays for game in games.values())]
    kept += [name for name in _PER_TRIAL if all(name in game.arrays for game in games.values())]
    for name in (*_PER_SAMPLE, *_PER_TRIAL):
        lacking = [game.name for game in games.values() if name not in game.arrays]
        if lacking:
            notes.add(
                Fault(
                    "array-left-out", f"{name} is left out: {len(lacking)} games lack it, first {lacking[0]}"
                )
            )
    objectives = sorted(
        {str(text) for game in games.values() for text in np.unique(game.arrays.get("r_objective", []))}
    )
    trials = [_trial(game, kept, objectives, segments.get(game.name, [])) for game in games.values()]
    has_velocity = [_has_velocity(trials, index, agent, notes) for index, agent in enumerate(AGENTS)]
    trials = [_without_unlogged_velocity(trial, has_velocity) for trial in trials]
    return log_of_trials(
        trials,
        agents=AGENTS,
        goals=[str(index) for index in range(next(iter(games.values())).arrays["goals"].shape[1])],
        has_velocity=has_velocity,
        title="Reaching study",
        source=source.resolve().name,
        position_units="workspace unit",
        configuration={"reader": "reaching-study", "dt": 1 / SAMPLES_PER_SECOND},
        attrs={"source_sha256": file_sha256(source), "notes": "\n".join(notes.lines())},
    )


def _read_game(path: Path, source: Path, faults: Faults) -> _Game | None:
    file = path.relative_to(source).as_posix()
    match = _NAME.fullmatch(path.name)
    if match is None:
        faults.add(
            Fault("file-name", "expected user<ID>_<robot>_<number>.npz", "rename or remove it", file=file)
        )
        return None
    before = faults.total
    arrays = read_npz(path, file, faults)
    if arrays is None or faults.total > before:
        return None
    for name in _REQUIRED:
        if name not in arrays:
            faults.add(
                Fault(
                    "missing-array",
                    f"there is no such array; it has {sorted(arrays)}",
                    file=file,
                    column=name,
                )
            )
    if faults.total > before:
        return None
    count, n_goals = arrays["xh"].shape[:1], arrays["goals"].shape[1:2]
    expected: dict[str, tuple[int, ...]] = {
        "xh": (*count, 4),
        "xr": (*count, 4),
        "goals": (*count, *n_goals, 4),
    }
    expected |= dict.fromkeys(("belief_nominal", "belief_robot"), (*count, *n_goals))
    expected |= {name: count for name, (_, dims, _) in _PER_SAMPLE.items() if dims == ("sample",)}
    expected |= dict.fromkeys(_PER_TRIAL, ())
    if "belief_beta" in arrays:
        expected["belief_beta"] = (*count, *n_goals, *arrays["belief_beta"].shape[2:3])
    for name, shape in expected.items():
        if name in arrays and (arrays[name].shape != shape or (len(shape) == 0 and name in _REQUIRED)):
            faults.add(
                Fault(
                    "wrong-shape", f"has shape {arrays[name].shape}, expected {shape}", file=file, column=name
                )
            )
        elif name in arrays and (arrays[name].dtype.kind not in ("U" if name == "r_objective" else "biuf")):
            faults.add(
                Fault("wrong-type", f"holds values of type {arrays[name].dtype}", file=file, column=name)
            )
    if count == (0,):
        faults.add(Fault("empty", "the game has no samples", "remove it", file=file, column="xh"))
    if faults.total > before:
        return None
    return _Game(path.stem, match["user"], match["robot"], int(match["round"]), arrays)


def _check_goal_counts(games: Mapping[str, _Game], faults: Faults) -> None:
    counts = {game.name: game.arrays["goals"].shape[1] for game in games.values()}
    if len(set(counts.values())) > 1:
        usual = max(set(counts.values()), key=list(counts.values()).count)
        for name, count in counts.items():
            if count != usual:
                faults.add(
                    Fault(
                        "wrong-shape",
                        f"has {count} goals, other games have {usual}",
                        trial=name,
                        column="goals",
                    )
                )


def _rows(path: Path, columns: Sequence[str], faults: Faults) -> list[tuple[int, dict[str, str]]]:
    try:
        if not check_lines(path, faults):
            return []
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file, strict=True)
            header = list(reader.fieldnames or [])
            missing = [name for name in columns if name not in header]
            if missing:
                told = f"there are no columns {missing}; it has {header}"
                faults.add(Fault("missing-column", told, file=path.name, line=1))
                return []
            rows = []
            for row in reader:
                if None in row or None in row.values():
                    told = f"has another number of cells than the header's {len(header)}"
                    faults.add(Fault("wrong-length", told, file=path.name, line=reader.line_num))
                else:
                    rows.append((reader.line_num, row))
            return rows
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        faults.add(Fault("unreadable", f"cannot be read: {error}", file=path.name))
        return []


def _whole(row: Mapping[str, str], column: str, line: int, file: str, faults: Faults) -> int | None:
    try:
        # tables that went through a spreadsheet write 3 as 3.0
        value = float(row[column])
        if value == int(value):
            return int(value)
    except (ValueError, OverflowError):
        pass
    told = f"expected a whole number, got {row[column]!r}"
    faults.add(Fault("not-a-number", told, file=file, line=line, column=column))
    return None


def _check_lengths(
    path: Path, games: Mapping[str, _Game], unread: set[str], faults: Faults, notes: Faults
) -> None:
    if not path.exists():
        notes.add(
            Fault("no-table", "there is no such file; the games' lengths were not checked", file=path.name)
        )
        return
    listed = set()
    for line, row in _rows(path, ("user_id", "robot_type", "game_idx", "T"), faults):
        length = _whole(row, "T", line, path.name, faults)
        name = f"user{row['user_id']}_{row['robot_type']}_{row['game_idx']}"
        listed.add(name)
        if name not in games:
            if name not in unread:
                faults.add(Fault("missing-file", f"there is no trials/{name}.npz", file=path.name, line=line))
        elif length is not None and length != games[name].n_samples:
            told = f"says {length} samples, trials/{name}.npz has {games[name].n_samples}"
            faults.add(Fault("wrong-length", told, file=path.name, line=line, column="T"))
    unlisted = sorted(set(games) - listed)
    if unlisted:
        notes.add(
            Fault("unlisted", f"does not list {len(unlisted)} games, first {unlisted[0]}", file=path.name)
        )


def _read_segments(
    path: Path, games: Mapping[str, _Game], unread: set[str], faults: Faults, notes: Faults
) -> dict[str, list[Segment]]:
    if not path.exists():
        notes.add(
            Fault(
                "no-table", "there is no such file; the log has no segments to be scored on", file=path.name
            )
        )
        return {}
    segments: dict[str, list[Segment]] = {}
    for line, row in _rows(path, _SEGMENT_COLUMNS, faults):
        start, arrive, goal = (
            _whole(row, name, line, path.name, faults) for name in ("start", "arrive", "h_goal")
        )
        name = f"user{row['user_id']}_{row['robot_type']}_{row['game_idx']}"
        if name not in games:
            if name not in unread:
                faults.add(Fault("missing-file", f"there is no trials/{name}.npz", file=path.name, line=line))
            continue
        if start is None or arrive is None or goal is None:
            continue
        game = games[name]
        if not 0 <= goal < game.arrays["goals"].shape[1]:
            told = f"is {goal}, the game has goals 0 to {game.arrays['goals'].shape[1] - 1}"
            faults.add(Fault("unknown-goal", told, file=path.name, line=line, column="h_goal"))
        elif start < 0 or max(start, arrive) > game.n_samples:
            told = f"[{start}, {arrive}) leaves the game's {game.n_samples} samples"
            faults.add(Fault("segment-range", told, file=path.name, line=line, trial=name, column="start"))
        elif arrive <= start:
            told = f"arrive {arrive} <= start {start}: left out"
            notes.add(Fault("segment-left-out", told, file=path.name, line=line, trial=name))
        else:
            segments.setdefault(name, []).append(Segment("human", start, arrive, str(goal)))
    return segments


def _trial(game: _Game, kept: Sequence[str], objectives: Sequence[str], segments: Sequence[Segment]) -> Trial:
    both = np.stack([game.arrays["xh"], game.arrays["xr"]], axis=1).astype(np.float64)
    variables: dict[str, tuple[Any, ...]] = {}
    for name in kept:
        array = game.arrays[name]
        if name in _PER_TRIAL:
            told, meaning = _PER_TRIAL[name]
            variables[told] = ((), array.astype(np.int64), {"long_name": meaning})
            continue
        told, dims, meaning = _PER_SAMPLE[name]
        attrs: dict[str, Any] = {"long_name": meaning}
        if name == "r_objective":
            array = np.searchsorted(np.array(objectives), array).astype(np.int8)
            attrs |= {"flag_values": np.arange(len(objectives), dtype=np.int8)}
            attrs |= {"flag_meanings": " ".join(text.replace(" ", "_") or "none" for text in objectives)}
        variables[told] = (dims, array, attrs)
    return Trial(
        trial_id=game.name,
        participant=game.user,
        condition=game.robot,
        round=game.round,
        # a quotient, so that sample 3 is at 0.3 and not at 0.30000000000000004
        time=np.arange(game.n_samples) / SAMPLES_PER_SECOND,
        position=both[:, :, [0, 2]],
        velocity=both[:, :, [1, 3]],
        goal_position=game.arrays["goals"][:, :, [0, 2]].astype(np.float64),
        controller={"human": "person", "robot": game.robot},
        segments=segments,
        variables=variables,
    )


def _has_velocity(trials: Sequence[Trial], index: int, agent: str, notes: Faults) -> bool:
    moved = any((trial.position[1:, index] != trial.position[:-1, index]).any() for trial in trials)
    logged = any((trial.velocity[:, index] != 0).any() for trial in trials if trial.velocity is not None)
    if moved and not logged:
        notes.add(
            Fault(
                "velocity-not-logged",
                f"velocities of {agent!r} are all 0 while it moves: taken as not logged",
            )
        )
    return logged or not moved


def _without_unlogged_velocity(trial: Trial, has_velocity: Sequence[bool]) -> Trial:
    if trial.velocity is None or all(has_velocity):
        return trial
    velocity = trial.velocity.copy()
    velocity[:, ~np.array(has_velocity)] = np.nan
    return replace(trial, velocity=velocity)
