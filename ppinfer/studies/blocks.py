"""A log in blocks of whole trials, so that memory stays flat however long the study is."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Int

from ppinfer.errors import LogError
from ppinfer.studies.planned_rows import PlannedRows
from ppinfer.studies.schema import RAGGED, REPLAN_VARIABLES
from ppinfer.studies.storage import open_log, told_as_log_error


def iter_blocks(
    source: xr.Dataset | str | os.PathLike[str],
    *,
    max_samples: int = 1_000_000,
    variables: Sequence[str] | None = None,
) -> Iterator[xr.Dataset]:
    """Yield a log as loaded blocks of whole trials, in order.

    Parameters
    ----------
    source
        A log, or the path of one, which is opened and closed here.
    max_samples
        Most samples in a block, and where replans are read most waypoints and profiles together; a trial that is
        longer is a block of its own.
    variables
        Which variables along samples, replans, plans, waypoints and profiles to read; by default all. The others
        (on trials, goals, segments) always come.

    Yields
    ------
    xarray.Dataset
        Some whole trials in memory, with their segments: ``segment_trial`` counts within the block. The
        attributes ``first_trial`` and ``first_sample`` say where the block begins in the log.

    Raises
    ------
    LogError
        If the log cannot be read, or its ``row_size`` does not fit its samples.

    Examples
    --------
    >>> from ppinfer.studies import build_log
    >>> log = build_log(agents=["human"], row_size=[2, 1, 1], time=[0.0, 0.1, 0.0, 0.0],
    ...                 position=np.zeros((4, 1, 2)))
    >>> [block.row_size.values.tolist() for block in iter_blocks(log, max_samples=3)]
    [[2, 1], [1]]
    """
    if max_samples < 1:
        raise LogError(f"max_samples is {max_samples}; at least 1 is expected")
    if isinstance(source, xr.Dataset):
        yield from _blocks(source, max_samples, variables, Path("log"))
        return
    log = open_log(source)
    try:
        yield from _blocks(log, max_samples, variables, Path(source))
    finally:
        log.close()


def block_edges(row_size: Int[np.ndarray, " trial"], max_samples: int) -> Int[np.ndarray, " edge"]:
    """Return the indices of the trials at which blocks begin, and the number of trials at the end.

    Examples
    --------
    >>> block_edges(np.array([2, 1, 9, 1]), 3).tolist()
    [0, 2, 3, 4]
    """
    ends = np.cumsum(row_size)
    edges = [0]
    while edges[-1] < ends.size:
        begin = edges[-1]
        before = ends[begin - 1] if begin else 0
        edges.append(max(begin + 1, int(np.searchsorted(ends, before + max_samples, side="right"))))
    return np.array(edges)


def _blocks(
    log: xr.Dataset, max_samples: int, names: Sequence[str] | None, source: Path
) -> Iterator[xr.Dataset]:
    ragged = [dim for dim in RAGGED if dim in log.dims]
    along = [
        str(name)
        for name, variable in log.data_vars.items()
        if set(variable.dims) & set(ragged) and (names is None or name in names)
    ]
    missing = sorted(set(names or ()) - set(map(str, log.variables)))
    if missing:
        raise LogError(
            f"{source}: there are no variables {missing}; the log has {sorted(map(str, log.data_vars))}"
        )
    with told_as_log_error(source):
        still = log.drop_dims(ragged).load()
    row_size = still["row_size"].values
    if (row_size < 1).any() or row_size.sum() != log.sizes["sample"]:
        raise LogError(
            f"{source}: row_size holds {row_size.size} trials of {row_size.sum()} samples together, but "
            f"there are {log.sizes['sample']} samples; run 'ppinfer validate' on it"
        )
    edges_of = {"sample": np.concatenate([[0], np.cumsum(row_size)])}
    work = row_size
    if any(set(log[name].dims) & {"replan", "plan", "waypoint", "profile"} for name in along):
        planned = _planned_edges(log, source)
        edges_of |= planned
        work = np.maximum(row_size, np.diff(planned["waypoint"]) + np.diff(planned["profile"]))
    else:
        still = still.drop_vars("replan_row_size", errors="ignore")
    if "theta" in still and not any("theta" in log[name].dims for name in along):
        still = still.drop_vars("theta")
    by_trial = np.argsort(still["segment_trial"].values, kind="stable") if "segment_trial" in still else None
    sorted_trial = still["segment_trial"].values[by_trial] if by_trial is not None else None
    # put together once, and cut into blocks by one selection each: merging data sets takes longer than reading them
    whole = still.assign({name: log.variables[name] for name in along})
    edges = block_edges(work, max_samples)
    for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        rows: dict[str, Any] = {dim: slice(int(at[begin]), int(at[end])) for dim, at in edges_of.items()}
        rows["trial"] = slice(begin, end)
        if by_trial is not None and sorted_trial is not None:
            first, last = np.searchsorted(sorted_trial, [begin, end])
            # sorted again: segments keep the order that they have in the log
            rows["segment"] = np.sort(by_trial[first:last])
        with told_as_log_error(source):
            block = whole.isel(rows, missing_dims="ignore").load()
        if by_trial is not None:
            # chosen by their numbers, segments are copies of the log's
            block["segment_trial"].data = block["segment_trial"].values - begin
        block.attrs = {**log.attrs, "first_trial": begin, "first_sample": rows["sample"].start}
        if "replan" in rows:
            block.attrs["first_replan"] = rows["replan"].start
        yield block


def _planned_edges(log: xr.Dataset, source: Path) -> dict[str, Int[np.ndarray, " edge"]]:
    lacking = [name for name in REPLAN_VARIABLES if name not in log.variables]
    if lacking:
        raise LogError(f"{source}: has replans but no {lacking[0]}; run 'ppinfer validate' on it")
    with told_as_log_error(source):
        planned = PlannedRows.of_log(log)
    # a row size below 0 would make edges that run back
    fits = all(
        np.diff(edges).min(initial=0) >= 0 for edges in (planned.replan, planned.plan, planned.waypoint)
    )
    if not fits or any(size != log.sizes[dim] for dim, size in planned.sizes.items()):
        raise LogError(
            f"{source}: row sizes of replans, plans and waypoints add up to {planned.sizes}, but there are "
            f"{ {dim: log.sizes[dim] for dim in planned.sizes} }; run 'ppinfer validate' on it"
        )
    return {dim: planned.trials(dim) for dim in planned.sizes}
