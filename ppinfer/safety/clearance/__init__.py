"""How probable it is that a plan stays clear of what others may do: bodies of capsules, beliefs over plans."""

from ppinfer.safety.clearance.bodies import PlanBodies, plan_distances
from ppinfer.safety.clearance.probability import ClearProbability, clear_probability

__all__ = ["ClearProbability", "PlanBodies", "clear_probability", "plan_distances"]
