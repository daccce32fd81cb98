"""One trial out of a log, by its id."""

from __future__ import annotations

import xarray as xr

from ppinfer.errors import LogError
from ppinfer.studies import select_trials


def one_trial(log: xr.Dataset, trial: str | None = None, *, where: str = "the log") -> xr.Dataset:
    """Return one trial of a log, by its id; the first one where none is named.

    Parameters
    ----------
    log : xarray.Dataset
        A study log.
    trial : str, optional
        The trial's id.
    where : str
        What an error calls the log.

    Raises
    ------
    LogError
        If there is no such trial.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> one_trial(example_log(participants=1, trials=3)).sizes["trial"]
    1
    """
    names = [str(name) for name in log["trial_id"].values]
    if not names:
        raise LogError(f"{where} holds no trial")
    if trial is not None and trial not in names:
        raise LogError(
            f"{where} has no trial {trial!r}; it holds {len(names)}: {', '.join(map(repr, names[:10]))}"
            f"{', ...' * (len(names) > 10)}"
        )
    return select_trials(log, [0 if trial is None else names.index(trial)])
