"""Choosing the goal that the robot goes for, given what the human will do about it."""

from ppinfer.goals.choice.chooser import GoalChooser, GoalDecision, GoalSituation
from ppinfer.goals.choice.courtesy import Courtesy
from ppinfer.goals.choice.expected_cost import ExpectedCost
from ppinfer.goals.choice.influence import Influence
from ppinfer.goals.choice.joint import JointChoice, TrajectoryDecision, point_agent
from ppinfer.goals.choice.nearest import NearestGoal
from ppinfer.goals.choice.reactive import ReactToGoal
from ppinfer.goals.choice.switching import Switching

#: Choosers that commands know by name; a new one is one small file and a line here.
CHOOSERS: dict[str, type[GoalChooser]] = {
    chooser.name: chooser
    for chooser in (NearestGoal, ReactToGoal, Courtesy, Influence, Switching, ExpectedCost, JointChoice)
}

__all__ = [
    "CHOOSERS",
    "Courtesy",
    "ExpectedCost",
    "GoalChooser",
    "GoalDecision",
    "GoalSituation",
    "Influence",
    "JointChoice",
    "NearestGoal",
    "ReactToGoal",
    "Switching",
    "TrajectoryDecision",
    "point_agent",
]
