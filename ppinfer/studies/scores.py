"""How well a posterior names the goal after a share of each segment has been seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
import xarray as xr
from jaxtyping import Float, Int

from ppinfer.errors import LogError
from ppinfer.studies.posterior import rows
from ppinfer.studies.resampling import mean_and_cluster_se
from ppinfer.studies.segment_selection import (
    MIN_SCORED_SAMPLES,
    SegmentSelection,
    require_segments,
    select_segments,
)

DEFAULT_SHARES = (0.25, 0.5, 0.75)


@dataclass(frozen=True)
class Score:
    """The score after one share of each segment.

    Attributes
    ----------
    at
        The share of the segment seen.
    accuracy, accuracy_se
        Share of segments whose most probable goal is the true one (a tie of k counts 1/k), and its standard
        error over participants (`ppinfer.studies.resampling.mean_and_cluster_se`; NaN for one participant).
    mean_log_posterior, mean_log_posterior_se
        Mean natural logarithm of the true goal's probability and its standard error; -inf when some true
        goal was held impossible.
    segments, participants
        How many were scored.
    impossible
        Segments whose true goal had probability zero.
    """

    at: float
    accuracy: float
    accuracy_se: float
    mean_log_posterior: float
    mean_log_posterior_se: float
    segments: int
    participants: int
    impossible: int


@dataclass(frozen=True)
class ParticipantScore(Score):
    """The score of one participant's segments; the standard errors are over segments."""

    participant: str


@dataclass(frozen=True)
class Scores:
    """Scores of a posterior: one a share, one a share and participant, and the segments behind them.

    Attributes
    ----------
    overall
        A `Score` for every share.
    by_participant
        A `ParticipantScore` for every participant and share.
    segments
        What was scored: ``correct(at, segment)``, ``log_posterior(at, segment)`` of the true goal and
        ``confidence(at, segment)`` of the most probable one, with ``participant(segment)``.
    left_out
        How many segments were left out, by reason.
    """

    overall: tuple[Score, ...]
    by_participant: tuple[ParticipantScore, ...]
    segments: xr.Dataset
    left_out: dict[str, int]

    @property
    def warnings(self) -> list[str]:
        """What a reader of the numbers has to know: true goals that were held impossible, too few people."""
        found = [
            f"at {score.at:g}: the true goal of {score.impossible} of {score.segments} segments has "
            "probability zero, so the mean log posterior is -inf"
            for score in self.overall
            if score.impossible
        ]
        if self.overall and self.overall[0].participants < 2:
            found.append("one participant only: no standard errors over participants")
        return found

    def to_json(self) -> list[dict[str, float | int]]:
        """Return the scores as the records that ``ppinfer score --json`` prints."""
        return [
            {key: value for key, value in asdict(score).items() if key != "impossible"}
            for score in self.overall
        ]


def scored_sample(
    length: Int[np.ndarray, " segment"], at: Float[np.ndarray, " at"]
) -> Int[np.ndarray, "at segment"]:
    """Return the index, within each segment, of the last sample seen after each share.

    After a share f of a segment of T samples, n = max(3, ceil(f T)) samples are seen; the index is n - 1.

    Examples
    --------
    >>> scored_sample(np.array([4, 40]), np.array([0.25, 0.5])).tolist()
    [[2, 9], [2, 19]]
    """
    # 0.07 * 100 is 7.000000000000001 in floating point, and is meant to be 7
    seen = np.ceil(at[:, None] * length - 1e-9).astype(np.int64)
    last: Int[np.ndarray, "at segment"] = np.maximum(MIN_SCORED_SAMPLES, seen) - 1
    return last


def top_label(
    log_posterior: Float[np.ndarray, "row goal"], true_goal: Int[np.ndarray, " row"]
) -> tuple[Float[np.ndarray, " row"], Float[np.ndarray, " row"]]:
    """Return the largest log probability and whether its goal is the true one (1/k for a tie of k).

    Examples
    --------
    >>> top_label(np.log([[0.5, 0.5], [0.9, 0.1]]), np.array([0, 1]))[1].tolist()
    [0.5, 0.0]
    """
    top = log_posterior.max(axis=1)
    tied = log_posterior == top[:, None]
    hit = tied[np.arange(len(top)), true_goal]
    return top, hit / tied.sum(axis=1)


