"""Where is the human heading, and does it yield? One belief over goal and personality."""

from ppinfer.goals.yielding.evidence import EncounterEvidence
from ppinfer.goals.yielding.model import Yielding
from ppinfer.goals.yielding.online import OnlineYielding
from ppinfer.goals.yielding.reaction import GoalReaction, SoftmaxReaction
from ppinfer.goals.yielding.simulation import Encounter, simulate_encounters

__all__ = [
    "Encounter",
    "EncounterEvidence",
    "GoalReaction",
    "OnlineYielding",
    "SoftmaxReaction",
    "Yielding",
    "simulate_encounters",
]
