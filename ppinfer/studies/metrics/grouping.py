"""What trials can be grouped by: everything that a log says of a whole trial in text or whole numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import xarray as xr
from jaxtyping import Shaped

from ppinfer.errors import LogError

FIRST = ("trial_id", "participant", "condition", "round")
# sizes of other things, and a model's whole configuration
_LEFT_OUT = ("row_size", "replan_row_size", "live_model")
_PER_AGENT = ("controller", "instruction")
UNKNOWN_ROUND = -1


def grouping_columns(
    log: xr.Dataset, *, leave_out: Iterable[str] = ()
) -> dict[str, Shaped[np.ndarray, " trial"]]:
    """Return the columns of a log that trials can be grouped by, ids first.

    What there is for each agent comes apart: ``robot_controller``, ``human_instruction``.

    Parameters
    ----------
    log : xarray.Dataset
        A study log.
    leave_out : iterable of str
        Variables that are measurements.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> list(grouping_columns(example_log()))
    ['trial_id', 'participant']
    """
    apart = {*_LEFT_OUT, *leave_out}
    known = [name for name in FIRST if name in log.variables]
    known += [
        str(name)
        for name, variable in log.data_vars.items()
        if variable.dims == ("trial",) and name not in apart and name not in known
    ]
    columns = {name: _told(log[name].values) for name in known if log[name].dtype.kind in "OUTSiub"}
    agents = log["agent"].values.astype(str).tolist()
    for name in _PER_AGENT:
        if name in log.variables:
            for index, agent in enumerate(agents):
                columns[f"{agent}_{name}"] = _told(log[name].values[:, index])
    return columns


def column_of(columns: Mapping[str, Shaped[np.ndarray, " trial"]], name: str) -> Shaped[np.ndarray, " trial"]:
    """Return a column by name.

    Raises
    ------
    LogError
        If there is no such column, naming those there are.
    """
    if name not in columns:
        raise LogError(
            f"trials cannot be grouped by {name!r}: the log says no such thing of a whole trial in text or whole "
            f"numbers; it says {', '.join(columns)}"
        )
    return columns[name]


def _told(values: Shaped[np.ndarray, " trial"]) -> Shaped[np.ndarray, " trial"]:
    if values.dtype.kind in "iub":
        return values.astype(np.int64)
    return np.array([str(value) for value in values.tolist()], dtype=object)
