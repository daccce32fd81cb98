"""Choosing the goal that the robot goes for, given what the human will do about it."""

from ppinfer.goals.choice.chooser import GoalChooser, GoalDecision, GoalSituation

__all__ = ["GoalChooser", "GoalDecision", "GoalSituation"]