def score_segments(
    posterior: xr.Dataset, selection: SegmentSelection, *, at: Sequence[float] = DEFAULT_SHARES
) -> xr.Dataset:
    """Score chosen segments, reading only the rows that are needed.

    Parameters
    ----------
    posterior
        The posterior.
    selection
        The segments (`select_segments`).
    at
        Shares of the segment seen, in (0, 1].

    Returns
    -------
    xarray.Dataset
        ``correct(at, segment)``, ``log_posterior(at, segment)`` of the true goal and ``confidence(at,
        segment)``; the coordinate ``segment`` is the index in the posterior, ``participant(segment)`` the
        label.

    Raises
    ------
    LogError
        If a share is out of range or a posterior that is read is NaN.
    """
    shares = np.asarray(at, dtype=np.float64)
    if shares.size == 0 or not ((shares > 0) & (shares <= 1)).all():
        raise LogError(f"at is {list(at)}; shares of the path seen, above 0 and at most 1, are expected")
    row = selection.first + scored_sample(selection.length, shares)
    logs: Float[np.ndarray, "row goal"] = rows(posterior["log_posterior"], row.ravel())
    true_goal = np.tile(selection.true_goal, len(shares))
    refuse_nan(logs, row.ravel())
    top, correct = top_label(logs, true_goal)
    dims = ("at", "segment")
    return xr.Dataset(
        {
            "correct": (dims, correct.reshape(row.shape)),
            "log_posterior": (dims, logs[np.arange(len(logs)), true_goal].reshape(row.shape)),
            "confidence": (dims, np.exp(top).reshape(row.shape)),
        },
        coords={
            "at": shares,
            "segment": selection.index,
            "participant": ("segment", np.array(selection.participants, dtype=object)[selection.participant]),
        },
    )


def refuse_nan(log_posterior: Float[np.ndarray, "row goal"], sample: Int[np.ndarray, " row"]) -> None:
    """Raise `LogError` naming the first sample whose posterior is NaN."""
    bad = np.isnan(log_posterior).any(axis=1)
    if bad.any():
        raise LogError(
            f"log_posterior of sample {int(sample[np.flatnonzero(bad)[0]])} is NaN; infer the posterior anew"
        )


def score_posterior(
    posterior: xr.Dataset,
    *,
    at: Sequence[float] = DEFAULT_SHARES,
    min_samples: int | None = None,
    min_distance: float | None = None,
    participants: Sequence[str] | None = None,
    exclude: Sequence[str] | None = None,
) -> Scores:
    """Score a posterior over goals: accuracy and mean log posterior of the true goal.

    Parameters
    ----------
    posterior
        The posterior, in memory or opened from a file.
    at
        Shares of each segment seen, in (0, 1]; see `scored_sample`.
    min_samples, min_distance, participants, exclude
        Which segments count; see `ppinfer.studies.segment_selection.select_segments`.

    Returns
    -------
    Scores
        Means over segments with standard errors over participants.

    Raises
    ------
    LogError
        If no segment is left, a participant is unknown or a share is out of range.

    Examples
    --------
    >>> from ppinfer.studies.posterior import open_posterior
    >>> with open_posterior("post.nc") as posterior:  # doctest: +SKIP
    ...     score_posterior(posterior, at=[0.5]).overall[0].accuracy
    0.84
    """
    selection = select_segments(
        posterior,
        min_samples=min_samples,
        min_distance=min_distance,
        participants=participants,
        exclude=exclude,
    )
    require_segments(selection)
    segments = score_segments(posterior, selection, at=at)
    n_people = len(selection.participants)
    overall = []
    by_participant = []
    order = np.argsort(selection.participant, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(selection.participant[order])) + 1)
    for i, share in enumerate(segments["at"].values.tolist()):
        correct, logs = segments["correct"].values[i], segments["log_posterior"].values[i]
        overall.append(_score(share, correct, logs, selection.participant, n_people, n_people))
        for name, members in zip(selection.participants, groups, strict=True):
            alone = _score(share, correct[members], logs[members], np.arange(len(members)), len(members), 1)
            by_participant.append(ParticipantScore(**asdict(alone), participant=name))
    return Scores(tuple(overall), tuple(by_participant), segments, selection.left_out)


def _score(
    at: float,
    correct: Float[np.ndarray, " segment"],
    logs: Float[np.ndarray, " segment"],
    cluster: Int[np.ndarray, " segment"],
    n_clusters: int,
    n_participants: int,
) -> Score:
    accuracy, accuracy_se = mean_and_cluster_se(correct, cluster, n_clusters)
    mean, mean_se = mean_and_cluster_se(logs, cluster, n_clusters)
    return Score(
        at=at,
        accuracy=accuracy,
        accuracy_se=accuracy_se,
        mean_log_posterior=mean,
        mean_log_posterior_se=mean_se,
        segments=len(correct),
        participants=n_participants,
        impossible=int(np.isneginf(logs).sum()),
    )
