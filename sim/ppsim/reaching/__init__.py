"""Two point agents among goals: the game of the reaching study, its rules, agents and trials."""

from ppsim.reaching.goal_choice import ChangingMind, GoalChoice, NearestGoal, NearGoal, RandomGoal
from ppsim.reaching.playing import Played, play, segments_of
from ppsim.reaching.rules import Rules
from ppsim.reaching.seats import NoisilyRationalSeat
from ppsim.reaching.study import ReachingStudy
from ppsim.reaching.tracker import Tracker
from ppsim.reaching.world import Collided, Observation, ReachingWorld, Scored

__all__ = [
    "ChangingMind",
    "Collided",
    "GoalChoice",
    "NearGoal",
    "NearestGoal",
    "NoisilyRationalSeat",
    "Observation",
    "Played",
    "RandomGoal",
    "ReachingStudy",
    "ReachingWorld",
    "Rules",
    "Scored",
    "Tracker",
    "play",
    "segments_of",
]
