"""From a log of a world where agents plan to the flat arrays that personalities are inferred from."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ppinfer.coordination.history import PlayHistory
from ppinfer.errors import LogError
from ppinfer.studies.schema import REPLAN_VARIABLES
from ppinfer.studies.structure_checks import sample_offsets, trial_names

HISTORY_VARIABLES = (
    "time",
    "position",
    "velocity",
    "observed",
    "held",
    *REPLAN_VARIABLES,
    "live_log_posterior",
)
"""What is read of a log to infer personalities, as far as it is there."""

_STEP_TOLERANCE = 1e-6


def play_history(log: xr.Dataset) -> PlayHistory:
    """Return the motion, plans and costs of a log in memory as `ppinfer.coordination` takes them.

    Parameters
    ----------
    log : xarray.Dataset
        A sound study log with replans, or a block of one. Without `held` no step was held by a safety stop; without
        `velocity` velocities are NaN.

    Raises
    ------
    LogError
        If the log has no replans, samples at uneven steps, or an agent without plans at a replan.

    Examples
    --------
    >>> from ppinfer.testing.example_plays import example_planned_log
    >>> history = play_history(example_planned_log(trials=2, replans=3))
    >>> history.agents, history.dt, len(history.cost)
    (('human', 'robot'), 0.1, 192)
    """
    require_replans(log, "log")
    values = {name: log[name].values for name in REPLAN_VARIABLES if name != "decision"}
    left = np.argwhere(values["plan_row_size"] < 1)
    if left.size:
        replan, agent = (int(index) for index in left[0])
        trial = int(np.searchsorted(np.cumsum(values["replan_row_size"]), replan, side="right"))
        raise LogError(
            f"trial {trial_names(log)[trial]!r}: {str(log['agent'].values[agent])!r} has no plans at a replan (at "
            f"{values['replan_time'][replan]:g} s); personalities are inferred from games of all agents: log a plan "
            "that stays for who has left"
        )
    position = log["position"].values
    return PlayHistory(
        agents=tuple(str(agent) for agent in log["agent"].values),
        row_size=log["row_size"].values,
        position=position,
        velocity=log["velocity"].values if "velocity" in log else np.full_like(position, np.nan),
        held=log["held"].values == 1 if "held" in log else np.zeros(len(position), bool),
        dt=time_step(log),
        **values,
    )


def require_replans(log: xr.Dataset, source: object) -> None:
    """Raise a LogError unless a log has replans; it says what is missing and what to do.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> try:
    ...     require_replans(example_log(), "log.nc")
    ... except LogError as error:
    ...     print(str(error)[:61])
    log.nc: holds no replans (replan_row_size and what belongs to
    """
    missing = [name for name in REPLAN_VARIABLES if name not in log.variables]
    if len(missing) == len(REPLAN_VARIABLES):
        raise LogError(
            f"{source}: holds no replans (replan_row_size and what belongs to it): personalities are inferred from the "
            "plans and costs that agents chose among, as 'ppsim study' logs them (see docs/log-format.md); for goals "
            "choose --model goal-lqr"
        )
    if missing:
        raise LogError(f"{source}: has replans but no {missing[0]}; run 'ppinfer validate' on it")


def time_step(log: xr.Dataset) -> float:
    """Return the seconds between samples of a log in memory, which are the same throughout.

    Raises
    ------
    LogError
        Naming the first step that is another.

    Examples
    --------
    >>> from ppinfer.testing.example_plays import example_planned_log
    >>> time_step(example_planned_log(trials=1))
    0.1
    """
    time, offsets = log["time"].values, sample_offsets(log["row_size"].values)
    step = np.diff(time)
    within = np.ones(step.size, bool)
    within[offsets[1:-1] - 1] = False
    if not within.any():
        return 0.1
    # the nearest round number: times are multiples of it, each with an error of its own
    nominal = round(float(np.median(step[within])), 9)
    odd = np.flatnonzero(within & (np.abs(step - nominal) > _STEP_TOLERANCE))
    if odd.size:
        trial = int(np.searchsorted(offsets, odd[0], side="right")) - 1
        raise LogError(
            f"trial {trial_names(log)[trial]!r}: sample {odd[0] - offsets[trial] + 1} comes {step[odd[0]]:g} s after "
            f"the one before, others {nominal:g} s; personalities are inferred from samples at even steps"
        )
    return nominal
