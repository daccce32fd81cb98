"""Which trials of parallel play a page shows when nobody says: those in which most can be seen."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Shaped

from ppinfer.plots.replan_beliefs import ReplanBeliefs
from ppinfer.report.trial_choice import ChosenTrial

# whose beliefs are looked at first, where several robots held one
_FIRST = "bayes"


def how_chosen(label: str, *, stops: bool) -> str:
    """Say how `choose_plays` chooses."""
    most = ", and the one with most safety stops" if stops else ""
    return (
        f"Chosen by the numbers alone: the trials in which the mean belief that the {label} favours itself is highest "
        f"and lowest, the one in which the belief changed most{most}."
    )


def choose_plays(
    beliefs: ReplanBeliefs | None,
    label: str,
    *,
    stops: Shaped[np.ndarray, " trial"] | None,
    among: Bool[np.ndarray, " trial"],
) -> list[ChosenTrial]:
    """Choose trials by the robot's belief and by safety stops.

    1. Of the robot ``bayes``, or else the first that held a belief: the trial with the highest and the one with the
       lowest mean belief in ``label``, and the one in which it changed most (the sum of its absolute changes).
    2. Of the same robot, the trial with most safety stops, if there are any; without any belief, of all robots.

    The first in the file is taken of those that are equal, and each trial once. The choice depends on the numbers
    alone, so that a report can be made again.

    Parameters
    ----------
    beliefs
        Of the robot; None where there are none.
    label
        Of theta.
    stops
        Of each trial; None where they are not known.
    among
        The trials to choose from.
    """
    chosen: dict[int, str] = {}
    if beliefs is not None and len(beliefs.trial):
        believers = list(dict.fromkeys(beliefs.robot[beliefs.trial].tolist()))
        robot = _FIRST if _FIRST in believers else believers[0]
        among = among & (beliefs.robot == robot)
        told = _by_belief(beliefs.among(among), label)
        whose = f"of {robot}: " if len(believers) > 1 else ""
        chosen = {index: whose + why for index, why in told.items()}
    if stops is not None:
        candidates = np.flatnonzero(among)
        most = int(candidates[stops[candidates].argmax()])
        if stops[most] > 0:
            chosen.setdefault(most, f"most safety stops: {int(stops[most])}")
    if not chosen:
        chosen = {int(np.flatnonzero(among)[0]): "the first in the file"}
    return [ChosenTrial(index, why) for index, why in chosen.items()]


def _by_belief(beliefs: ReplanBeliefs, label: str) -> dict[int, str]:
    believed = beliefs.of(label) if label in beliefs.theta else beliefs.probability[:, 0]
    label = label if label in beliefs.theta else beliefs.theta[0]
    trials, first, count = np.unique(beliefs.trial, return_index=True, return_counts=True)
    mean: Float[np.ndarray, " held"] = np.add.reduceat(believed, first) / count
    # no step leads into a trial's first replan
    change = np.abs(np.diff(believed, prepend=believed[:1]))
    change[first] = 0.0
    moved: Float[np.ndarray, " held"] = np.add.reduceat(change, first)
    chosen: dict[int, str] = {}
    for pick, why in (
        (mean.argmax(), f"highest mean p(theta = {label})"),
        (mean.argmin(), f"lowest mean p(theta = {label})"),
        (moved.argmax(), "the belief changed most"),
    ):
        chosen.setdefault(int(trials[pick]), why)
    return chosen
