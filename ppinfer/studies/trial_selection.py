"""Some trials of a log in memory, with all that belongs to them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from jaxtyping import Int

from ppinfer.distributions.ragged import expand
from ppinfer.studies.planned_rows import PlannedRows
from ppinfer.studies.structure_checks import sample_offsets


def select_trials(log: xr.Dataset, trials: Sequence[int] | Int[np.ndarray, " trial"]) -> xr.Dataset:
    """Return some trials of a log in memory, in the order asked: their samples, replans and segments.

    Parameters
    ----------
    log : xarray.Dataset
        A sound study log.
    trials : sequence of int
        Which trials, by their places.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> some = select_trials(example_log(participants=1, trials=3), [2, 0])
    >>> some.sizes["trial"], some.sizes["sample"], some.segment_trial.values.tolist()
    (2, 40, [1, 0])
    """
    chosen = np.asarray(trials, np.int64)
    edges = {"sample": sample_offsets(log["row_size"].values)}
    if "replan_row_size" in log and "replan" in log.dims:
        planned = PlannedRows.of_log(log)
        edges |= {dim: planned.trials(dim) for dim in planned.sizes}
    rows = {dim: expand(at[chosen], np.diff(at)[chosen]) for dim, at in edges.items() if dim in log.dims}
    place = np.full(log.sizes["trial"], -1)
    place[chosen] = np.arange(chosen.size)
    if "segment_trial" in log:
        rows["segment"] = np.flatnonzero(place[log["segment_trial"].values] >= 0)
    some = log.isel({"trial": chosen, **rows})
    if "segment_trial" in some:
        some["segment_trial"] = ("segment", place[some["segment_trial"].values], log["segment_trial"].attrs)
    return some
