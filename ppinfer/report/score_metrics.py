"""Scores of a posterior as metrics of its trials, so that conditions can be compared in them."""

from __future__ import annotations

import numpy as np
import xarray as xr
from jaxtyping import Float, Shaped

from ppinfer.plots.replan_beliefs import ReplanBeliefs
from ppinfer.report.goal_parts import ScoredPosterior
from ppinfer.studies.metrics import TrialMetrics
from ppinfer.studies.metrics.summaries import MetricFacts

_COLUMNS = ("trial_id", "participant", "condition", "round")


def score_metrics(scored: ScoredPosterior) -> TrialMetrics | None:
    """Return accuracy and log posterior of the true goal in every trial: means over its segments; NaN without any.

    Taken after the middle one of the shares. None where nothing is scored.
    """
    posterior, scores = scored.posterior, scored.scores
    if scores is None:
        return None
    at = scores.segments.sizes["at"] // 2
    share = scores.overall[at].at
    trial = posterior["segment_trial"].values[scores.segments["segment"].values]
    count = np.bincount(trial, minlength=posterior.sizes["trial"])
    logs = scores.segments["log_posterior"].values[at]
    columns = [scores.segments["correct"].values[at].astype(np.float64)]
    metrics = [
        MetricFacts(
            "accuracy",
            "",
            f"share of a trial's segments whose most probable goal is the true one, after {100 * share:.4g} % of each",
        )
    ]
    # a true goal that is impossible has no mean logarithm
    if np.isfinite(logs).all():
        columns.append(logs)
        metrics.append(
            MetricFacts(
                "log_posterior", "nat", "logarithm of the true goal's probability there, mean over segments"
            )
        )
    values = [_means(column, trial, count) for column in columns]
    return TrialMetrics(np.column_stack(values), tuple(metrics), _columns(posterior))


def belief_metrics(posterior: xr.Dataset, beliefs: ReplanBeliefs, label: str) -> TrialMetrics:
    """Return the mean belief of every trial that somebody favours itself; NaN where none was held."""
    trials = posterior.sizes["trial"]
    count = np.bincount(beliefs.trial, minlength=trials)
    name = f"p_{label}_favours_itself"
    facts = MetricFacts(name, "", f"probability that the {label} favours itself, mean over a trial's replans")
    columns = _columns(posterior) | {"robot_controller": beliefs.robot, "human_controller": beliefs.human}
    return TrialMetrics(_means(beliefs.of(label), beliefs.trial, count)[:, None], (facts,), columns)


def _means(
    values: Float[np.ndarray, " part"],
    trial: Shaped[np.ndarray, " part"],
    count: Shaped[np.ndarray, " trial"],
) -> Float[np.ndarray, " trial"]:
    total = np.bincount(trial, weights=values, minlength=len(count))
    means: np.ndarray = np.divide(total, count, out=np.full(len(count), np.nan), where=count > 0)
    return means


def _columns(posterior: xr.Dataset) -> dict[str, Shaped[np.ndarray, " trial"]]:
    columns = {name: posterior[name].values for name in _COLUMNS if name in posterior}
    return {name: column if name == "round" else column.astype(str) for name, column in columns.items()}
