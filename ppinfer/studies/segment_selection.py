"""Which segments are scored, why the others are not, and reading samples of segments in blocks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float, Int, Shaped

from ppinfer.distributions.ragged import expand
from ppinfer.errors import LogError
from ppinfer.studies.posterior import rows, trial_starts

MIN_SCORED_SAMPLES = 3
_BLOCK_SAMPLES = 1 << 18


@dataclass(frozen=True)
class SegmentSelection:
    """The segments that are kept, with what is needed to find and group them.

    Attributes
    ----------
    index
        Indices of the kept segments in the posterior.
    first
        Index of each kept segment's first sample, over all samples.
    length
        Samples of each kept segment.
    true_goal
        Index of each kept segment's true goal.
    participant
        Index of each kept segment's participant in `participants`.
    participants
        The participants of the kept segments, sorted.
    left_out
        How many segments are left out, by reason; each is counted under the first that applies.
    """

    index: Int[np.ndarray, " segment"]
    first: Int[np.ndarray, " segment"]
    length: Int[np.ndarray, " segment"]
    true_goal: Int[np.ndarray, " segment"]
    participant: Int[np.ndarray, " segment"]
    participants: tuple[str, ...]
    left_out: dict[str, int]


class SegmentOptions(TypedDict, total=False):
    """The keyword arguments of `select_segments`, for those who pass them on."""

    min_samples: int | None
    min_distance: float | None
    participants: Sequence[str] | None
    exclude: Sequence[str] | None


def select_segments(
    posterior: xr.Dataset,
    *,
    min_samples: int | None = None,
    min_distance: float | None = None,
    participants: Sequence[str] | None = None,
    exclude: Sequence[str] | None = None,
) -> SegmentSelection:
    """Choose the segments of a posterior that are scored.

    Parameters
    ----------
    posterior
        A posterior (see `ppinfer.studies.posterior`).
    min_samples
        Keep segments of at least this many samples; segments of fewer than 3 are never kept.
    min_distance
        Keep segments whose true goal is at least this far (in units of position) from the position at their
        start; where that sample is a dropout, from the first position seen in the segment.
    participants
        Keep these participants only.
    exclude
        Leave these participants out.

    Returns
    -------
    SegmentSelection
        What is kept, and counts of what is left out: ``participant``, ``true_goal_unknown``,
        ``shorter_than_3_samples``, ``below_min_samples``, ``below_min_distance`` and ``distance_unknown``
        (never seen, or the goal is absent).

    Raises
    ------
    LogError
        If a participant is unknown, or a limit is negative.
    """
    if min_samples is not None and min_samples < 0:
        raise LogError(f"min_samples is {min_samples}; a number of samples >= 0 is expected")
    if min_distance is not None and not min_distance >= 0:
        raise LogError(f"min_distance is {min_distance}; a distance >= 0 is expected")
    trial: Int[np.ndarray, " segment"] = posterior["segment_trial"].values
    start = trial_starts(posterior)[trial] + posterior["segment_start"].values
    length = posterior["segment_stop"].values - posterior["segment_start"].values
    people = posterior["participant"].values.astype(object)[trial]
    labels = {str(goal): i for i, goal in enumerate(posterior["goal"].values)}
    true_goal = np.array(
        [labels.get(str(goal), -1) for goal in posterior["true_goal"].values], dtype=np.int64
    )

    kept = np.ones(len(trial), dtype=bool)
    left_out: dict[str, int] = {}

    def leave_out(reason: str, which: Bool[np.ndarray, " segment"]) -> None:
        left_out[reason] = int((kept & which).sum())
        kept[which] = False

    leave_out("participant", ~_wanted(posterior, people, participants, exclude))
    leave_out("true_goal_unknown", true_goal < 0)
    leave_out("shorter_than_3_samples", length < MIN_SCORED_SAMPLES)
    if min_samples is not None:
        leave_out("below_min_samples", length < min_samples)
    if min_distance is not None:
        distance = np.full(len(trial), np.inf)
        distance[kept] = _start_distance(posterior, trial[kept], start[kept], length[kept], true_goal[kept])
        leave_out("distance_unknown", np.isnan(distance))
        leave_out("below_min_distance", distance < min_distance)
    names, participant = np.unique(people[kept].astype(str), return_inverse=True)
    return SegmentSelection(
        index=np.flatnonzero(kept),
        first=start[kept],
        length=length[kept],
        true_goal=true_goal[kept],
        participant=participant,
        participants=tuple(str(name) for name in names),
        left_out=left_out,
    )


def require_segments(selection: SegmentSelection) -> None:
    """Raise `LogError`, saying what was left out and why, unless some segment is kept."""
    if len(selection.index) == 0:
        raise LogError(
            "no segment can be scored: "
            + (
                describe_left_out(selection.left_out)
                or "the posterior has no segments (its log names no true goals)"
            )
        )


def describe_left_out(left_out: dict[str, int]) -> str:
    """Say in one line how many segments were left out and why; empty when none was.

    Examples
    --------
    >>> describe_left_out({"true_goal_unknown": 2, "participant": 0})
    '2 segments left out (true goal unknown: 2)'
    """
    parts = [f"{reason.replace('_', ' ')}: {count}" for reason, count in left_out.items() if count]
    total = sum(left_out.values())
    return f"{total} segment{'s' * (total != 1)} left out ({', '.join(parts)})" if parts else ""


def segment_blocks(
    selection: SegmentSelection, *, max_samples: int = _BLOCK_SAMPLES
) -> Iterator[tuple[Int[np.ndarray, " row"], Int[np.ndarray, " row"]]]:
    """Yield the samples of the kept segments in file order, about ``max_samples`` at a time.

    Yields
    ------
    tuple of arrays
        For each sample, which kept segment it belongs to (position in the selection) and its index over all
        samples.
    """
    order = np.argsort(selection.first, kind="stable")
    ends = np.cumsum(selection.length[order])
    group = (ends - 1) // max_samples
    for members in np.split(order, np.flatnonzero(np.diff(group)) + 1) if len(order) else []:
        lengths = selection.length[members]
        yield np.repeat(members, lengths), expand(selection.first[members], lengths)


def _wanted(
    posterior: xr.Dataset,
    people: Shaped[np.ndarray, " segment"],
    participants: Sequence[str] | None,
    exclude: Sequence[str] | None,
) -> Bool[np.ndarray, " segment"]:
    known = sorted({str(name) for name in posterior["participant"].values})
    unknown = sorted({*(participants or ()), *(exclude or ())} - set(known))
    if unknown:
        raise LogError(
            f"unknown participant{'s' * (len(unknown) != 1)} {', '.join(map(repr, unknown))}; the posterior "
            f"has {', '.join(map(repr, known[:20]))}{' and others' * (len(known) > 20)}"
        )
    wanted = np.isin(people.astype(str), known if participants is None else list(participants))
    return wanted & ~np.isin(people.astype(str), list(exclude or ()))


def _start_distance(
    posterior: xr.Dataset,
    trial: Int[np.ndarray, " segment"],
    start: Int[np.ndarray, " segment"],
    length: Int[np.ndarray, " segment"],
    true_goal: Int[np.ndarray, " segment"],
) -> Float[np.ndarray, " segment"]:
    seen = start + _first_seen(posterior, start, length)
    position = rows(posterior["position"], seen)
    goals = posterior["goal_position"]
    leading = start if goals.dims[0] == "sample" else trial
    goal = rows(goals, leading)[np.arange(len(start)), true_goal]
    distance: Float[np.ndarray, " segment"] = np.sqrt(((position - goal) ** 2).sum(axis=1))
    return distance


def _first_seen(
    posterior: xr.Dataset, start: Int[np.ndarray, " segment"], length: Int[np.ndarray, " segment"]
) -> Int[np.ndarray, " segment"]:
    # offsets move on only where a sample is a dropout: as many passes as the longest dropout at a start
    offset = np.zeros(len(start), dtype=np.int64)
    unseen = np.arange(len(start))
    while len(unseen):
        missing = rows(posterior["observed"], (start + offset)[unseen]) == 0
        unseen = unseen[missing & (offset[unseen] + 1 < length[unseen])]
        offset[unseen] += 1
    return offset
