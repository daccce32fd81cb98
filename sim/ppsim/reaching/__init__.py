"""Two point agents among goals: the game of the reaching study, its rules, agents and trials."""

from ppsim.reaching.game_study import GameStudy
from ppsim.reaching.goal_choice import ChangingMind, GoalChoice, NearestGoal, NearGoal, RandomGoal
from ppsim.reaching.humans import make_human
from ppsim.reaching.keeping_clear import KeepClear
from ppsim.reaching.movement import Movement
from ppsim.reaching.playing import Played, play, segments_of
from ppsim.reaching.robots import make_robot
from ppsim.reaching.rules import Rules
from ppsim.reaching.seats import NoisilyRationalSeat
from ppsim.reaching.study import ReachingStudy
from ppsim.reaching.tracker import Tracker
from ppsim.reaching.world import Collided, Observation, ReachingWorld, Scored

__all__ = [
    "ChangingMind",
    "Collided",
    "GameStudy",
    "GoalChoice",
    "KeepClear",
    "Movement",
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
    "make_human",
    "make_robot",
    "play",
    "segments_of",
]
