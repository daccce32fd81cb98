"""Which equilibrium? Norms, personalities, and the policies that choose among them."""

from collections.abc import Callable

from ppinfer.coordination.bayes_nash import BayesNash, CostBayesNash, LiteralBayesNash
from ppinfer.coordination.defensive import Defensive
from ppinfer.coordination.design import PlayDesign
from ppinfer.coordination.distances import Distance, Euclidean, RootMeanSquare, TimeWarping
from ppinfer.coordination.dominance_norm import RiskDominant
from ppinfer.coordination.equilibria import coordination_equilibria
from ppinfer.coordination.evidence import PlayEvidence
from ppinfer.coordination.goal_choice import GoalChoiceGame
from ppinfer.coordination.history import PlayHistory
from ppinfer.coordination.inference import infer_personality
from ppinfer.coordination.likelihood import TrajectoryLikelihood
from ppinfer.coordination.literal_personality import LiteralPersonality
from ppinfer.coordination.mixture_norm import MixtureNorm
from ppinfer.coordination.norm_nash import CommittedNormNash, NormNash
from ppinfer.coordination.norms import MinNorm, Norm
from ppinfer.coordination.oracle import OracleNash
from ppinfer.coordination.personality import Personality
from ppinfer.coordination.personality_model import PersonalityModel, PersonalityState
from ppinfer.coordination.plans import PlanSet
from ppinfer.coordination.policy import Decision, Policy
from ppinfer.coordination.prediction import PlanPrediction
from ppinfer.coordination.predictive_personality import PredictivePersonality
from ppinfer.coordination.risk import BayesRisk
from ppinfer.coordination.selfish import Selfish
from ppinfer.coordination.situation import Motion, Situation
from ppinfer.coordination.welfare_norms import Egalitarian, UniformNorm, Utilitarian

#: Policies that commands know by name, each made by calling it; a new one is one small file and a line here.
POLICIES: dict[str, Callable[..., Policy]] = {
    policy.name: policy
    for policy in (
        Defensive,
        Selfish,
        NormNash,
        CommittedNormNash,
        BayesNash,
        CostBayesNash,
        LiteralBayesNash,
        BayesRisk,
        OracleNash,
    )
}

#: Norms by name, for configuration.
NORMS: dict[str, Callable[..., Norm]] = {
    norm.name: norm for norm in (MinNorm, Utilitarian, Egalitarian, RiskDominant, UniformNorm)
}

__all__ = [
    "NORMS",
    "POLICIES",
    "BayesNash",
    "BayesRisk",
    "CommittedNormNash",
    "CostBayesNash",
    "Decision",
    "Defensive",
    "Distance",
    "Egalitarian",
    "Euclidean",
    "GoalChoiceGame",
    "LiteralBayesNash",
    "LiteralPersonality",
    "MinNorm",
    "MixtureNorm",
    "Motion",
    "Norm",
    "NormNash",
    "OracleNash",
    "Personality",
    "PersonalityModel",
    "PersonalityState",
    "PlanPrediction",
    "PlanSet",
    "PlayDesign",
    "PlayEvidence",
    "PlayHistory",
    "Policy",
    "PredictivePersonality",
    "RiskDominant",
    "RootMeanSquare",
    "Selfish",
    "Situation",
    "TimeWarping",
    "TrajectoryLikelihood",
    "UniformNorm",
    "Utilitarian",
    "coordination_equilibria",
    "infer_personality",
]
