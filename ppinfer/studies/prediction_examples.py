"""Prediction examples on disk: a Zarr v3 store that grows as they come, read in parts."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Float, Int

from ppinfer import guarding
from ppinfer.errors import LogError, PPInferError
from ppinfer.goals.learned import PredictionExamples
from ppinfer.studies.replacing import temporary_beside
from ppinfer.studies.storage import told_as_log_error

FORMAT, VERSION = "prediction-examples", 1
_REMEDY = "generate it again with 'ppsim examples'"


@dataclass(frozen=True)
class ExampleHeader:
    """What a store of examples says once.

    Parameters
    ----------
    past, horizon, goals : int
        Steps of motion so far and of the plan, and the most goals that an example has.
    states : int
        Entries of a state.
    dynamics : str
        What states hold, as in `ppinfer.goals.Dynamics.named`.
    dt : float
        Seconds of a step.
    state_weight, control_weight : float
        Q and R of the robot whose plans these are.
    kinds : tuple of str
        Kinds of simulated humans, named by the number that each example has.
    batch : int
        Examples that are generated, and stored, together.
    configuration : dict
        Whatever else made them, as JSON can hold it.
    """

    past: int
    horizon: int
    goals: int
    states: int
    dynamics: str
    dt: float
    state_weight: float
    control_weight: float
    kinds: tuple[str, ...]
    batch: int
    configuration: dict[str, Any]


@dataclass(frozen=True, eq=False)
class StoredExamples:
    """Examples with what is known of how they came about.

    Parameters
    ----------
    examples : PredictionExamples
        What is learned from.
    kind : (example,) int
        Which kind of human it was.
    interaction : (example,) float32
        Seconds of interaction that were simulated for it.
    """

    examples: PredictionExamples
    kind: Int[np.ndarray, " example"]
    interaction: Float[np.ndarray, " example"]

    def __len__(self) -> int:
        return len(self.examples)

    def take(self, which: slice) -> StoredExamples:
        """Return some of them."""
        return StoredExamples(self.examples.take(which), self.kind[which], self.interaction[which])


_DTYPES = {
    "human": "float32", "robot": "float32", "plan": "float32", "goals": "float32", "present": "bool",
    "frequency": "float32", "robot_goal": "int16", "kind": "int16", "interaction": "float32",
}  # fmt: skip
_MISSING: dict[str, float | int | bool] = {"f": np.nan, "i": -1, "b": False}


class ExampleWriter:
    """Appends examples to a store; what was appended before an interruption is kept.

    Parameters
    ----------
    path : path
        A folder whose name ends in ``.zarr``.
    header : ExampleHeader
        What the store says once.
    resume : bool
        Whether to go on with a store of the same header that is there; if not, one that is there is refused.

    Raises
    ------
    LogError
        Where something else is there, or examples that were made otherwise.

    Examples
    --------
    >>> from ppinfer.testing.prediction_examples import example_header, example_predictions
    >>> examples = example_predictions(5)
    >>> stored = StoredExamples(examples, np.zeros(5, int), np.ones(5, np.float32))
    >>> writer = ExampleWriter("examples.zarr", example_header(examples))
    >>> writer.append(stored)
    >>> writer.complete, len(ExampleStore("examples.zarr"))
    (5, 5)
    """

    def __init__(self, path: str | os.PathLike[str], header: ExampleHeader, *, resume: bool = True) -> None:
        self.path = Path(path)
        if self.path.suffix != ".zarr":
            raise LogError(
                f"{self.path}: examples are written as a .zarr folder; give it a name that ends so"
            )
        if not self.path.parent.is_dir():
            raise LogError(f"{self.path}: there is no folder {str(self.path.parent)!r}; make it first")
        if self.path.exists():
            if not resume:
                raise LogError(f"{self.path}: is there already; remove it to start anew")
            store = ExampleStore(self.path)
            if _plain(store.header) != _plain(header):
                raise LogError(
                    f"{self.path}: holds examples that were made otherwise ({_difference(store.header, header)}); give "
                    "another name, or remove it to start anew"
                )
            self.complete = len(store)
            with told_as_log_error(self.path, _REMEDY):
                self._group = _opened(self.path, "r+")
                for name in _DTYPES:
                    # what an interruption left half appended
                    self._group[name].resize((self.complete, *self._group[name].shape[1:]))
        else:
            self.complete = 0
            try:
                with temporary_beside(self.path) as temporary:
                    # a store without its header could not be gone on with: it appears once it has one
                    _new_store(temporary, header)
                    temporary.rename(self.path)
            except OSError as error:
                raise LogError(f"{self.path}: cannot be written: {error.strerror or error}") from error
            self._group = _opened(self.path, "r+")

    def append(self, stored: StoredExamples) -> None:
        """Append examples; they count once all of them are on disk."""
        start, stop = self.complete, self.complete + len(stored)
        values = {field.name: getattr(stored.examples, field.name) for field in fields(PredictionExamples)}
        values |= {"kind": stored.kind, "interaction": stored.interaction}
        try:
            for name, dtype in _DTYPES.items():
                array = self._group[name]
                array.resize((stop, *array.shape[1:]))
                array[start:stop] = np.asarray(values[name], dtype=dtype)
            told = {**dict(self._group.attrs), "complete": stop}
            self._group.attrs.update({"complete": stop, "checksum": _checksum(told)})
        except OSError as error:
            raise LogError(f"{self.path}: cannot be written: {error.strerror or error}") from error
        self.complete = stop


class ExampleStore:
    """Examples on disk, an `ppinfer.goals.learned.ExampleSource`: only what is read is in memory.

    Parameters
    ----------
    path : path
        The store that an `ExampleWriter` wrote.

    Raises
    ------
    LogError
        Where it cannot be read or is something else.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        if not self.path.exists():
            raise LogError(f"{self.path}: there is no such folder; make one with 'ppsim examples'")
        if not (self.path / "zarr.json").is_file():
            raise LogError(f"{self.path}: is no Zarr store of examples; make one with 'ppsim examples'")
        with guarding.admitted("examples", self.path), told_as_log_error(self.path, _REMEDY):
            self._group = _opened(self.path, "r")
            told: dict[str, Any] = dict(self._group.attrs)
            if (told.get("ppinfer_format"), told.get("version")) != (FORMAT, VERSION):
                raise LogError(
                    f"{self.path}: is no store of prediction examples of version {VERSION} (it says "
                    f"{told.get('ppinfer_format')!r}); make one with 'ppsim examples'"
                )
            if told.get("checksum", _checksum(told)) != _checksum(told):
                raise ValueError("what it says of its examples does not match its checksum")
            header: Mapping[str, Any] = told["header"]
            self.header = ExampleHeader(**{**header, "kinds": tuple(header["kinds"])})
            self._arrays = {name: self._group[name] for name in _DTYPES}
            self._complete = int(told["complete"])
            if any(array.shape[0] < self._complete for array in self._arrays.values()):
                raise ValueError(f"fewer examples than the {self._complete} that it says")

    def __len__(self) -> int:
        return self._complete

    def read(self, start: int, stop: int) -> PredictionExamples:
        """Return the examples from `start` to `stop`."""
        names = [field.name for field in fields(PredictionExamples)]
        with told_as_log_error(self.path, _REMEDY):
            try:
                return PredictionExamples(**{name: self._values(name, start, stop) for name in names})
            except PPInferError as error:
                raise LogError(f"{self.path}: examples {start} to {stop}: {error}; {_REMEDY}") from error

    def kinds(self, start: int, stop: int) -> Int[np.ndarray, " example"]:
        """Return which kind of human each example was of."""
        return self._values("kind", start, stop)

    def interaction(self, start: int, stop: int) -> float:
        """Return the seconds of interaction that were simulated for the examples from `start` to `stop`."""
        return float(self._values("interaction", start, stop).sum(dtype=np.float64))

    def _values(self, name: str, start: int, stop: int) -> np.ndarray:
        with told_as_log_error(self.path, _REMEDY):
            return np.asarray(self._arrays[name][start : min(stop, len(self))])


