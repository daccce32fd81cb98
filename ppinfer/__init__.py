"""ppinfer: what two agents in a shared workspace will do next, and what they are like, as distributions."""

from importlib import import_module as _import_module
from importlib.metadata import version as _version
from typing import TYPE_CHECKING

from ppinfer.errors import (
    AxisError,
    FactorError,
    ImpossibleEvidenceError,
    LogError,
    ModelError,
    PPInferError,
)

if TYPE_CHECKING:
    from ppinfer.distributions import Axis, Distribution, Factor, Ragged

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

_ALGEBRA = frozenset({"Axis", "Distribution", "Factor", "Ragged"})


def __getattr__(name: str) -> object:
    # loaded when first asked for: a command that only starts another process, or says what it can do, is quick
    if name not in _ALGEBRA:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(_import_module("ppinfer.distributions"), name)
