"""Which equilibrium? Norms, personalities, and the policies that choose among them."""

from collections.abc import Callable

from ppinfer.coordination.defensive import Defensive
from ppinfer.coordination.equilibria import coordination_equilibria
from ppinfer.coordination.norm_nash import CommittedNormNash, NormNash
from ppinfer.coordination.norms import MinNorm, Norm
from ppinfer.coordination.plans import PlanSet
from ppinfer.coordination.policy import Decision, Policy
from ppinfer.coordination.prediction import PlanPrediction
from ppinfer.coordination.risk import Anticipation, BayesRisk
from ppinfer.coordination.selfish import Selfish
from ppinfer.coordination.situation import Motion, Situation

#: Policies that commands know by name, each made by calling it; a new one is one small file and a line here.
POLICIES: dict[str, Callable[..., Policy]] = {
    policy.name: policy for policy in (Defensive, Selfish, NormNash, CommittedNormNash, BayesRisk)
}

__all__ = [
    "POLICIES",
    "Anticipation",
    "BayesRisk",
    "CommittedNormNash",
    "Decision",
    "Defensive",
    "MinNorm",
    "Motion",
    "Norm",
    "NormNash",
    "PlanPrediction",
    "PlanSet",
    "Policy",
    "Selfish",
    "Situation",
    "coordination_equilibria",
]
