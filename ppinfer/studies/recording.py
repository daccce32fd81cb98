"""A study while it runs: one trial a line, flushed to the disk, so that a crash costs the trial in hand.

The first line describes the study; every line carries the CRC-32 of the rest of itself.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType

import xarray as xr

from ppinfer import guarding
from ppinfer.errors import LogError
from ppinfer.studies.checksums import file_sha256
from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.recording_lines import (
    LINE_PREFIX,
    RecordingHeader,
    header_line,
    lines_of,
    log_of_recording,
    told_header,
    told_line,
    told_trial,
    trial_line,
)
from ppinfer.studies.trials import Trial
from ppinfer.studies.validation import validate_log


@dataclass(frozen=True)
class Recording:
    """A recording as it was read: header, trials, and what was dropped at its end (empty = nothing)."""

    header: RecordingHeader
    trials: tuple[Trial, ...]
    dropped: str = ""

    @property
    def completed(self) -> tuple[str, ...]:
        """Ids of the trials that are safe."""
        return tuple(trial.trial_id for trial in self.trials)


class RecordingWriter:
    """Appends trials to a recording; each is on the disk when `append` returns.

    Parameters
    ----------
    path
        The recording; a new one is begun unless ``resume``.
    header
        What the study is.
    resume
        Whether to continue a recording that is there: its header must be this one, a torn last line is cut
        off, and ``completed`` says which trials need not be run again. Without a file it begins one.

    Attributes
    ----------
    dropped : str
        What was cut off a resumed recording; empty if nothing.

    Raises
    ------
    LogError
        If the file exists and ``resume`` is false, belongs to another study, or is damaged before its last
        line.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> header = RecordingHeader(agents=("human",))
    >>> trial = Trial("a", "p1", time=np.array([0.0, 0.1]), position=np.zeros((2, 1, 2)))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "study.jsonl")
    ...     with RecordingWriter(path, header) as recording:
    ...         recording.append(trial)
    ...     with RecordingWriter(path, header, resume=True) as recording:
    ...         recording.completed
    ('a',)
    """

    def __init__(
        self, path: str | os.PathLike[str], header: RecordingHeader, *, resume: bool = False
    ) -> None:
        self.path = Path(path)
        self.header = header
        self.dropped = ""
        self._resumed = resume
        self._completed: dict[str, None] = {}
        line = header_line(header)
        if not self.path.parent.is_dir():
            raise LogError(f"{self.path}: there is no folder {str(self.path.parent)!r}; make it first")
        there = self.path.exists()
        if there and not resume:
            raise LogError(f"{self.path}: exists; resume it, or record to another name")
        keep = 0
        if there:
            with guarding.admitted("recording-lines", self.path):
                keep = self._length_kept(line)
        self._file = self.path.open("r+b" if keep else "wb")
        try:
            self._file.truncate(keep)
            self._file.seek(keep)
            if not keep:
                self._put(line)
        except BaseException:
            self._file.close()
            raise

    @property
    def completed(self) -> tuple[str, ...]:
        """Ids of the trials recorded so far, in order."""
        return tuple(self._completed)

    def __enter__(self) -> RecordingWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; everything appended is already on the disk."""
        self._file.close()
        if not self._resumed:
            guarding.remember_written(self.path)

    def append(self, trial: Trial) -> None:
        """Write one trial and wait until it is on the disk.

        Raises
        ------
        LogError
            If the trial is unsound by itself (shapes, times, numbers, labels) or its id was recorded before;
            nothing is written.
        """
        if trial.trial_id in self._completed:
            raise LogError(f"{self.path}: trial {trial.trial_id!r} was recorded before; ids are unique")
        # once for both the check and the line
        table = trial.replan_table(agents=self.header.agents, theta=self.header.theta)
        trial = replace(trial, replans=table)
        validate_log(log_of_recording(self.header, [trial])).raise_if_faulty()
        self._put(trial_line(trial, self.header))
        self._completed[trial.trial_id] = None

    def _put(self, line: bytes) -> None:
        self._file.write(line)
        self._file.flush()
        os.fsync(self._file.fileno())

    def _length_kept(self, header: bytes) -> int:
        """Return how many bytes of an earlier recording are sound (0: not even its header)."""
        with self.path.open("rb") as file:
            start = file.read(len(header))
            if start != header:
                if header.startswith(start) and not file.read(1):
                    self.dropped = "line 1: a torn header: dropped" if start else ""
                    return 0
                raise LogError(
                    f"{self.path}: is a recording of another study (its header differs); record to another name"
                )
            keep = len(header)
            for number, line in enumerate(lines_of(file, str(self.path), first=2), start=2):
                if not line.endswith(b"\n"):
                    self.dropped = _torn(number, line)
                    break
                try:
                    self._completed[str(told_line(line[:-1])["trial_id"])] = None
                except (ValueError, TypeError, KeyError):
                    # says which lines are damaged, this one among them
                    load_recording(self.path)
                    raise
                keep += len(line)
        return keep


