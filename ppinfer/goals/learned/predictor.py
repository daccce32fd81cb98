"""A trained network, as a function from examples to probabilities."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float

from ppinfer.goals.learned.configuration import NetworkConfiguration
from ppinfer.goals.learned.examples import ExampleSource, PredictionExamples
from ppinfer.goals.learned.extra import require_torch, threads
from ppinfer.goals.learned.features import features_of
from ppinfer.goals.learned.network import log_probabilities

_BATCH = 1024


@dataclass(frozen=True, eq=False)
class GoalPredictor:
    """p(human's goal | motion so far, the robot's plan, the goals), with weights that were learned.

    Parameters
    ----------
    configuration : NetworkConfiguration
        Sizes and units.
    network : torch.nn.Module
        The layers, as `build_network` makes them.
    """

    configuration: NetworkConfiguration
    network: Any

    @cached_property
    def _exact(self) -> Any:
        # weights were learned in single precision; in double, the order of the goals is no matter of rounding
        return copy.deepcopy(self.network).double()

    def log_probabilities(self, examples: PredictionExamples) -> Float[np.ndarray, "example goal"]:
        """Return log p(goal) for every example, -inf for goals that are absent."""
        torch = require_torch()
        features = features_of(examples, self.configuration)
        with threads(1), torch.inference_mode():
            found: np.ndarray = log_probabilities(self._exact, features, self.configuration.hidden).numpy()
        return found

    def log_probabilities_of(self, source: ExampleSource) -> Float[np.ndarray, "example goal"]:
        """Return log p(goal) for every example of a source, read in parts."""
        starts = range(0, max(1, len(source)), _BATCH)
        parts = [
            self.log_probabilities(source.read(start, min(start + _BATCH, len(source)))) for start in starts
        ]
        return np.concatenate(parts)
