"""Writing a posterior file block by block, in flat memory, all or nothing."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Literal

import numpy as np
import xarray as xr
from jaxtyping import Float, Int, Shaped

from ppinfer.errors import LogError
from ppinfer.studies.checksums import ContentDigest
from ppinfer.studies.posterior_layout import (
    POSTERIOR_FORMAT,
    POSTERIOR_FORMAT_VERSION,
    READ_OPTIONS,
    STRING,
    AttrValue,
    posterior_variables,
    segment_faults,
)
from ppinfer.studies.replacing import replacing
from ppinfer.studies.schema import DIGEST_ATTR

if TYPE_CHECKING:
    import h5netcdf

_CHUNK_BYTES = 1 << 19


class PosteriorWriter:
    """A context manager that writes ``POST.nc`` in blocks of samples.

    Everything goes to a temporary name in the same directory. Leaving the block without an exception
    finishes the file (content digest, then an atomic rename); any exception removes it, so that a
    half-written posterior never exists under its own name.

    Parameters
    ----------
    path
        Where the finished file goes; an existing file is replaced.
    n_samples
        Samples of all trials together.
    goals, space
        Labels of the goals and of the coordinates of a position.
    goal_position_dims
        Whether ``goal_position`` and ``goal_present`` are given once a trial (in `write_trials`) or for
        every sample (in `write_samples`).
    attrs
        What the posterior is (``hypothesis``, ``agent``, ``mode``, ``model``, ``configuration``, ``seed``,
        ...): text and numbers.
    has_outliers
        Whether `write_samples` will be given ``outlier``.
    position_units
        Units of ``position`` and ``goal_position``.

    Raises
    ------
    LogError
        If the directory is missing, a block has a wrong shape or is out of order, a posterior is NaN or
        positive, or the block is left before everything was written.

    Examples
    --------
    >>> import tempfile
    >>> directory = tempfile.TemporaryDirectory()
    >>> path = Path(directory.name) / "post.nc"
    >>> with PosteriorWriter(path, n_samples=2, goals=["cup", "pan"], space=["x", "y"],
    ...                      goal_position_dims="trial", attrs={"agent": "human"}, has_outliers=False) as out:
    ...     out.write_trials(trial_id=["t0"], row_size=[2], participant=["p1"],
    ...                      goal_position=np.array([[[0.0, 1.0], [1.0, 0.0]]]), goal_present=[[1, 1]])
    ...     out.write_samples(0, time=np.array([0.0, 0.1]), position=np.zeros((2, 2)),
    ...                       observed=np.ones(2, np.int8), log_posterior=np.log(np.full((2, 2), 0.5)))
    ...     out.write_segments(trial=[0], start=[0], stop=[2], true_goal=["cup"])
    >>> path.exists()
    True
    >>> directory.cleanup()
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        n_samples: int,
        goals: Sequence[str],
        space: Sequence[str],
        goal_position_dims: Literal["trial", "sample"],
        attrs: Mapping[str, AttrValue],
        has_outliers: bool,
        position_units: str = "m",
    ) -> None:
        self.path = Path(path)
        if n_samples < 1:
            raise LogError(f"{self.path}: a posterior needs at least one sample, got n_samples={n_samples}")
        if goal_position_dims not in ("trial", "sample"):
            raise LogError(
                f"{self.path}: goal_position_dims is 'trial' or 'sample', got {goal_position_dims!r}"
            )
        self._sizes: dict[str, int] = {"sample": n_samples, "goal": len(goals), "space": len(space)}
        self._goal_position_dims = goal_position_dims
        self._specs = posterior_variables(goal_position_dims)
        self._units = {"position": position_units, "goal_position": position_units}
        self._attrs: dict[str, AttrValue] = {
            "Conventions": "CF-1.11",
            "featureType": "trajectory",
            "ppinfer_format": POSTERIOR_FORMAT,
            "ppinfer_format_version": POSTERIOR_FORMAT_VERSION,
        }
        self.set_attrs(attrs)
        self._labels = {"goal": list(goals), "space": list(space)}
        self._has_outliers = has_outliers
        self._digest = ContentDigest()
        self._next_sample = 0
        self._row_size: Int[np.ndarray, " trial"] | None = None
        self._place = contextlib.ExitStack()
        self._open: h5netcdf.File | None = None

    def __enter__(self) -> PosteriorWriter:
        import h5netcdf

        if not self.path.parent.is_dir():
            raise LogError(f"{self.path}: there is no folder {str(self.path.parent)!r}; make it first")
        if self.path.is_dir():
            raise LogError(f"{self.path}: is a folder; a posterior is one file")
        self._temporary = self._place.enter_context(replacing(self.path))
        try:
            self._open = h5netcdf.File(self._temporary, "w")
            self._open.dimensions = {name: self._sizes[name] for name in ("sample", "goal", "space")}
            for name, labels in self._labels.items():
                self._write_whole(name, labels)
        except BaseException as error:
            self.__exit__(type(error), error, error.__traceback__)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if error is None:
                self._finish()
        except BaseException as late:
            self._give_up()
            self._place.__exit__(type(late), late, late.__traceback__)
            raise
        self._give_up()
        # the temporary file takes its place, or vanishes where there was an error
        self._place.__exit__(kind, error, trace)

    def set_attrs(self, attrs: Mapping[str, AttrValue] | None = None, /, **more: AttrValue) -> None:
        """Set attributes of the file, at any time before it is finished (text or numbers)."""
        given: dict[str, object] = {**(attrs or {}), **more}
        for name, value in given.items():
            plain = value.item() if isinstance(value, np.generic) else value
            if not isinstance(plain, str | int | float):
                raise LogError(
                    f"{self.path}: attribute {name!r} is of type {type(value).__name__}; text or a number is "
                    "expected (write lists and mappings as JSON text)"
                )
            # NetCDF has no booleans
            self._attrs[name] = int(plain) if isinstance(plain, bool) else plain

    def write_samples(
        self,
        start: int,
        *,
        time: Float[np.ndarray, " sample"],
        position: Float[np.ndarray, "sample space"],
        observed: Shaped[np.ndarray, " sample"],
        log_posterior: Float[np.ndarray, "sample goal"],
        goal_position: Float[np.ndarray, "sample goal space"] | None = None,
        goal_present: Shaped[np.ndarray, "sample goal"] | None = None,
        outlier: Shaped[np.ndarray, " sample"] | None = None,
    ) -> None:
        """Write the next block of samples; ``start`` is the index of its first one (blocks come in order)."""
        if start != self._next_sample:
            raise LogError(
                f"{self.path}: blocks come in order: expected start={self._next_sample}, got {start}"
            )
        stop = start + len(time)
        if stop > self._sizes["sample"]:
            raise LogError(f"{self.path}: samples {start} to {stop} of n_samples={self._sizes['sample']}")
        block: dict[str, Shaped[np.ndarray, "*shape"] | None] = {
            "time": time,
            "position": position,
            "observed": observed,
            "log_posterior": log_posterior,
        }
        self._expect("outlier", outlier, self._has_outliers, "has_outliers")
        if outlier is not None:
            block["outlier"] = outlier
        moving = self._goal_position_dims == "sample"
        for name, values in (("goal_position", goal_position), ("goal_present", goal_present)):
            self._expect(
                name, values, moving, f"goal_position_dims={self._goal_position_dims!r}, in write_samples"
            )
            if values is not None:
                block[name] = values
        # a sum of numbers <= 0 is NaN exactly when one of them is
        if len(time) and (np.isnan(log_posterior.sum()) or log_posterior.max() > 1e-9):
            bad = int(np.flatnonzero(~(log_posterior <= 1e-9).all(axis=1))[0])
            raise LogError(
                f"{self.path}: log_posterior of sample {start + bad} is {log_posterior[bad].tolist()}; "
                "logarithms of probabilities are expected (<= 0, -inf for an absent goal, never NaN)"
            )
        for name, values in block.items():
            self._write_rows(name, np.asarray(values), start, stop)
        self._next_sample = stop

    def write_trials(
        self,
        *,
        trial_id: Sequence[str] | Shaped[np.ndarray, " trial"],
        row_size: Sequence[int] | Int[np.ndarray, " trial"],
        participant: Sequence[str] | Shaped[np.ndarray, " trial"],
        condition: Sequence[str] | Shaped[np.ndarray, " trial"] | None = None,
        round: Sequence[int] | Int[np.ndarray, " trial"] | None = None,
        goal_position: Float[np.ndarray, "trial goal space"] | None = None,
        goal_present: Shaped[np.ndarray, "trial goal"] | Sequence[Sequence[int]] | None = None,
    ) -> None:
        """Write what belongs to trials, once; the ``row_size`` must add up to ``n_samples``."""
        if self._row_size is not None:
            raise LogError(f"{self.path}: write_trials is called once")
        sizes = np.asarray(row_size, np.int64)
        if sizes.size == 0 or sizes.min() < 1 or sizes.sum() != self._sizes["sample"]:
            raise LogError(
                f"{self.path}: row_size holds {sizes.size} trials of {int(sizes.sum())} samples; at least "
                f"one trial, each of at least one sample, {self._sizes['sample']} together, are expected"
            )
        self._new_dimension("trial", sizes.size)
        still = self._goal_position_dims == "trial"
        given = {"trial_id": trial_id, "row_size": sizes, "participant": participant}
        optional = {"condition": condition, "round": round}
        for name, values in (("goal_position", goal_position), ("goal_present", goal_present)):
            self._expect(
                name, values, still, f"goal_position_dims={self._goal_position_dims!r}, in write_trials"
            )
            optional[name] = values  # type: ignore[assignment]
        for name, value in {
            **given,
            **{key: item for key, item in optional.items() if item is not None},
        }.items():
            self._write_whole(name, value)
        self._row_size = sizes

    def write_segments(
        self,
        *,
        trial: Sequence[int] | Int[np.ndarray, " segment"],
        start: Sequence[int] | Int[np.ndarray, " segment"],
        stop: Sequence[int] | Int[np.ndarray, " segment"],
        true_goal: Sequence[str] | Shaped[np.ndarray, " segment"],
    ) -> None:
        """Write the segments of the inferred agent, once; not needed where the log has none."""
        if "segment" in self._sizes:
            raise LogError(f"{self.path}: write_segments is called once")
        self._new_dimension("segment", len(trial))
        self._segments = (
            np.asarray(trial, np.int64),
            np.asarray(start, np.int64),
            np.asarray(stop, np.int64),
            np.asarray(true_goal, object),
        )
        for name, values in zip(
            ("segment_trial", "segment_start", "segment_stop", "true_goal"), self._segments, strict=True
        ):
            self._write_whole(name, values)

    @property
    def _file(self) -> h5netcdf.File:
        if self._open is None:
            raise LogError(
                f"{self.path}: the posterior is not open; write inside 'with PosteriorWriter(...)'"
            )
        return self._open

    def _expect(self, name: str, values: object, expected: bool, because: str) -> None:
        if (values is not None) != expected:
            raise LogError(f"{self.path}: {name} is {'missing' if expected else 'given'}, against {because}")

    def _new_dimension(self, name: str, size: int) -> None:
        self._sizes[name] = size
        # netCDF has no fixed dimension of size 0: an unlimited one that stays empty stands for it
        self._file.dimensions[name] = size or None

    def _variable(self, name: str) -> h5netcdf.Variable:
        if name in self._file.variables:
            return self._file.variables[name]
        import h5py

        spec = self._specs[name]
        shape = tuple(self._sizes[dim] for dim in spec.dims)
        storage: dict[str, object] = {}
        dtype: object = h5py.string_dtype()
        if spec.dtype != STRING:
            dtype = np.dtype(spec.dtype)
            if 0 not in shape:
                row_bytes = np.dtype(spec.dtype).itemsize * int(np.prod(shape[1:]))
                storage["chunks"] = (max(1, min(shape[0], _CHUNK_BYTES // row_bytes)), *shape[1:])
                storage["fletcher32"] = True
                if spec.compress:
                    storage |= {"compression": "gzip", "compression_opts": 1, "shuffle": True}
        variable = self._file.create_variable(name, spec.dims, dtype, **storage)
        for key, text in spec.attrs:
            variable.attrs[key] = text
        if name in self._units:
            variable.attrs["units"] = self._units[name]
        return variable

    def _checked(
        self, name: str, values: Shaped[np.ndarray, "*shape"], rows: int
    ) -> Shaped[np.ndarray, "*shape"]:
        spec = self._specs[name]
        shape = (rows, *(self._sizes[dim] for dim in spec.dims[1:]))
        if values.shape != shape:
            raise LogError(
                f"{self.path}: {name}({', '.join(spec.dims)}) has shape {values.shape}; expected {shape}"
            )
        return values.astype(object if spec.dtype == STRING else spec.dtype, copy=False)

    def _write_rows(self, name: str, values: Shaped[np.ndarray, "*shape"], start: int, stop: int) -> None:
        checked = self._checked(name, values, stop - start)
        if stop > start:
            self._variable(name)[start:stop] = checked
            self._digest.update(name, checked)

    def _write_whole(self, name: str, values: object) -> None:
        spec = self._specs[name]
        array = np.asarray(values, dtype=object if spec.dtype == STRING else spec.dtype)
        checked = self._checked(name, array, self._sizes[spec.dims[0]])
        variable = self._variable(name)
        if checked.size:
            variable[...] = checked
        self._digest.update(name, checked)

    def _finish(self) -> None:
        if self._next_sample != self._sizes["sample"]:
            raise LogError(
                f"{self.path}: {self._next_sample} of n_samples={self._sizes['sample']} samples were written"
            )
        if self._row_size is None:
            raise LogError(f"{self.path}: write_trials was not called")
        if "segment" not in self._sizes:
            self.write_segments(trial=[], start=[], stop=[], true_goal=[])
        faults = segment_faults(self._row_size, *self._segments, goals=self._labels["goal"])
        if faults:
            raise LogError(f"{self.path}: {faults[0]}")
        for name, value in self._attrs.items():
            self._file.attrs[name] = value
        self._file.close()
        self._open = None
        self._sign()

    def _sign(self) -> None:
        import h5netcdf

        # the running digests hold the samples; names, types and attributes are as a reader will see them
        with xr.open_dataset(self._temporary, engine="h5netcdf", **READ_OPTIONS) as written:
            signature = self._digest.hexdigest(written)
        with h5netcdf.File(self._temporary, "a") as file:
            file.attrs[DIGEST_ATTR] = signature

    def _give_up(self) -> None:
        if self._open is not None:
            # the file is given up: whatever closing it says must not hide the error that led here
            with contextlib.suppress(Exception):
                self._open.close()
        self._open = None
