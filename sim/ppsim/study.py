"""Many trials: played side by side or one after another, recorded as they end, and compacted to a log."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

import xarray as xr

from ppinfer.guarding import refuse_special
from ppinfer.studies import RecordingHeader, RecordingWriter, Trial, read_recording, write_log
from ppinfer.studies.progress import ProgressCallback, silent
from ppinfer.studies.recording_lines import header_line, log_of_recording
from ppinfer.studies.storage import check_target
from ppsim.errors import SimulationError
from ppsim.workers import follow_the_parent


@runtime_checkable
class Study(Protocol):
    """A study that can be simulated: trial i is a function of the study and of i alone."""

    def header(self) -> RecordingHeader:
        """Return what the recording says once."""
        ...

    def trial(self, index: int) -> Trial:
        """Play one trial."""
        ...


@dataclass(frozen=True)
class Recorded:
    """What was recorded: the log, and how many of its trials an earlier, interrupted recording already held."""

    log: xr.Dataset
    resumed: int


def simulate(
    study: Study, indices: Sequence[int], *, workers: int = 1, cluster: str | None = None
) -> Iterator[Trial]:
    """Yield trials in the order of their indices, whoever of the workers played them.

    Raises
    ------
    SimulationError
        Where there are no workers, or the cluster is not there.

    Examples
    --------
    >>> from ppsim.reaching import ReachingStudy
    >>> [trial.trial_id for trial in simulate(ReachingStudy(duration=1.0), range(2))]
    ['p1-0', 'p2-0']
    """
    if workers < 1:
        raise SimulationError(f"workers must be at least 1; got {workers}")
    if cluster is not None:
        # imported here: it is an extra
        from ppsim.cluster import simulate_on_cluster

        yield from simulate_on_cluster(study, indices, cluster)
        return
    if workers == 1 or len(indices) < 2:
        yield from map(study.trial, indices)
        return
    # fresh processes: a forked one may inherit locks that a thread held
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(workers, len(indices)), mp_context=context, initializer=follow_the_parent)
    try:
        yield from pool.map(study.trial, indices, chunksize=min(4, -(-len(indices) // workers)))
    finally:
        pool.shutdown(cancel_futures=True)


def log_of_study(study: Study, indices: Sequence[int]) -> xr.Dataset:
    """Play some trials of a study and return their log, in memory.

    Examples
    --------
    >>> from ppsim.reaching import ReachingStudy
    >>> log_of_study(ReachingStudy(duration=1.0), range(2)).sizes["trial"]
    2
    """
    return log_of_recording(study.header(), list(simulate(study, indices)))


def recording_path(target: str | os.PathLike[str]) -> Path:
    """Return where trials are recorded on their way to a log.

    Examples
    --------
    >>> recording_path("LOG.nc").name
    'LOG.recording.jsonl'
    """
    path = Path(target)
    return path.parent / f"{path.stem}.recording.jsonl"


def record_study(
    study: Study,
    trials: int,
    target: str | os.PathLike[str],
    *,
    workers: int = 1,
    cluster: str | None = None,
    resume: bool = True,
    progress: ProgressCallback = silent,
) -> Recorded:
    """Simulate a study and write its log.

    1. Each trial is appended to a recording beside the log as it ends (`recording_path`); one that an interrupted run
       of the same study left there is continued, if `resume`.
    2. The recording is compacted to the log, whole or not at all, and removed.

    Parameters
    ----------
    study : Study
        What to simulate.
    trials : int
        How many.
    target : path
        The log, ``.nc`` or ``.zarr``.
    workers : int
        Processes that play trials; the log does not depend on it.
    cluster : str, optional
        Address of the scheduler of a Dask cluster that plays the trials instead; nor does it depend on that.
    resume : bool
        Whether to continue a recording that is there; if not, one that holds trials is refused.
    progress : callable
        Told how many trials are done, of how many.

    Raises
    ------
    SimulationError
        Where there are no trials or workers, the cluster is not there, or the recording there is longer than asked for
        or not to be continued.
    LogError
        Where the log cannot be written, or the recording there is of another study.

    Examples
    --------
    >>> import tempfile
    >>> from ppsim.reaching import ReachingStudy
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     record_study(ReachingStudy(duration=2.0), 3, Path(folder, "log.nc")).log.sizes["trial"]
    3
    """
    check_target(Path(target))
    for name, count in (("trials", trials), ("workers", workers)):
        if count < 1:
            raise SimulationError(f"{name} must be at least 1; got {count}")
    path = recording_path(target)
    header = study.header()
    if path.exists() and not resume and not _holds_nothing(path, header):
        raise SimulationError(
            f"{path}: an interrupted study left it; go on with it (--resume), or remove it to start anew"
        )
    with _no_empty(path, header), RecordingWriter(path, header, resume=True) as recording:
        resumed = len(recording.completed)
        if resumed > trials:
            raise SimulationError(
                f"{path}: already holds {resumed} trials of this study, more than the {trials} asked for; ask for as "
                "many, or remove it"
            )
        progress(resumed, trials)
        # nothing is left for workers to do once the generator is closed
        with _closing(simulate(study, range(resumed, trials), workers=workers, cluster=cluster)) as played:
            for done, trial in enumerate(played, start=resumed + 1):
                recording.append(trial)
                progress(done, trials)
    log = read_recording(path)
    # they tell of the recording, which is about to go
    for name in ("source_sha256", "notes"):
        del log.attrs[name]
    write_log(log, target)
    path.unlink()
    return Recorded(log, resumed)


@contextmanager
def _no_empty(path: Path, header: RecordingHeader) -> Iterator[None]:
    """Where it fails before the first trial is whole, leave nothing that would be in the way of the next try."""
    try:
        yield
    except BaseException:
        if path.exists() and _holds_nothing(path, header):
            path.unlink()
        raise


def _holds_nothing(path: Path, header: RecordingHeader) -> bool:
    """Whether a recording is of this study and has no whole trial: one that was killed, or that filled the disk."""
    line = header_line(header)
    refuse_special(path)
    with path.open("rb") as recording:
        return line.startswith(recording.read(len(line))) and not recording.readline().endswith(b"\n")


@contextmanager
def _closing(played: Iterator[Trial]) -> Iterator[Iterator[Trial]]:
    try:
        yield played
    finally:
        if hasattr(played, "close"):
            played.close()
