"""Long-term safe probability of plans, safe control, and candidate trajectories."""

from ppinfer.safety.motion import LinearAgent, Mover

__all__ = ["LinearAgent", "Mover"]
