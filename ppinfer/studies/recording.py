"""A study while it runs: one trial a line, flushed to the disk, so that a crash costs the trial in hand.

The first line describes the study; every line carries the CRC-32 of the rest of itself.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType

import xarray as xr

from ppinfer.errors import LogError
from ppinfer.studies.checksums import file_sha256
from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.recording_lines import (
    LINE_PREFIX,
    RecordingHeader,
    header_line,
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
        self._completed: dict[str, None] = {}
        line = header_line(header)
        if not self.path.parent.is_dir():
            raise LogError(f"{self.path}: there is no folder {str(self.path.parent)!r}; make it first")
        content = self.path.read_bytes() if self.path.exists() else None
        if content is not None and not resume:
            raise LogError(f"{self.path}: exists; resume it, or record to another name")
        keep = 0 if content is None else self._length_kept(content, line)
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

    def _length_kept(self, content: bytes, line: bytes) -> int:
        """Return how many bytes of an earlier recording are sound (0: not even its header)."""
        if content != line and line.startswith(content):
            self.dropped = "line 1: a torn header: dropped" if content else ""
            return 0
        if not content.startswith(line):
            raise LogError(
                f"{self.path}: is a recording of another study (its header differs); record to another name"
            )
        recording = load_recording(self.path)
        self._completed, self.dropped = dict.fromkeys(recording.completed), recording.dropped
        return content.rfind(b"\n") + 1


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
    try:
        content = source.read_bytes()
    except OSError as error:
        raise LogError(f"{source}: cannot be read: {error.strerror}") from error
    faults = Faults()
    lines = content.split(b"\n")
    # a whole recording ends with a newline; what follows the last one was being written
    torn = lines.pop()
    if not lines:
        raise LogError(f"{source}: is not a recording: it has no whole line")
    if not any(LINE_PREFIX.encode() in line for line in lines):
        raise LogError(f"{source}: is not a recording: none of its lines begins with a checksum")
    header: RecordingHeader | None = None
    trials: list[Trial] = []
    for number, line in enumerate(lines, start=1):
        try:
            told = told_line(line)
            if number == 1:
                header = told_header(told)
            elif header is not None:
                trials.append(told_trial(told, header))
        except (LogError, ValueError, TypeError, KeyError, IndexError, AttributeError) as error:
            text = f"missing {error}" if isinstance(error, KeyError) else str(error)
            faults.add(
                Fault("damaged-line", text, "restore the line from a copy", file=source.name, line=number)
            )
            if number == 1:
                break
    faults.raise_if_any(str(source))
    if header is None:
        raise LogError(f"{source}: is not a recording")
    dropped = f"line {len(lines) + 1}: torn after {len(torn)} bytes: dropped" if torn else ""
    return Recording(header, tuple(trials), dropped)


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
    return log_of_recording(
        recording.header, recording.trials, {"source_sha256": file_sha256(path), "notes": notes}
    )


def is_recording(path: Path) -> bool:
    """Return whether a file begins as a recording does."""
    try:
        with path.open("rb") as file:
            return file.read(len(LINE_PREFIX)) == LINE_PREFIX.encode()
    except OSError:
        return False
