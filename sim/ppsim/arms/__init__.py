"""Two arms on a table, each with an object to pick and place: geometry, plans, the physical world, trials, studies."""

from ppsim.arms.contacts import clearance_between, contact_tables
from ppsim.arms.execution import Execution
from ppsim.arms.geometry import ARMS, Arm
from ppsim.arms.plans import Rest, rest_of_plan, sample_plans, straight_plan
from ppsim.arms.playing import Played, Replanned, play
from ppsim.arms.scene import Scene, Task
from ppsim.arms.study import ArmsStudy
from ppsim.arms.world import ArmsObservation, ArmsWorld, Touched

__all__ = [
    "ARMS",
    "Arm",
    "ArmsObservation",
    "ArmsStudy",
    "ArmsWorld",
    "Execution",
    "Played",
    "Replanned",
    "Rest",
    "Scene",
    "Task",
    "Touched",
    "clearance_between",
    "contact_tables",
    "play",
    "rest_of_plan",
    "sample_plans",
    "straight_plan",
]
