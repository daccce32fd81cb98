"""Metrics of every trial of a study, and what they come to by condition, between conditions and over rounds."""

from ppinfer.studies.metrics.measuring import trial_metrics
from ppinfer.studies.metrics.metric import Metric
from ppinfer.studies.metrics.registry import METRICS, metrics_table
from ppinfer.studies.metrics.trial_metrics import TrialMetrics

__all__ = ["METRICS", "Metric", "TrialMetrics", "metrics_table", "trial_metrics"]
