"""Long-term safe probability of plans, safe control, and candidate trajectories."""

from ppinfer.safety.candidates import Candidates, candidate_trajectories
from ppinfer.safety.long_term import long_term_safe_probability, plan_safe_probability
from ppinfer.safety.motion import LinearAgent, Mover
from ppinfer.safety.obstacles import StaticObstacle
from ppinfer.safety.potential_field import potential_field_control
from ppinfer.safety.probability import (
    SafeProbabilities,
    SafeProbability,
    clopper_pearson_lower,
    clopper_pearson_upper,
    least_safe,
)
from ppinfer.safety.rollouts import Rollouts, draw_rollouts, nominal_motion
from ppinfer.safety.uncertainty import coverage_factor, uncertainty_growth

__all__ = [
    "Candidates",
    "LinearAgent",
    "Mover",
    "Rollouts",
    "SafeProbabilities",
    "SafeProbability",
    "StaticObstacle",
    "candidate_trajectories",
    "clopper_pearson_lower",
    "clopper_pearson_upper",
    "coverage_factor",
    "draw_rollouts",
    "least_safe",
    "long_term_safe_probability",
    "nominal_motion",
    "plan_safe_probability",
    "potential_field_control",
    "uncertainty_growth",
]