def _opened(path: Path, mode: Literal["r", "r+"]) -> Any:
    import zarr

    return zarr.open_group(path, mode=mode, zarr_format=3, use_consolidated=False)


def _new_store(path: Path, header: ExampleHeader) -> None:
    import zarr
    from zarr.codecs import Crc32cCodec, ZstdCodec

    shapes: dict[str, tuple[int, ...]] = {
        "human": (header.past, header.states),
        "robot": (header.past, header.states),
        "plan": (header.horizon, header.states),
        "goals": (header.goals, 2),
        "present": (header.goals,),
        "frequency": (header.goals,),
    }
    group: Any = zarr.open_group(path, mode="w-", zarr_format=3)
    for name, dtype in _DTYPES.items():
        shape = shapes.get(name, ())
        group.create_array(
            name,
            shape=(0, *shape),
            chunks=(header.batch, *shape),
            dtype=dtype,
            # a chunk that is lost must not read as values that may be true
            fill_value=_MISSING[np.dtype(dtype).kind],
            compressors=[ZstdCodec(level=3), Crc32cCodec()],
            dimension_names=["example", *(f"{name}_{axis}" for axis in range(len(shape)))],
        )
    told = {"ppinfer_format": FORMAT, "version": VERSION, "header": _plain(header), "complete": 0}
    group.attrs.update({**told, "checksum": _checksum(told)})


def _checksum(told: Mapping[str, Any]) -> str:
    """Return the CRC-32 of what a store says of its examples; the examples have checksums of their own."""
    import json
    import zlib

    said = json.dumps([told.get("header"), told.get("complete")], sort_keys=True)
    return f"{zlib.crc32(said.encode()):08x}"


def _plain(header: ExampleHeader) -> dict[str, Any]:
    import json

    plain: dict[str, Any] = json.loads(json.dumps(asdict(header)))
    return plain


def _difference(there: ExampleHeader, wanted: ExampleHeader) -> str:
    one, other = _flat(there), _flat(wanted)
    differing = [name for name in (*one, *other) if one.get(name) != other.get(name)]
    name = differing[0]
    return f"{name} is {one.get(name)!r}, not {other.get(name)!r}"


def _flat(header: ExampleHeader) -> dict[str, Any]:
    plain = _plain(header)
    return {**plain.pop("configuration"), **plain}
