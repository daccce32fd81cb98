"""ETH/BIWI pedestrians: ``obsmat.txt`` (frame, id, x, z, y, vx, vz, vy) and ``destinations.txt`` (x y)."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import xarray as xr
from jaxtyping import Float, Int

from ppinfer.errors import LogError
from ppinfer.studies.assembling import build_log
from ppinfer.studies.checksums import file_sha256
from ppinfer.studies.faults import Fault, Faults
from ppinfer.studies.readers.text_shape import check_lines

SECONDS_PER_ANNOTATION = 0.4
"""The scenes were annotated at 2.5 Hz, whatever the video's frame rate."""


def read_eth(source: str | os.PathLike[str]) -> xr.Dataset:
    r"""Read one ETH/BIWI scene: a folder, or its ``obsmat.txt`` with ``destinations.txt`` beside it.

    A person is a trial of agent ``human`` with one segment, whose ``true_goal`` is the destination nearest to
    the last position. Time is frame x 0.4 s / (the usual step between a person's frames), so gaps keep their
    length. The file's velocities are central differences, which look ahead: they are not kept.

    Raises
    ------
    FaultyLogError
        Listing the lines with a wrong number of cells, a cell that is no finite number, or a repeated person
        and frame.

    Examples
    --------
    >>> from pathlib import Path
    >>> lines = [f"{frame} 1 {x} 0 0 0 0 0" for frame, x in ((0, 0.0), (6, 0.5), (12, 1.0))]
    >>> _ = Path("obsmat.txt").write_text("\n".join(lines))
    >>> _ = Path("destinations.txt").write_text("5 0\n-5 0")
    >>> read_eth("obsmat.txt").time.values.round(9).tolist()
    [0.0, 0.4, 0.8]
    """
    given = Path(source)
    observations = given / "obsmat.txt" if given.is_dir() else given
    destinations = observations.with_name("destinations.txt")
    faults = Faults()
    table, lines = _read_table(observations, 8, faults)
    goals, _ = _read_table(destinations, 2, faults)
    if not faults and goals.shape[0] == 0:
        faults.add(
            Fault(
                "goals-missing",
                "holds no destination",
                "one line 'x y' a destination",
                file=destinations.name,
            )
        )
    if not faults and table.shape[0] == 0:
        faults.add(Fault("empty", "holds no observation", file=observations.name))
    faults.raise_if_any(str(given))

    # by person, then by frame; lines in the file go by frame
    order = np.lexsort((table[:, 0], table[:, 1]))
    table, lines = table[order], lines[order]
    frame, person, position = table[:, 0], table[:, 1], table[:, [2, 4]]
    first = np.flatnonzero(np.diff(person, prepend=np.nan) != 0)
    row_size = np.diff(np.append(first, person.size))
    step = np.diff(frame)
    within = np.diff(person) == 0
    repeated = np.flatnonzero(within & (step == 0)) + 1
    faults.add_each(
        "duplicate-row",
        repeated.tolist(),
        lambda row: Fault(
            "duplicate-row",
            f"person {person[row]:g} is in frame {frame[row]:g} twice (also line {lines[row - 1]})",
            "remove one of the two",
            file=observations.name,
            line=int(lines[row]),
        ),
    )
    faults.raise_if_any(str(given))

    frames_per_annotation = _usual(step[within])
    last = position[first + row_size - 1]
    # quarters, so that not even the largest numbers overflow: which destination is nearest stays the same
    distance = np.hypot(*np.moveaxis(last[:, None] / 4 - goals / 4, -1, 0))
    ids = [f"{number:g}" for number in person[first].tolist()]
    return build_log(
        agents=["human"],
        goals=[str(index) for index in range(goals.shape[0])],
        row_size=row_size,
        trial_id=ids,
        participant=ids,
        time=frame * SECONDS_PER_ANNOTATION / frames_per_annotation,
        position=position[:, None],
        goal_position=goals,
        controller={"human": "person"},
        segment_trial=np.arange(row_size.size),
        segment_agent=["human"] * row_size.size,
        segment_start=np.zeros(row_size.size, np.int64),
        segment_stop=row_size,
        true_goal=[str(index) for index in distance.argmin(axis=1).tolist()],
        title="ETH/BIWI pedestrians",
        source=observations.resolve().parent.name,
        configuration={"reader": "eth", "frames_per_annotation": frames_per_annotation},
        attrs={"source_sha256": file_sha256(given), "notes": ""},
    )


def _usual(steps: Float[np.ndarray, " step"]) -> float:
    if steps.size == 0:
        raise LogError("obsmat.txt: no person is seen twice, so the time between frames is unknown")
    values, counts = np.unique(steps, return_counts=True)
    return float(values[counts.argmax()])


def _read_table(
    path: Path, columns: int, faults: Faults
) -> tuple[Float[np.ndarray, "row column"], Int[np.ndarray, " row"]]:
    empty = np.zeros((0, columns)), np.zeros(0, np.int64)
    try:
        if not check_lines(path, faults):
            return empty
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not text"
        faults.add(
            Fault(
                "unreadable",
                f"cannot be read: {reason}",
                "a scene is obsmat.txt and destinations.txt",
                file=path.name,
            )
        )
        return empty
    rows: list[list[float]] = []
    numbers: list[int] = []
    before = faults.total
    for line, content in enumerate(text.splitlines(), start=1):
        cells = content.split()
        if not cells:
            continue
        if len(cells) != columns:
            told = f"has {len(cells)} cells, expected {columns}"
            faults.add(Fault("wrong-length", told, file=path.name, line=line))
            continue
        rows.append([_number(cell, index, line, path, faults) for index, cell in enumerate(cells)])
        numbers.append(line)
    if faults.total > before or not rows:
        return empty
    return np.array(rows), np.array(numbers)


def _number(cell: str, index: int, line: int, path: Path, faults: Faults) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        told = f"expected a finite number, got {cell!r}"
        faults.add(Fault("not-a-number", told, file=path.name, line=line, column=str(index + 1)))
    return value
