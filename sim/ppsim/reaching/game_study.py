"""The study of the reaching game: every robot with every simulated human, in paired games."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from ppinfer.studies import RecordingHeader, Trial
from ppsim.errors import SimulationError
from ppsim.naming import checked_names
from ppsim.reaching.humans import HUMANS, HumanSeat, make_human
from ppsim.reaching.movement import Movement
from ppsim.reaching.playing import Played, play, segments_of
from ppsim.reaching.robots import GOAL_ROBOTS, ROBOTS, RobotSeat, Thought, make_robot
from ppsim.reaching.rules import Rules
from ppsim.reaching.world import AGENTS, ReachingWorld, Redraw
from ppsim.seeds import trial_seed

HUMAN, ROBOT = AGENTS


@dataclass(frozen=True)
class GameStudy:
    """All that a study of the reaching game is, its seed included: trial i is a function of this and of i.

    Trials run over robots first, then humans, numbers of goals and games, so that a study of more games begins with the
    same trials. Those of one game share the starts, and those with as many goals also the first goals and the chance in
    every later draw of them: they are paired.

    Parameters
    ----------
    games : int
        How many for each robot, human and number of goals.
    robots : tuple of str
        Names of `ROBOTS`, or ``module:attribute`` of a GoalChooser of one's own.
    humans : tuple of str
        Names of `HUMANS`.
    goals : tuple of int
        How many goals there are at a time.
    seed : int
        Of the study.
    duration, dt : float
        Length of a game and time step (s).
    state_weight, control_weight : float
        Of both agents' LQR: Q = state_weight I, R = control_weight I.
    rationality : float
        Inverse temperature with which agents infer each other's goals, 1/cost.
    reactive_threshold : float
        How sure the reactive robot wants to be of the human's goal.
    reaction : {"reacted", "softmax"}
        What robots take the human's reaction to their goal for; see `make_robot`.
    keep_clear : {"proactive", "all", "none"}
        Which robots keep clear of the human; see `KeepClear`.
    human_noise : float
        Standard deviation of a disturbance of the human's velocity, per dimension and step (m/s).
    separation, clearance : float
        As in `Rules` (m).
    redraw : {"picked", "all"}
        Which goals are drawn anew when the team scores.

    Raises
    ------
    SimulationError, ModelError
        Where a value is out of its range, or nobody is called by a name.

    Examples
    --------
    >>> study = GameStudy(games=2, robots=("naive",), humans=("stubborn",), duration=2.0)
    >>> study.trials, study.trial_id(1), study.trial(1).position.shape
    (2, 'game-1/3-goals/naive/stubborn', (20, 2, 2))
    """

    games: int = 1
    robots: tuple[str, ...] = GOAL_ROBOTS
    humans: tuple[str, ...] = tuple(HUMANS)
    goals: tuple[int, ...] = (3,)
    seed: int = 0
    duration: float = 30.0
    dt: float = Movement.dt
    state_weight: float = Movement.state_weight
    control_weight: float = Movement.control_weight
    rationality: float = Movement.rationality
    reactive_threshold: float = 0.8
    reaction: str = "reacted"
    keep_clear: str = "proactive"
    human_noise: float = 0.0
    separation: float = Rules.separation
    clearance: float = Rules.clearance
    redraw: Redraw = "picked"

    def __post_init__(self) -> None:
        for name in ("robots", "humans", "goals"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        for name, low in (("games", 1), ("seed", 0)):
            if getattr(self, name) < low:
                raise SimulationError(f"{name} must be at least {low}; got {getattr(self, name)}")
        for name in ("duration", "dt"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise SimulationError(f"{name} must be positive and finite (s); got {getattr(self, name)!r}")
        if self.samples < 2:
            raise SimulationError(
                f"a game of {self.duration:g} s has {self.samples} samples {self.dt:g} s apart; at least 2 are needed"
            )
        checked_names("robots", self.robots, ROBOTS, own=True)
        checked_names("humans", self.humans, tuple(HUMANS))
        if not self.goals or len(set(self.goals)) < len(self.goals):
            raise SimulationError(
                f"goals must be one number or several different ones; got {list(self.goals)}"
            )
        # whatever cannot be played is told now
        for count in self.goals:
            self.world(count)
        for human in self.humans:
            self.human(human)
        for robot in self.robots:
            self.robot(robot)

    @property
    def samples(self) -> int:
        """Samples of a game."""
        return round(self.duration / self.dt)

    @property
    def trials(self) -> int:
        """How many trials there are."""
        return self.games * len(self._cells)

    @cached_property
    def movement(self) -> Movement:
        """How both agents move."""
        return Movement(
            dt=self.dt,
            state_weight=self.state_weight,
            control_weight=self.control_weight,
            rationality=self.rationality,
        )

    @cached_property
    def _cells(self) -> tuple[tuple[int, str, str], ...]:
        return tuple(
            (count, robot, human) for count in self.goals for human in self.humans for robot in self.robots
        )

    def cell(self, index: int) -> tuple[int, int, str, str]:
        """Return game, number of goals, robot and human of a trial."""
        game, cell = divmod(index, len(self._cells))
        return game, *self._cells[cell]

    def trial_id(self, index: int) -> str:
        """Return the name of a trial."""
        game, count, robot, human = self.cell(index)
        return f"game-{game}/{count}-goals/{robot}/{human}"

    def world(self, goals: int) -> ReachingWorld:
        """Return a world of one's own with that many goals, to be reset."""
        rules = Rules(goals=goals, separation=self.separation, clearance=self.clearance)
        return ReachingWorld(rules, self.movement.dynamics, redraw=self.redraw)

    def robot(self, name: str) -> RobotSeat:
        """Return a robot's seat."""
        return make_robot(
            name,
            self.movement,
            reactive_threshold=self.reactive_threshold,
            reaction=self.reaction,
            keep_clear=self.keep_clear,
        )

    def human(self, name: str) -> HumanSeat:
        """Return a simulated human's seat."""
        return make_human(name, self.movement, noise=self.human_noise)

    def header(self) -> RecordingHeader:
        """Return what a recording of this study says once."""
        return RecordingHeader(
            agents=AGENTS,
            goals=tuple(str(goal) for goal in range(max(self.goals))),
            has_velocity=(True, True),
            title="Simulated reaching game: a robot and a human among goals",
            source="ppsim reach",
            configuration=self.configuration(),
        )

    def configuration(self) -> dict[str, Any]:
        """Return the parameters as JSON can hold them."""
        told = {
            name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self).items()
        }
        rules = asdict(self.world(self.goals[0]).rules)
        del rules["goals"]
        return {"world": "reaching-game", **told, "dynamics": "double-integrator", "rules": rules}

    def trial(self, index: int) -> Trial:
        """Play trial `index` and return what is logged of it."""
        game, count, robot, human = self.cell(index)
        seed = trial_seed(self.seed, game)
        seat = self.robot(robot)
        world = self.world(count)
        played = play(world, {HUMAN: self.human(human), ROBOT: seat}, seed=seed, samples=self.samples)
        most = max(self.goals)
        goals = np.full((self.samples, most, 2), np.nan)
        goals[:, :count] = played.goals
        return Trial(
            trial_id=self.trial_id(index),
            participant=f"simulated {human}",
            time=played.time,
            position=played.position,
            velocity=played.velocity,
            goal_position=goals,
            condition=f"{robot}, {count} goals",
            seed=seed,
            outcome="time over",
            controller={ROBOT: robot, HUMAN: human},
            segments=[
                segment
                for which, agent in enumerate(AGENTS)
                for segment in segments_of(played, which, agent, world.rules.pick_radius)
            ],
            variables={
                **_events(played, game, count, self.dt),
                **_beliefs(seat.thoughts, most),
            },
        )


