"""Which trials a report shows when nobody says: a typical, the best and the worst scored one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float

from ppinfer.errors import LogError
from ppinfer.studies.schema import FORMAT
from ppinfer.studies.scores import Scores


@dataclass(frozen=True)
class ChosenTrial:
    """A trial to show and why."""

    index: int
    why: str


def choose_trials(posterior: xr.Dataset, scores: Scores | None) -> list[ChosenTrial]:
    """Choose trials by the mean log posterior of their true goals at the middle one of the shares.

    The typical trial is the one next to the median. Without scores, the first, middle and last trials are
    chosen. The choice depends on the numbers alone, so that a report can be made again.
    """
    n_trials = posterior.sizes["trial"]
    if scores is None:
        return [
            ChosenTrial(index, "chosen by its place in the file")
            for index in sorted({0, n_trials // 2, n_trials - 1})
        ]
    shares = scores.segments.sizes["at"]
    logs: Float[np.ndarray, " segment"] = scores.segments["log_posterior"].values[shares // 2]
    trial = posterior["segment_trial"].values[scores.segments["segment"].values]
    trials, inverse = np.unique(trial, return_inverse=True)
    value = np.bincount(inverse, weights=logs) / np.bincount(inverse)
    ranked = np.lexsort((trials, value))
    picks = {
        "typical: its score is the median of the trials": ranked[(len(ranked) - 1) // 2],
        "the best score of all trials": ranked[-1],
        "the worst score of all trials": ranked[0],
    }
    chosen: dict[int, str] = {}
    for why, pick in picks.items():
        chosen.setdefault(int(trials[pick]), why)
    return [ChosenTrial(index, why) for index, why in chosen.items()]


def named_trials(dataset: xr.Dataset, trials: Sequence[str]) -> list[ChosenTrial]:
    """Return the trials with these names, each once, in the order asked.

    Raises
    ------
    LogError
        If there is no such trial, naming all that are not there.
    """
    index = {str(name): i for i, name in enumerate(dataset["trial_id"].values)}
    unknown = [name for name in trials if name not in index]
    if unknown:
        known = list(index)
        holder = "log" if dataset.attrs.get("ppinfer_format") == FORMAT else "posterior"
        raise LogError(
            f"unknown trial{'s' * (len(unknown) != 1)} {', '.join(map(repr, unknown))}; the {holder} has "
            f"{len(known)}: {', '.join(map(repr, known[:10]))}{', ...' * (len(known) > 10)}"
        )
    return [ChosenTrial(index[name], "chosen by name") for name in dict.fromkeys(trials)]


def wanted_trials(
    dataset: xr.Dataset, participants: Sequence[str] | None, exclude: Sequence[str] | None
) -> Bool[np.ndarray, " trial"]:
    """Return which trials are of these participants.

    Raises
    ------
    LogError
        If a participant is unknown, or no trial is left.
    """
    people = dataset["participant"].values.astype(str)
    unknown = sorted({*(participants or ()), *(exclude or ())} - set(people.tolist()))
    if unknown:
        known = list(dict.fromkeys(people.tolist()))
        raise LogError(
            f"unknown participant{'s' * (len(unknown) != 1)} {', '.join(map(repr, unknown))}; there are "
            f"{', '.join(map(repr, known[:20]))}{' and others' * (len(known) > 20)}"
        )
    wanted = np.isin(people, people if participants is None else list(participants))
    wanted &= ~np.isin(people, list(exclude or ()))
    if not wanted.any():
        raise LogError("no trial is left: all participants are excluded")
    return wanted
