"""Conditional prediction learned from examples (Appendix II); an extra: pip install 'ppinfer[learned]'.

PyTorch is imported where something is trained or predicted, not with this package.
"""

from ppinfer.goals.learned.conditional import LearnedConditional
from ppinfer.goals.learned.configuration import NetworkConfiguration
from ppinfer.goals.learned.examples import ExampleSource, PredictionExamples
from ppinfer.goals.learned.predictor import GoalPredictor
from ppinfer.goals.learned.training import Trained, Training, train
from ppinfer.goals.learned.weights import read_predictor, write_predictor

__all__ = [
    "ExampleSource",
    "GoalPredictor",
    "LearnedConditional",
    "NetworkConfiguration",
    "PredictionExamples",
    "Trained",
    "Training",
    "read_predictor",
    "train",
    "write_predictor",
]
