"""Where agents were, taken out of a log for drawing: in the plane of the first two coordinates, or of their hands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from jaxtyping import Float, Int

from ppinfer.studies.posterior import trial_starts

_MOST_SAMPLES = 400_000


@dataclass(frozen=True, eq=False)
class MotionData:
    """Where the agents of some trials were.

    Attributes
    ----------
    agents
        Names of the agents.
    axes
        Names of the coordinates, one or two.
    units
        Of the coordinates.
    time
        Since the start of each sample's trial, in s.
    position
        NaN where an agent was not seen.
    trial
        Which trial each sample is of, counted among those that were read.
    of_all
        How many trials the log has; as many as were read, unless it is too long to be drawn whole.
    """

    agents: tuple[str, ...]
    axes: tuple[str, ...]
    units: str
    time: Float[np.ndarray, " sample"]
    position: Float[np.ndarray, "sample agent axis"]
    trial: Int[np.ndarray, " sample"]
    of_all: int

    @property
    def trials(self) -> int:
        """How many trials were read."""
        return int(self.trial[-1]) + 1

    def labels(self) -> tuple[str, ...]:
        """Return the labels of the axes, with units."""
        return tuple(f"{name} [{self.units}]" for name in self.axes)


def read_motion(log: xr.Dataset, trials: Int[np.ndarray, " trial"] | None = None) -> MotionData:
    """Read where agents were: in the plane of their hands where a log has it, else of their first coordinates.

    Parameters
    ----------
    log
        A study log, in memory or opened from a file.
    trials
        Which trials, by their places; by default all, or of a log of more than 400 000 samples as many, evenly spread,
        as have about so many samples.

    Examples
    --------
    >>> from ppinfer.testing import example_log
    >>> motion = read_motion(example_log(participants=1, trials=2, samples=5), np.array([1]))
    >>> motion.position.shape, motion.axes, motion.trials, motion.of_all
    ((5, 1, 2), ('x', 'y'), 1, 2)
    """
    sizes = log["row_size"].values
    if trials is None:
        share = max(1, int(np.ceil(sizes.sum() / _MOST_SAMPLES)))
        trials = np.arange(0, len(sizes), share)
    starts = trial_starts(log)
    hands = "end_effector" in log
    variable = log["end_effector"] if hands else log["position"]
    if len(trials) == len(sizes):
        position, time = variable.values, log["time"].values
    else:
        rows = [slice(int(starts[one]), int(starts[one] + sizes[one])) for one in trials]
        position = np.concatenate([variable[row].values for row in rows])
        time = np.concatenate([log["time"][row].values for row in rows])
    some = sizes[trials]
    first = np.cumsum(some) - some
    axes = log["table"].values if hands else log["space"].values
    return MotionData(
        agents=tuple(str(name) for name in log["agent"].values),
        axes=tuple(str(name) for name in axes[:2]),
        units=str(variable.attrs.get("units", "m")),
        time=time - np.repeat(time[first], some),
        position=position[..., :2].astype(np.float64),
        trial=np.repeat(np.arange(len(trials)), some),
        of_all=len(sizes),
    )
