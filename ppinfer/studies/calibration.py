"""Whether probabilities mean what they say: reliability of a posterior over goals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from jaxtyping import Float, Int

from ppinfer.errors import LogError
from ppinfer.studies.posterior import rows
from ppinfer.studies.resampling import resampled_sums
from ppinfer.studies.scores import refuse_nan, score_segments, top_label
from ppinfer.studies.segment_selection import require_segments, segment_blocks, select_segments

DEFAULT_BINS = 10
_BAND = (2.5, 97.5)


@dataclass(frozen=True)
class Reliability:
    r"""Predicted probabilities against how often they came true, in bins of equal width.

    The expected calibration error is :math:`\sum_b w_b |o_b - c_b|`, with :math:`w_b` the share of weight
    in bin b, :math:`c_b` its mean predicted probability and :math:`o_b` how often the prediction was right.

    Attributes
    ----------
    edges
        Edges of the bins over [0, 1]; a bin holds its right edge.
    predicted, observed
        Weighted mean probability and frequency in each bin; NaN where the bin is empty.
    low, high
        95 % band of `observed`, by resampling participants; NaN where the bin is empty or there is one
        participant.
    weight
        Share of the weight in each bin; sums to 1.
    expected_calibration_error
        The error above.
    """

    edges: Float[np.ndarray, " edge"]
    predicted: Float[np.ndarray, " bin"]
    observed: Float[np.ndarray, " bin"]
    low: Float[np.ndarray, " bin"]
    high: Float[np.ndarray, " bin"]
    weight: Float[np.ndarray, " bin"]
    expected_calibration_error: float


@dataclass(frozen=True)
class Calibration:
    """Reliability of a posterior over the samples of its segments.

    Attributes
    ----------
    top_label
        Of the most probable goal's probability; its expected calibration error is the headline.
    one_vs_rest
        Of the probabilities of all goals that are present.
    by_share
        Of the most probable goal's probability after each share of the segment seen.
    segments, participants
        How many were used.
    """

    top_label: Reliability
    one_vs_rest: Reliability
    by_share: dict[float, Reliability]
    segments: int
    participants: int

    @property
    def expected_calibration_error(self) -> float:
        """The headline: the error of the most probable goal's probability, over all samples of segments."""
        return self.top_label.expected_calibration_error

    def to_json(self) -> dict[str, object]:
        """Return what ``ppinfer score --json`` prints under ``calibration``."""
        return {
            "expected_calibration_error": self.expected_calibration_error,
            "expected_calibration_error_all_goals": self.one_vs_rest.expected_calibration_error,
            "by_share": [
                {"at": share, "expected_calibration_error": each.expected_calibration_error}
                for share, each in self.by_share.items()
            ],
            "bins": [
                {
                    "from": float(self.top_label.edges[i]),
                    "to": float(self.top_label.edges[i + 1]),
                    "predicted": float(self.top_label.predicted[i]),
                    "observed": float(self.top_label.observed[i]),
                    "low": float(self.top_label.low[i]),
                    "high": float(self.top_label.high[i]),
                    "weight": float(self.top_label.weight[i]),
                }
                for i in range(len(self.top_label.weight))
            ],
        }