def _events(played: Played, game: int, count: int, dt: float) -> dict[str, tuple[Any, ...]]:
    first = float(np.argmax(played.scored)) * dt if played.scored.any() else math.nan
    human, robot = (changes_of_goal(played.pursued[:, at], played.drawn) for at in range(len(AGENTS)))
    return {
        "pursued": (
            ("sample", "agent"),
            played.pursued.astype(np.int8),
            {"long_name": "index of the goal that the agent goes for; -1 = it waits"},
        ),
        "scored": (("sample",), played.scored.astype(np.int8), {"long_name": "the team scored here"}),
        "collision": (("sample",), played.collided.astype(np.int8), {"long_name": "agents collided here"}),
        "team_score": ((), np.int64(played.score), {"long_name": "points of the team at the end"}),
        "collisions": ((), np.int64(played.collided.sum()), {"long_name": "how often agents collided"}),
        "human_goal_changes": ((), np.int64(human), {"long_name": "changes of the human's mind"}),
        "robot_goal_changes": ((), np.int64(robot), {"long_name": "changes of the robot's mind"}),
        "first_score_s": (
            (),
            np.float64(first),
            {"long_name": "when the team first scored; NaN = never", "units": "s"},
        ),
        "scene": ((), np.int64(game)),
        "goal_count": ((), np.int64(count), {"long_name": "goals at a time"}),
    }


def _beliefs(thoughts: list[Thought], most: int) -> dict[str, tuple[Any, ...]]:
    told = {
        "live_log_belief": ("belief", "log b_R(theta_prior) that the robot held then"),
        "live_log_mental_model": ("mental_model", "log b_H(theta_R) that the robot took the human to hold"),
        "live_log_post": ("post", "log b_post(theta_post) given the robot's goal then, as the robot thought"),
    }
    return {
        name: (("sample", "goal"), _padded(thoughts, attribute, most), {"long_name": meaning})
        for name, (attribute, meaning) in told.items()
    }


def _padded(thoughts: list[Thought], attribute: str, most: int) -> Float[np.ndarray, "sample goal"]:
    values = np.array([getattr(thought, attribute) for thought in thoughts])
    padded = np.full((len(values), most), -np.inf)
    padded[:, : values.shape[1]] = values
    return padded


def changes_of_goal(pursued: Int[np.ndarray, " sample"], drawn: Int[np.ndarray, " sample"]) -> int:
    """Return how often an agent turned to another goal while the goals stayed what they were.

    A wait is no goal: who waits and goes on has not changed its mind.

    Examples
    --------
    >>> changes_of_goal(np.array([0, -1, 0, 1, 2, 2]), np.array([0, 0, 0, 0, 1, 1]))
    1
    """
    going = pursued >= 0
    goal, draw = pursued[going], drawn[going]
    return int(((np.diff(goal) != 0) & (np.diff(draw) == 0)).sum())
