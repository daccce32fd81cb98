"""How good predicted probabilities of the human's goal are: error, log probability and calibration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.errors import LogError
from ppinfer.studies.calibration import Reliability

_BINS = 10


@dataclass(frozen=True)
class PredictionScore:
    """Scores of predicted goal probabilities p against how often goals were reached, f.

    Parameters
    ----------
    loss : float
        Mean squared error: the mean over examples and the goals of each of (p - f)^2, which training minimises.
    brier : float
        Mean Brier score of one continuation: sum over goals of f (1 - p)^2 + (1 - f) p^2.
    mean_log_probability : float
        Mean over examples of sum_g f_g log p_g, in nats; -inf where what happened was held impossible.
    expected_calibration_error : float
        Of the probabilities of all goals, in bins of equal width, every example weighing the same.
    top_calibration_error : float
        Of each example's most probable goal.
    examples : int
        How many.
    reliability : Reliability
        The bins behind `expected_calibration_error`, without bands.
    """

    loss: float
    brier: float
    mean_log_probability: float
    expected_calibration_error: float
    top_calibration_error: float
    examples: int
    reliability: Reliability

    def to_json(self) -> dict[str, float | int]:
        """Return the numbers."""
        return {
            "loss": self.loss,
            "brier": self.brier,
            "mean_log_probability": self.mean_log_probability,
            "expected_calibration_error": self.expected_calibration_error,
            "top_calibration_error": self.top_calibration_error,
            "examples": self.examples,
        }


def score_predictions(
    log_probability: Float[np.ndarray, "example goal"],
    frequency: Float[np.ndarray, "example goal"],
    present: Bool[np.ndarray, "example goal"],
) -> PredictionScore:
    """Score predicted log probabilities against how often goals were reached.

    Raises
    ------
    LogError
        Where there are no examples.

    Examples
    --------
    >>> sure = np.log(np.array([[0.75, 0.25], [0.5, 0.5]]))
    >>> came = np.array([[1.0, 0.0], [0.0, 1.0]])
    >>> score = score_predictions(sure, came, np.ones((2, 2), bool))
    >>> score.loss, score.brier, round(score.mean_log_probability, 3)
    (0.15625, 0.3125, -0.49)
    """
    if not len(log_probability):
        raise LogError("no examples to score predictions on")
    frequency = frequency.astype(np.float64)
    p = np.exp(log_probability)
    goals = present.sum(axis=1)
    squares = np.where(present, (p - frequency) ** 2, 0.0).sum(axis=1)
    # one continuation is a draw from f: its Brier score is the error from f and the variance of the draw
    spread = (frequency * (1.0 - frequency)).sum(axis=1)
    with np.errstate(invalid="ignore"):
        surprise = np.where(frequency > 0, frequency * log_probability, 0.0).sum(axis=1)
    row, goal = np.nonzero(present)
    every = _reliability(p[row, goal], frequency[row, goal], 1.0 / goals[row])
    top = p.argmax(axis=1)
    index = np.arange(len(p))
    most = _reliability(p[index, top], frequency[index, top], np.ones(len(p)))
    return PredictionScore(
        loss=float(np.mean(squares / goals)),
        brier=float(np.mean(squares + spread)),
        mean_log_probability=float(np.mean(surprise)),
        expected_calibration_error=every.expected_calibration_error,
        top_calibration_error=most.expected_calibration_error,
        examples=len(p),
        reliability=every,
    )


def _reliability(
    predicted: Float[np.ndarray, " case"],
    observed: Float[np.ndarray, " case"],
    weight: Float[np.ndarray, " case"],
) -> Reliability:
    edges = np.linspace(0, 1, _BINS + 1)
    which = np.clip(np.searchsorted(edges, predicted, side="left") - 1, 0, _BINS - 1)
    total, sum_predicted, sum_observed = (
        np.bincount(which, weights=values, minlength=_BINS)
        for values in (weight, weight * predicted, weight * observed)
    )
    with np.errstate(invalid="ignore"):
        mean_predicted, mean_observed = sum_predicted / total, sum_observed / total
    none = np.full(_BINS, np.nan)
    return Reliability(
        edges=edges,
        predicted=mean_predicted,
        observed=mean_observed,
        low=none,
        high=none,
        weight=total / total.sum(),
        expected_calibration_error=float(np.abs(sum_observed - sum_predicted).sum() / total.sum()),
    )