def load_recording(path: str | os.PathLike[str]) -> Recording:
    """Read a recording, also one that a crash has cut off.

    Returns
    -------
    Recording
        Header, trials, and what was dropped: a last line that is torn.

    Raises
    ------
    FaultyLogError
        Listing each damaged line but the last, and each trial that does not fit the header.

    Examples
    --------
    >>> trial = Trial("a", "p1", time=np.array([0.0, 0.1]), position=np.zeros((2, 1, 2)))
    >>> with RecordingWriter("study.jsonl", RecordingHeader(agents=("human",))) as recording:
    ...     recording.append(trial)
    >>> [trial.trial_id for trial in load_recording("study.jsonl").trials]
    ['a']
    """
    source = Path(path)
    with guarding.admitted("recording", source):
        return _loaded(source)


def _loaded(source: Path) -> Recording:
    faults = Faults()
    header: RecordingHeader | None = None
    trials: list[Trial] = []
    # a trial is checked against the header once all are read: its line is needed then
    lines: list[int] = []
    dropped, number, known = "", 0, False
    try:
        with source.open("rb") as file:
            for number, line in enumerate(lines_of(file, str(source)), start=1):
                # a whole recording ends with a newline; what follows the last one was being written
                if not line.endswith(b"\n"):
                    dropped = _torn(number, line)
                    number -= 1
                    break
                known = known or LINE_PREFIX.encode() in line
                try:
                    told = told_line(line[:-1])
                    if number == 1:
                        header = told_header(told)
                    elif header is not None:
                        trials.append(told_trial(told))
                        lines.append(number)
                except _DAMAGE as error:
                    faults.add(_damaged(source, number, error))
    except OSError as error:
        raise LogError(f"{source}: cannot be read: {error.strerror}") from error
    if not number:
        raise LogError(f"{source}: is not a recording: it has no whole line")
    if not known:
        raise LogError(f"{source}: is not a recording: none of its lines begins with a checksum")
    if header is not None:
        _check_trials(header, trials, lines, source, faults)
    faults.raise_if_any(str(source))
    if header is None:
        raise LogError(f"{source}: is not a recording")
    return Recording(header, tuple(trials), dropped)


# whatever a line that was changed may lead to
_DAMAGE = (
    LogError,
    ValueError,
    TypeError,
    KeyError,
    IndexError,
    AttributeError,
    OverflowError,
    RecursionError,
)
_CHECKED_TOGETHER = 64


def _check_trials(
    header: RecordingHeader, trials: list[Trial], lines: list[int], source: Path, faults: Faults
) -> None:
    """Report trials that do not fit the header; many at a time, since nearly all of them do."""
    for start in range(0, len(trials), _CHECKED_TOGETHER):
        some = trials[start : start + _CHECKED_TOGETHER]
        try:
            log_of_recording(header, some)
        except _DAMAGE:
            for trial, number in zip(some, lines[start:], strict=False):
                try:
                    log_of_recording(header, [trial])
                except _DAMAGE as error:
                    faults.add(_damaged(source, number, error))


def _damaged(source: Path, number: int, error: Exception) -> Fault:
    text = f"missing {error}" if isinstance(error, KeyError) else str(error)
    return Fault("damaged-line", text, "restore the line from a copy", file=source.name, line=number)


def _torn(number: int, line: bytes) -> str:
    return f"line {number}: torn after {len(line)} bytes: dropped"


def read_recording(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a recording as a study log; a torn last line is dropped, and said so in the attribute ``notes``.

    Raises
    ------
    FaultyLogError
        Listing the damaged lines.
    LogError
        If it is no recording, or holds no whole trial.

    Examples
    --------
    >>> trial = Trial("a", "p1", time=np.array([0.0, 0.1]), position=np.zeros((2, 1, 2)))
    >>> with RecordingWriter("game.jsonl", RecordingHeader(agents=("human",))) as recording:
    ...     recording.append(trial)
    >>> read_recording("game.jsonl").sizes["sample"]
    2
    """
    recording = load_recording(path)
    if not recording.trials:
        raise LogError(f"{path}: holds no whole trial")
    notes = f"{Path(path).name}: {recording.dropped}" if recording.dropped else ""
    return joined(recording, path, {"source_sha256": file_sha256(path), "notes": notes})


def joined(
    recording: Recording, path: str | os.PathLike[str], attrs: Mapping[str, str] | None = None
) -> xr.Dataset:
    """Return the log of the trials that were loaded from a file.

    Raises
    ------
    LogError
        If the trials do not fit together, each of which fits the header: some lack a variable, for example.
    """
    try:
        return log_of_recording(recording.header, recording.trials, attrs)
    except _DAMAGE as error:
        raise LogError(f"{path}: its trials do not fit together: {error}") from error


def is_recording(path: Path) -> bool:
    """Return whether a file begins as a recording does."""
    try:
        # a pipe is none, and opening it would wait for ever
        if not path.is_file():
            return False
        with path.open("rb") as file:
            return file.read(len(LINE_PREFIX)) == LINE_PREFIX.encode()
    except OSError:
        return False
