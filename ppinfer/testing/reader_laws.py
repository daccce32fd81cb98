"""The law that every reader obeys: a mutated file is read faithfully or refused clearly, and nothing else happens."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ppinfer.errors import PPInferError
from ppinfer.testing.mutations import Mutation, mutate
from ppinfer.testing.reader_trials import Bounds, Outcome, attempts

_LISTED = 8
_LONGEST_MESSAGE = 3000


@dataclass(frozen=True)
class ReaderTally:
    """What a reader did with mutated inputs.

    Parameters
    ----------
    inputs, refused, faithful
        How many there were, how many were refused, and how many read as they are.
    slowest
        Seconds that the slowest took.
    most_memory
        Bytes that the largest took beyond what there was before (0 where the system does not tell).
    guarded
        How many hung or crashed what read them, and were refused because `ppinfer.guarding` has another process for
        that.
    """

    inputs: int
    refused: int
    faithful: int
    slowest: float
    most_memory: int
    guarded: int = 0


def check_reader(
    read: Callable[[Path], Any],
    files: Mapping[str, bytes],
    *,
    target: str | None = None,
    inputs: int = 100,
    seed: int = 0,
    first: int = 0,
    signed: bool = False,
    same: Callable[[Any, Any], bool] | None = None,
    sound: Callable[[Any], None] | None = None,
    mutations: Callable[[Mapping[str, bytes], np.random.Generator], Mutation] = mutate,
    seconds: int = 20,
    memory: int = 1 << 30,
) -> ReaderTally:
    """Hold a reader to the law, on inputs that are mutated from valid files.

    Each input is read faithfully (what is read is sound; it equals the original where only the way of writing was
    changed, and, in formats that are signed, whatever bytes were damaged) or refused by a `PPInferError` of one line
    that names a file. There is no other exception, no warning, nothing printed, nothing written, and no process that
    hangs, eats the memory or dies: the inputs are read in a child process with limits (so the system has to have
    ``fork``). An input that hangs or crashes even so is read once more as users read it, by the process of
    `ppinfer.guarding`, and has to be refused there.

    Parameters
    ----------
    read
        The reader, from the path of a file or folder.
    files
        Valid content, by name within a folder. All of them are written, and mutated.
    target
        Which name within the folder is handed to the reader; by default the only file, else the folder.
    inputs
        How many mutations to try.
    seed, first
        Input i is made by ``numpy.random.default_rng([seed, i])``, and i begins with `first`: a failure names it.
    signed
        Whether the format has a checksum of all it says.
    same
        Tells whether what was read equals the original; by default variables and attributes of a dataset, else ``==``.
    sound
        Raises where what was read is not what it may be; by default `validate_log` on a dataset that says it is a log.
    mutations
        What mutates the files.
    seconds, memory
        CPU seconds that an input may take, and bytes beyond what there is.

    Returns
    -------
    ReaderTally
        How many were refused and read, and the slowest and largest.

    Raises
    ------
    AssertionError
        Listing the first inputs that break the law, with what was done to them.
    PPInferError
        Where the system has no ``fork``.

    Examples
    --------
    >>> from ppinfer.studies import read_log, write_log
    >>> from ppinfer.testing import example_log
    >>> write_log(example_log(participants=1, trials=1), "log.nc")
    >>> valid = {"log.nc": Path("log.nc").read_bytes()}
    >>> check_reader(read_log, valid, inputs=5, signed=True).inputs
    5
    """
    if not hasattr(os, "fork"):
        raise PPInferError("check_reader needs a system that can fork a process (Linux or macOS)")
    target = target if target is not None else (next(iter(files)) if len(files) == 1 else "")
    judge = _Judge(read, files, target, signed, same or same_content, sound or check_sound, mutations)
    outcomes: list[Outcome] = []
    broken: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        for outcome in attempts(
            lambda index: judge.judged(Path(folder, str(index)), np.random.default_rng([seed, index])),
            judge.prepare,
            range(first, first + inputs),
            Bounds(seconds, memory),
        ):
            outcomes.append(outcome)
            if outcome.broken:
                broken.append(f"input {outcome.index} of seed {seed} ({outcome.name}): {outcome.broken}")
    told = "\n".join(broken[:_LISTED])
    assert not broken, f"{len(broken)} of {inputs} inputs break the law; the first:\n{told}"
    return ReaderTally(
        inputs=len(outcomes),
        refused=sum(outcome.refused for outcome in outcomes),
        faithful=sum(not outcome.refused for outcome in outcomes),
        slowest=max((outcome.seconds for outcome in outcomes), default=0.0),
        most_memory=max((outcome.memory for outcome in outcomes), default=0),
        guarded=sum(outcome.ended for outcome in outcomes),
    )


@dataclass
class _Judge:
    read: Callable[[Path], Any]
    files: Mapping[str, bytes]
    target: str
    signed: bool
    same: Callable[[Any, Any], bool]
    sound: Callable[[Any], None]
    mutations: Callable[[Mapping[str, bytes], np.random.Generator], Mutation]
    original: Any = None

    def prepare(self) -> None:
        """Read what is valid; a reader that cannot has nothing to be compared with."""
        with tempfile.TemporaryDirectory() as folder:
            self.original = self.read(put(self.files, Path(folder), self.target))
            self.sound(self.original)

    def judged(self, folder: Path, rng: np.random.Generator) -> tuple[str, bool, str]:
        """Return what the input is, whether it was refused, and how the law was broken, if it was."""
        mutation = self.mutations(self.files, rng)
        path = put(mutation.files, folder, self.target)
        before = _state(folder)
        try:
            found = self.read(path)
        except PPInferError as error:
            return mutation.name, True, self._refusal(mutation, folder, str(error)) or _left(folder, before)
        except Exception as error:
            text = " ".join(str(error).split())[:300]
            return mutation.name, False, f"{type(error).__name__} instead of a PPInferError: {text}"
        return mutation.name, False, self._faith(mutation, found) or _left(folder, before)

    def _refusal(self, mutation: Mutation, folder: Path, text: str) -> str:
        if mutation.effect == "same":
            return f"refused, but it says what it said: {text}"
        names = {
            folder.name,
            *(part for name in (*mutation.files, self.target) for part in name.split("/") if part),
        }
        if not any(name in text for name in names):
            return f"refused without naming a file: {text}"
        if len(text.splitlines()) != 1 or not text.isprintable():
            return f"refused in more than one line of text: {text!r}"
        return f"refused in {len(text)} letters" if len(text) > _LONGEST_MESSAGE else ""

    def _faith(self, mutation: Mutation, found: Any) -> str:
        if mutation.effect == "same" or (mutation.effect == "damage" and self.signed):
            return "" if self.same(found, self.original) else "read as something else, without a word"
        try:
            self.sound(found)
        except Exception as error:
            return f"read, but unsound: {' '.join(str(error).split())[:300]}"
        return ""


def put(files: Mapping[str, bytes], folder: Path, target: str) -> Path:
    """Write files below a folder; return the path of the target.

    Examples
    --------
    >>> put({"a/b.txt": b"1"}, Path("here"), "a").name
    'a'
    """
    folder.mkdir(exist_ok=True)
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return folder / target if target else folder


def _state(folder: Path) -> dict[str, tuple[int, int]]:
    return {str(item): (item.stat().st_size, item.stat().st_mtime_ns) for item in folder.rglob("*")}


def _left(folder: Path, before: dict[str, tuple[int, int]]) -> str:
    after = _state(folder)
    changed = [name for name in {*before, *after} if before.get(name) != after.get(name)]
    return f"reading wrote {Path(changed[0]).name}" if changed else ""


def same_content(one: Any, other: Any) -> bool:
    """Return whether two things that were read say the same: variables and attributes of datasets, else ``==``.

    Attributes that the second has not are not looked at: a name that was damaged is one of these.

    Examples
    --------
    >>> same_content(xr.Dataset(attrs={"a": 1, "b": 2}), xr.Dataset(attrs={"a": 1}))
    True
    """
    if not isinstance(one, xr.Dataset):
        return bool(one == other)
    kept = {name: value for name, value in one.attrs.items() if name in other.attrs and "sha256" not in name}
    wanted = {name: value for name, value in other.attrs.items() if "sha256" not in name}
    return bool(
        one.assign_attrs().drop_attrs(deep=False).identical(other.drop_attrs(deep=False))
        and {name: str(value) for name, value in kept.items()}
        == {name: str(value) for name, value in wanted.items()}
    )


def check_sound(found: Any) -> None:
    """Raise `FaultyLogError` where a dataset says that it is a study log and is not a sound one.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> check_sound(example_log())
    """
    from ppinfer.studies import validate_log

    if isinstance(found, xr.Dataset) and found.attrs.get("ppinfer_format") == "study-log":
        validate_log(found).raise_if_faulty()
