"""Which goal? Noisily rational agents, beliefs over their goals, and models fitted to people."""

from ppinfer.goals.baselines import Heading, NearestGoal
from ppinfer.goals.belief import GoalBelief, infer_goals
from ppinfer.goals.conditional import (
    GoalConditional,
    SoftmaxConditional,
    conditional_log_weights,
    overall_post,
    post_goals,
)
from ppinfer.goals.coupled.model import GoalCoupled
from ppinfer.goals.dynamics import Dynamics
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.kalman import GoalKalman
from ppinfer.goals.lqr import GoalLQR
from ppinfer.goals.mental_model import MentalModel, infer_mental_model, paper_agent
from ppinfer.goals.model import GoalDesign, GoalModel, Observation
from ppinfer.goals.motion import causal_motion
from ppinfer.goals.noisily_rational import NoisilyRational
from ppinfer.goals.online import OnlineGoalBelief
from ppinfer.goals.partners import PartnerMotion
from ppinfer.goals.prediction import BehaviourPredictor
from ppinfer.goals.rationality import GoalAndRationality
from ppinfer.goals.rationality_online import OnlineGoalAndRationality
from ppinfer.goals.reacted import ReactedConditional

#: Models that commands know by name; a new one is one small file and a line here.
MODELS: dict[str, type[GoalModel]] = {
    model.name: model for model in (GoalLQR, GoalKalman, GoalCoupled, NearestGoal, Heading)
}

__all__ = [
    "MODELS",
    "BehaviourPredictor",
    "Dynamics",
    "GoalAndRationality",
    "GoalBelief",
    "GoalConditional",
    "GoalCoupled",
    "GoalDesign",
    "GoalEvidence",
    "GoalKalman",
    "GoalLQR",
    "GoalModel",
    "Heading",
    "MentalModel",
    "NearestGoal",
    "NoisilyRational",
    "Observation",
    "OnlineGoalAndRationality",
    "OnlineGoalBelief",
    "PartnerMotion",
    "ReactedConditional",
    "SoftmaxConditional",
    "causal_motion",
    "conditional_log_weights",
    "infer_goals",
    "infer_mental_model",
    "overall_post",
    "paper_agent",
    "post_goals",
]
