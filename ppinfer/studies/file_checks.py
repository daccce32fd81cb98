"""One check for every file that ppinfer writes: study logs, recordings and posteriors."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from ppinfer import guarding
from ppinfer.errors import LogError
from ppinfer.studies.faults import Fault, Faults, FaultyLogError, Report
from ppinfer.studies.progress import ProgressCallback, silent
from ppinfer.studies.recording import is_recording, joined, load_recording
from ppinfer.studies.storage import stated_format, stated_hypothesis
from ppinfer.studies.validation import validate_log


def validate_file(path: str | os.PathLike[str], *, progress: ProgressCallback = silent) -> Report:
    """Find everything that is wrong with a study log, a recording or a posterior.

    It is read by another process, under limits of time and memory (see `ppinfer.guarding`).

    Parameters
    ----------
    path
        What to check; what kind it is, is read from it.
    progress
        Told how many samples of a log are checked, of how many.

    Returns
    -------
    Report
        As `validate_log` gives it; a torn last line of a recording is a warning.

    Examples
    --------
    >>> print(validate_file("nowhere.nc").faults[0])
    nowhere.nc: there is no such file
    """
    source = Path(path)
    try:
        told = guarding.asked("validate-file", source, progress=progress)
    except LogError as error:
        return unreadable_report(source, error)
    if told is not None:
        return Report.from_json(told["report"])
    if is_recording(source):
        return _recording_report(source, progress)
    if stated_format(source) == "posterior":
        return _posterior_report(source)
    return validate_log(source, progress=progress)


def unreadable_report(source: Path, error: LogError) -> Report:
    """Return the report of a file that cannot be read at all.

    Examples
    --------
    >>> print(unreadable_report(Path("log.nc"), LogError("log.nc: is a pipe; give a file")).faults[0])
    log.nc: is a pipe; give a file
    """
    return Report.of(str(source), Faults([_unreadable(source, error)]), Faults())


def _recording_report(source: Path, progress: ProgressCallback) -> Report:
    warnings = Faults()
    try:
        recording = load_recording(source)
        if recording.dropped:
            warnings.add(
                Fault("torn-line", recording.dropped, "the trial in hand was lost", file=source.name)
            )
        if not recording.trials:
            raise LogError(f"{source}: holds no whole trial")
        log = joined(recording, source)
    except FaultyLogError as error:
        faults = Faults(error.faults)
        faults.counts.update({kind: count - faults.counts[kind] for kind, count in error.counts.items()})
        return Report.of(str(source), faults, warnings)
    except LogError as error:
        return Report.of(str(source), Faults([_unreadable(source, error)]), warnings)
    report = validate_log(log, progress=progress)
    return replace(
        report,
        source=str(source),
        warnings=(*warnings.listed, *report.warnings),
        warning_counts={**warnings.counts, **report.warning_counts},
    )


def _posterior_report(source: Path) -> Report:
    from ppinfer.studies.posterior import open_posterior
    from ppinfer.studies.theta_posterior import HYPOTHESIS, read_theta_posterior

    try:
        if stated_hypothesis(source) == HYPOTHESIS:
            sizes = {str(name): size for name, size in read_theta_posterior(source).sizes.items()}
            return Report.of(str(source), Faults(), Faults(), sizes)
        with open_posterior(source, verify=True) as posterior:
            sizes = {str(name): size for name, size in posterior.sizes.items()}
    except LogError as error:
        return Report.of(str(source), Faults([_unreadable(source, error)]), Faults())
    return Report.of(str(source), Faults(), Faults(), sizes)


def _unreadable(source: Path, error: LogError) -> Fault:
    return Fault("unreadable", str(error).removeprefix(f"{source}: "), file=str(source))
