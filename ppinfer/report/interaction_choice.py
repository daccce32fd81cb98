"""Which interactions a page shows when nobody says: those in which the robot makes the most of a difference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.studies.interaction import Stretch

HOW_CHOSEN = (
    "Chosen by the numbers alone, of the stretches with the same goals throughout, at least a second long, in which "
    "it is known where the human went (of all, where there are none): the one in which the belief given the robot's "
    "goal and the belief without the robot differ most; and those in which the true goal gains, and loses, most "
    "probability by the robot's goal being known."
)
# a second at the usual 10 Hz
MIN_SAMPLES = 10


@dataclass(frozen=True)
class ChosenStretch:
    """A stretch to show and why."""

    stretch: Stretch
    why: str


@dataclass(frozen=True, eq=False)
class StretchNumbers:
    """What the choice depends on, for every stretch.

    Parameters
    ----------
    stretches
        All of the log.
    difference : (stretch,) float64
        Mean total variation between the belief given the robot's goal and that without the robot, in [0, 1].
    gain : (stretch,) float64
        How much more probability the former gives the true goal, on average over the human's segments; NaN where none
        is known.
    """

    stretches: tuple[Stretch, ...]
    difference: Float[np.ndarray, " stretch"]
    gain: Float[np.ndarray, " stretch"]


def stretch_numbers(
    stretches: Sequence[Stretch],
    belief: Float[np.ndarray, "sample goal"],
    given: Float[np.ndarray, "sample goal"],
    true_goal: np.ndarray,
) -> StretchNumbers:
    """Compute them for stretches that lie end to end, from probabilities and the true goals (-1 = unknown)."""
    starts = np.array([one.start for one in stretches])
    size = np.array([one.stop - one.start for one in stretches])
    apart = 0.5 * np.abs(given - belief).sum(axis=1)
    known = true_goal >= 0
    rows = np.arange(len(true_goal))
    more = np.where(known, given[rows, true_goal] - belief[rows, true_goal], 0.0)
    count = np.add.reduceat(known.astype(np.int64), starts)
    total = np.add.reduceat(more, starts)
    gain = np.divide(total, count, out=np.full(len(starts), np.nan), where=count > 0)
    return StretchNumbers(tuple(stretches), np.add.reduceat(apart, starts) / size, gain)


def choose_stretches(
    numbers: StretchNumbers, among: Bool[np.ndarray, " stretch"], *, whole: Bool[np.ndarray, " stretch"]
) -> list[ChosenStretch]:
    """Choose as `HOW_CHOSEN` says; the first in the file of those that are equal, and each once.

    Parameters
    ----------
    numbers
        Of every stretch.
    among
        Those to choose from.
    whole
        Those that are long enough; where none of `among` is, all of these count.
    """
    usable = among & whole if (among & whole).any() else among
    if not usable.any():
        return []
    known = usable & np.isfinite(numbers.gain)
    usable = known if known.any() else usable
    chosen: dict[int, str] = {}
    most = int(np.where(usable, numbers.difference, -np.inf).argmax())
    chosen[most] = f"the robot makes most difference: {numbers.difference[most]:.2f} on average"
    for pick, sign, word in ((np.argmax, 1.0, "gains"), (np.argmin, -1.0, "loses")):
        if not known.any():
            break
        at = int(pick(np.where(known, numbers.gain, -sign * np.inf)))
        if sign * numbers.gain[at] > 0:
            chosen.setdefault(
                at, f"the true goal {word} most by the robot: {abs(numbers.gain[at]):.2f} on average"
            )
    return [ChosenStretch(numbers.stretches[at], why) for at, why in chosen.items()]


def named_stretches(numbers: StretchNumbers, trials: Sequence[int]) -> list[ChosenStretch]:
    """Choose of each trial the stretch in which the robot makes most of a difference."""
    chosen = []
    of = np.array([one.trial for one in numbers.stretches])
    for trial in trials:
        at = int(np.where(of == trial, numbers.difference, -np.inf).argmax())
        chosen.append(
            ChosenStretch(
                numbers.stretches[at],
                f"the stretch of this trial in which the robot makes most difference: {numbers.difference[at]:.2f}",
            )
        )
    return chosen
