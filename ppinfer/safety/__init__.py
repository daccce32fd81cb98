"""Long-term safe probability of plans, safe control, and candidate trajectories."""

from ppinfer.safety.candidate_control import CandidateController
from ppinfer.safety.candidates import Candidates, candidate_trajectories
from ppinfer.safety.choosing import PlanChoice, choose_safe_plan
from ppinfer.safety.clearance import ClearProbability, PlanBodies, clear_probability, plan_distances
from ppinfer.safety.control import SafeControl, SafeController
from ppinfer.safety.distances import Body, body_gap, segment_distance
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
from ppinfer.safety.safe_state import SafeState, find_safe_state
from ppinfer.safety.uncertainty import coverage_factor, uncertainty_growth

__all__ = [
    "Body",
    "CandidateController",
    "Candidates",
    "ClearProbability",
    "LinearAgent",
    "Mover",
    "PlanBodies",
    "PlanChoice",
    "Rollouts",
    "SafeControl",
    "SafeController",
    "SafeProbabilities",
    "SafeProbability",
    "SafeState",
    "StaticObstacle",
    "body_gap",
    "candidate_trajectories",
    "choose_safe_plan",
    "clear_probability",
    "clopper_pearson_lower",
    "clopper_pearson_upper",
    "coverage_factor",
    "draw_rollouts",
    "find_safe_state",
    "least_safe",
    "long_term_safe_probability",
    "nominal_motion",
    "plan_distances",
    "plan_safe_probability",
    "potential_field_control",
    "segment_distance",
    "uncertainty_growth",
]
