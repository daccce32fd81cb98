"""What a report is about: a log or posterior, checked before anything is read from it."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from ppinfer.errors import LogError
from ppinfer.studies.checksums import file_sha256
from ppinfer.studies.faults import Report
from ppinfer.studies.file_checks import validate_file
from ppinfer.studies.posterior_layout import POSTERIOR_FORMAT
from ppinfer.studies.recording import is_recording, read_recording
from ppinfer.studies.storage import stated_format, stated_hypothesis, write_signed
from ppinfer.studies.theta_posterior import HYPOTHESIS

Kind = Literal["log", "goal posterior", "theta posterior"]
# not what was written: nothing of it can be believed, not even how long it is
_DAMAGE = ("unreadable", "checksum", "damaged-line")
# what a data sheet is read from is not there, or not as it should be
_BROKEN = ("format", "missing-variable", "wrong-dimensions", "wrong-type", "empty", "wrong-length")


@dataclass(frozen=True)
class Source:
    """A file to report on.

    Attributes
    ----------
    given
        As it was named.
    path
        What to read: the same, or of a recording the log that it makes.
    kind
        What is in it.
    checked
        What its checks found.
    sha256
        Of what was given.
    """

    given: Path
    path: Path
    kind: Kind
    checked: Report
    sha256: str

    @property
    def is_whole(self) -> bool:
        """Whether its variables are all there in their shapes, so that sizes and times can be told."""
        return not any(kind in self.checked.fault_counts for kind in _BROKEN)


@contextmanager
def open_source(path: Path) -> Iterator[Source]:
    """Check a file and yield what it is; a recording is made a log of, for as long as this lasts.

    Raises
    ------
    LogError
        If it cannot be read, is damaged (its content does not match its checksum), or is an unsound posterior.
    """
    checked = validate_file(path)
    if len(checked.faults) == 1 and checked.faults[0].kind == "unreadable":
        raise LogError(f"{path}: {checked.faults[0].message}")
    if any(kind in checked.fault_counts for kind in _DAMAGE):
        checked.raise_if_faulty()
    sha256 = file_sha256(path)
    if is_recording(path):
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder, "log.nc")
            write_signed(read_recording(path), log)
            yield Source(path, log, "log", checked, sha256)
        return
    yield Source(path, path, _kind(path), checked, sha256)


def _kind(path: Path) -> Kind:
    if path.is_dir() or stated_format(path) != POSTERIOR_FORMAT:
        return "log"
    return "theta posterior" if stated_hypothesis(path) == HYPOTHESIS else "goal posterior"
