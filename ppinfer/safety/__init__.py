"""How safe is a plan? Long-term safe probability, safe control and candidate trajectories."""

from ppinfer.safety.motion import LinearAgent, Mover

__all__ = ["LinearAgent", "Mover"]
