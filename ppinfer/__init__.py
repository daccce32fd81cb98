"""ppinfer: what two agents in a shared workspace will do next, and what they are like, as distributions."""

from importlib.metadata import version as _version

from ppinfer.distributions import Axis, Distribution, Factor, Ragged
from ppinfer.errors import (
    AxisError,
    FactorError,
    ImpossibleEvidenceError,
    LogError,
    ModelError,
    PPInferError,
)

__version__ = _version("ppinfer")

__all__ = [
    "Axis",
    "AxisError",
    "Distribution",
    "Factor",
    "FactorError",
    "ImpossibleEvidenceError",
    "LogError",
    "ModelError",
    "PPInferError",
    "Ragged",
    "__version__",
]
