"""The simulation's own refusal; it belongs to ppinfer's family of errors."""

from __future__ import annotations

from ppinfer.errors import PPInferError


class SimulationError(PPInferError, ValueError):
    """A world that cannot be built, or was used in a way that it does not understand."""
