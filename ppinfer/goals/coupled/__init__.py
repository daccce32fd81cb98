"""What one agent will do beside others: goals inferred by a product of small experts."""

from ppinfer.goals.coupled.conditional import Conditional
from ppinfer.goals.coupled.distance import Distance, Lead
from ppinfer.goals.coupled.expert import Expert, GeometryExpert, OnlineExpert
from ppinfer.goals.coupled.geometry import Geometry
from ppinfer.goals.coupled.lqr import LqrMotion
from ppinfer.goals.coupled.model import GoalCoupled
from ppinfer.goals.coupled.motion import Motion
from ppinfer.goals.coupled.partner import Partner
from ppinfer.goals.coupled.registry import EXPERTS

__all__ = [
    "EXPERTS",
    "Conditional",
    "Distance",
    "Expert",
    "Geometry",
    "GeometryExpert",
    "GoalCoupled",
    "Lead",
    "LqrMotion",
    "Motion",
    "OnlineExpert",
    "Partner",
]
