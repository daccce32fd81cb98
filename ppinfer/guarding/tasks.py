"""What the helper process can be asked to do: a fixed table of functions that read, never anything else."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ppinfer.guarding.limits import Limits


@dataclass(frozen=True)
class Task:
    """A function that reads, by name, and what is loaded before any file is looked at: libraries, and what those load.

    ``prepare`` names a function of the same module that uses the libraries once, on a file that it makes itself.
    The function is called with the path, the limits, a progress callback, and what else the request holds by keyword;
    what it returns has to be JSON.
    """

    module: str
    function: str
    libraries: tuple[str, ...] = ()
    prepare: str = ""

    def load(self) -> Callable[..., Any]:
        """Import the function."""
        found: Callable[..., Any] = getattr(importlib.import_module(self.module), self.function)
        return found

    def preload(self) -> None:
        """Import whatever the function will need."""
        self.load()
        for name in self.libraries:
            importlib.import_module(name)
        if self.prepare:
            getattr(importlib.import_module(self.module), self.prepare)()


_STUDIES = "ppinfer.studies"
_READING = f"{_STUDIES}.guarded_reading"
_NETCDF = ("h5py", "h5netcdf", "xarray")
_TABLES = (
    "encodings.utf_8_sig",
    "pyarrow.compute",
    "pyarrow.csv",
    "pyarrow.parquet",
    f"{_STUDIES}.readers.mapping",
    f"{_STUDIES}.readers.tables",
)
_EACH = ("reaching_study", "eth", "tidy", "tidy_goals", "tidy_samples", "tidy_segments")
_READERS = (*(f"{_STUDIES}.readers.{name}" for name in _EACH), f"{_STUDIES}.recording")

TASKS: dict[str, Task] = {
    "log": Task(_READING, "walk_log", _NETCDF, "open_example"),
    "validate-log": Task(_READING, "report_of_log", (*_NETCDF, f"{_STUDIES}.validation"), "open_example"),
    "validate-file": Task(_READING, "report_of_file", (*_NETCDF, f"{_STUDIES}.file_checks"), "open_example"),
    "stated": Task(_READING, "stated_attributes", _NETCDF),
    "posterior": Task(_READING, "walk_posterior", (*_NETCDF, f"{_STUDIES}.posterior"), "open_example"),
    "theta-posterior": Task(
        _READING, "walk_theta_posterior", (*_NETCDF, f"{_STUDIES}.theta_posterior"), "open_example"
    ),
    "study": Task(_READING, "walk_study", (*_TABLES, *_READERS)),
    "table": Task(_READING, "walk_table", _TABLES),
    "recording": Task(_READING, "walk_recording", (f"{_STUDIES}.recording",)),
    "recording-lines": Task(_READING, "walk_recording_lines", (f"{_STUDIES}.recording",)),
    "examples": Task(_READING, "walk_examples", ("zarr", f"{_STUDIES}.prediction_examples")),
    "misbehave": Task("ppinfer.guarding.misbehaving", "misbehave"),
}
"""Every task by its name."""


def run_task(
    name: str, path: str, limits: Limits, told: dict[str, Any], progress: Callable[[int, int], None]
) -> Any:
    """Run a task on a file."""
    return TASKS[name].load()(path, limits=limits, progress=progress, **told)
