"""Two arms on a table, each with an object to pick and place: geometry, plans, the physical world, trials, studies."""

from ppsim.arms.contacts import clearance_between, contact_tables
from ppsim.arms.geometry import ARMS, Arm
from ppsim.arms.plans import Rest, rest_of_plan, sample_plans, straight_plan
from ppsim.arms.scene import Scene, Task
from ppsim.arms.world import ArmsObservation, ArmsWorld, Touched

__all__ = [
    "ARMS",
    "Arm",
    "ArmsObservation",
    "ArmsWorld",
    "Rest",
    "Scene",
    "Task",
    "Touched",
    "clearance_between",
    "contact_tables",
    "rest_of_plan",
    "sample_plans",
    "straight_plan",
]
