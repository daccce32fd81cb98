"""The samples of one trial, taken out of a posterior for drawing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float

from ppinfer.errors import LogError
from ppinfer.studies.posterior import trial_starts
from ppinfer.studies.schema import FORMAT


@dataclass(frozen=True)
class Segment:
    """A stretch of a trial: samples [start, stop) and the index of its true goal (-1 = unknown)."""

    start: int
    stop: int
    true_goal: int


@dataclass(frozen=True)
class TrialData:
    """One trial of a posterior, in memory.

    Attributes
    ----------
    goals
        Labels of the goals.
    units
        Units of positions.
    missing, outlier
        Samples that were not seen, and samples gated as outliers.
    goal_position
        NaN where a goal is absent; given for every sample.
    """

    trial_id: str
    participant: str
    goals: tuple[str, ...]
    units: str
    time: Float[np.ndarray, " sample"]
    position: Float[np.ndarray, "sample space"]
    missing: Bool[np.ndarray, " sample"]
    outlier: Bool[np.ndarray, " sample"]
    probability: Float[np.ndarray, "sample goal"]
    goal_position: Float[np.ndarray, "sample goal space"]
    segments: tuple[Segment, ...]

    @property
    def shown_goals(self) -> list[int]:
        """Goals that are present at some time, or believed in: what is worth a line."""
        present = ~np.isnan(self.goal_position).all(axis=(0, 2))
        return np.flatnonzero(present | (self.probability.max(axis=0) > 0)).tolist()


def trial_index(dataset: xr.Dataset, trial: str | int) -> int:
    """Return the index of a trial of a posterior or log, given its name or its index.

    Raises
    ------
    LogError
        If there is no such trial.
    """
    names = [str(name) for name in dataset["trial_id"].values]
    if isinstance(trial, str) and trial not in names:
        holder = "log" if dataset.attrs.get("ppinfer_format") == FORMAT else "posterior"
        raise LogError(
            f"unknown trial {trial!r}; the {holder} has {len(names)}: "
            f"{', '.join(map(repr, names[:10]))}{', ...' * (len(names) > 10)}"
        )
    if not isinstance(trial, str) and not 0 <= trial < len(names):
        raise LogError(f"trial {trial} of {len(names)}")
    return names.index(trial) if isinstance(trial, str) else trial


def read_trial(posterior: xr.Dataset, trial: str | int) -> TrialData:
    """Read one trial of a posterior, by its name or its index.

    Raises
    ------
    LogError
        If there is no such trial.
    """
    index = trial_index(posterior, trial)
    first = int(trial_starts(posterior)[index])
    samples = slice(first, first + int(posterior["row_size"].values[index]))
    n_samples = samples.stop - samples.start
    goals = [str(goal) for goal in posterior["goal"].values]
    where = posterior["goal_position"]
    if where.dims[0] == "sample":
        goal_position = where[samples].values
    else:
        goal_position = np.broadcast_to(where[index].values, (n_samples, *where.shape[1:]))
    members = np.flatnonzero(posterior["segment_trial"].values == index)
    labels = posterior["true_goal"].values
    return TrialData(
        trial_id=str(posterior["trial_id"].values[index]),
        participant=str(posterior["participant"].values[index]),
        goals=tuple(goals),
        units=str(posterior["position"].attrs.get("units", "m")),
        time=posterior["time"][samples].values,
        position=posterior["position"][samples].values,
        missing=posterior["observed"][samples].values == 0,
        outlier=posterior["outlier"][samples].values != 0
        if "outlier" in posterior
        else np.zeros(n_samples, dtype=bool),
        probability=np.exp(posterior["log_posterior"][samples].values),
        goal_position=goal_position,
        segments=tuple(
            Segment(
                int(posterior["segment_start"].values[i]),
                int(posterior["segment_stop"].values[i]),
                goals.index(str(labels[i])) if str(labels[i]) in goals else -1,
            )
            for i in members.tolist()
        ),
    )