def calibrate_posterior(
    posterior: xr.Dataset,
    *,
    at: Sequence[float] = (),
    bins: int = DEFAULT_BINS,
    resamples: int = 1000,
    seed: int = 0,
    min_samples: int | None = None,
    min_distance: float | None = None,
    participants: Sequence[str] | None = None,
    exclude: Sequence[str] | None = None,
) -> Calibration:
    """Compare a posterior's probabilities with how often they come true.

    Every sample of a kept segment is a prediction. Segments weigh the same whatever their length: each of
    the T samples of a segment weighs 1/T. Over all goals, a sample at which K goals are present makes K
    predictions, which weigh 1/(T K) each.

    Parameters
    ----------
    posterior
        The posterior, in memory or opened from a file; read in blocks.
    at
        Shares of the segment after which the reliability is taken as well.
    bins
        Number of bins of equal width over [0, 1].
    resamples, seed
        Resamples of the participants for the bands, and the seed of the draws.
    min_samples, min_distance, participants, exclude
        Which segments count; see `ppinfer.studies.segment_selection.select_segments`.

    Returns
    -------
    Calibration
        Its `expected_calibration_error` is that of the most probable goal.

    Raises
    ------
    LogError
        If no segment is left, or there are no bins.

    Examples
    --------
    >>> from ppinfer.goals import GoalLQR
    >>> from ppinfer.studies import infer_log
    >>> from ppinfer.testing import example_log
    >>> calibrate_posterior(infer_log(example_log(), GoalLQR())).segments
    12
    """
    if bins < 1:
        raise LogError(f"bins is {bins}; at least 1 is expected")
    selection = select_segments(
        posterior,
        min_samples=min_samples,
        min_distance=min_distance,
        participants=participants,
        exclude=exclude,
    )
    require_segments(selection)
    n_people = len(selection.participants)
    top = _Bins(bins, n_people)
    every = _Bins(bins, n_people)
    for segment, sample in segment_blocks(selection):
        logs: Float[np.ndarray, "row goal"] = rows(posterior["log_posterior"], sample)
        refuse_nan(logs, sample)
        person = selection.participant[segment]
        weight = 1 / selection.length[segment]
        confidence, correct = top_label(logs, selection.true_goal[segment])
        top.add(np.exp(confidence), correct, weight, person)
        is_true = np.arange(logs.shape[1]) == selection.true_goal[segment][:, None]
        # an absent goal is no prediction, unless it turns out to be the true one
        counts = ~np.isneginf(logs) | is_true
        row, goal = np.nonzero(counts)
        share = weight / counts.sum(axis=1)
        every.add(np.exp(logs[row, goal]), is_true[row, goal].astype(np.float64), share[row], person[row])
    rng = np.random.default_rng(seed)
    by_share = {}
    if len(at):
        scored = score_segments(posterior, selection, at=at)
        for i, each in enumerate(scored["at"].values.tolist()):
            one = _Bins(bins, n_people)
            ones = np.ones(len(selection.index))
            one.add(scored["confidence"].values[i], scored["correct"].values[i], ones, selection.participant)
            by_share[each] = one.reliability(resamples, rng)
    return Calibration(
        top_label=top.reliability(resamples, rng),
        one_vs_rest=every.reliability(resamples, rng),
        by_share=by_share,
        segments=len(selection.index),
        participants=n_people,
    )


class _Bins:
    """Sums of weight, prediction and outcome in every bin of every participant."""

    def __init__(self, bins: int, n_people: int) -> None:
        self.edges = np.linspace(0, 1, bins + 1)
        self.sums = np.zeros((3, bins, n_people))

    def add(
        self,
        predicted: Float[np.ndarray, " row"],
        observed: Float[np.ndarray, " row"],
        weight: Float[np.ndarray, " row"],
        person: Int[np.ndarray, " row"],
    ) -> None:
        _, bins, n_people = self.sums.shape
        which = np.clip(np.searchsorted(self.edges, predicted, side="left") - 1, 0, bins - 1)
        cell = which * n_people + person
        for total, values in zip(self.sums, (weight, weight * predicted, weight * observed), strict=True):
            total += np.bincount(cell, weights=values, minlength=bins * n_people).reshape(bins, n_people)

    def reliability(self, resamples: int, rng: np.random.Generator) -> Reliability:
        _, bins, n_people = self.sums.shape
        weight, predicted, observed = self.sums.sum(axis=2)
        low = np.full(bins, np.nan)
        high = np.full(bins, np.nan)
        used = weight > 0
        if n_people > 1 and used.any():
            drawn = resampled_sums(
                self.sums[[0, 2]][:, used].reshape(-1, n_people), resamples=resamples, rng=rng
            ).reshape(resamples, 2, -1)
            low[used], high[used] = _bands(drawn[:, 0], drawn[:, 1])
        with np.errstate(invalid="ignore"):
            mean_predicted, mean_observed = predicted / weight, observed / weight
        return Reliability(
            edges=self.edges,
            predicted=mean_predicted,
            observed=mean_observed,
            low=low,
            high=high,
            weight=weight / weight.sum(),
            expected_calibration_error=float(np.abs(observed - predicted).sum() / weight.sum()),
        )


def _bands(
    weight: Float[np.ndarray, "resample bin"], observed: Float[np.ndarray, "resample bin"]
) -> tuple[Float[np.ndarray, " bin"], Float[np.ndarray, " bin"]]:
    # a resample without anybody who used a bin says nothing about it
    with np.errstate(invalid="ignore"):
        rates = np.where(weight > 0, observed / weight, np.nan)
    drawn = ~np.isnan(rates).all(axis=0)
    low, high = np.full((2, rates.shape[1]), np.nan)
    low[drawn], high[drawn] = np.nanpercentile(rates[:, drawn], _BAND, axis=0)
    return low, high
