"""A study in the reaching world: participants, their trials, and what is logged of them."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float

from ppinfer.goals import Dynamics, NoisilyRational
from ppinfer.goals.dynamics import DYNAMICS_NAMES
from ppinfer.goals.model import require_range
from ppinfer.studies import RecordingHeader, Trial
from ppsim.errors import SimulationError
from ppsim.reaching.goal_choice import GOAL_CHOICES, ChangingMind, GoalChoice
from ppsim.reaching.playing import Played, play, segments_of
from ppsim.reaching.rules import Rules
from ppsim.reaching.seats import NoisilyRationalSeat
from ppsim.reaching.tracker import Tracker
from ppsim.reaching.world import AGENTS, ReachingWorld
from ppsim.seeds import participant_rng, streams, trial_seed

HUMAN, ROBOT = AGENTS
CONTROL_QUANTITY = {1: "velocity", 2: "acceleration"}


@dataclass(frozen=True)
class ReachingStudy:
    """All that a simulated reaching study is, its seed included: trial i is a function of this and of i.

    Trial i is that of participant i modulo `participants`, so a longer study begins with the same trials.

    Parameters
    ----------
    seed : int
        Of the study.
    participants : int
        How many there are.
    goals, separation : int, float
        As in `Rules`.
    duration, dt : float
        Length of a trial and time between samples, in s.
    dynamics : {"double-integrator", "single-integrator"}
        Whether actions are accelerations or velocities.
    rationality : float
        Inverse temperature beta of the human, in 1/cost.
    rationality_spread : float
        Standard deviation of the logarithm of the participants' rationality about that value; 0: all alike.
    robot_rationality : float
        The robot's.
    control_weight : float
        R = control_weight I of both agents' costs, with Q = I.
    human, robot : {"near-goal", "nearest-goal", "random-goal"}
        How each chooses its goal; the robot leaves a goal to the human who is at it, the human leaves none.
    stay : float
        Probability per sample that the human's goal stays what it is.
    noise, dropouts, outliers : float
        Of the tracker; see `Tracker`.
    positions_only : bool
        Leave out velocities and controls, which are logged only where positions are without noise.

    Raises
    ------
    SimulationError, ModelError
        Where a value is out of its range.

    Examples
    --------
    >>> study = ReachingStudy(seed=3, duration=5.0)
    >>> trial = study.trial(0)
    >>> trial.participant, trial.position.shape
    ('p1', (50, 2, 2))
    """

    seed: int = 0
    participants: int = 6
    goals: int = 4
    separation: float = 3.0
    duration: float = 30.0
    dt: float = 0.1
    dynamics: str = "double-integrator"
    rationality: float = 0.03
    rationality_spread: float = 0.4
    robot_rationality: float = 1.0
    control_weight: float = 5.0
    human: str = "random-goal"
    robot: str = "nearest-goal"
    stay: float = 1.0
    noise: float = 0.0
    dropouts: float = 0.0
    outliers: float = 0.0
    positions_only: bool = False

    def __post_init__(self) -> None:
        for name in ("duration", "dt", "rationality", "robot_rationality", "control_weight"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise SimulationError(f"{name} must be positive and finite; got {value!r}")
        for name, low in (("seed", 0), ("participants", 1)):
            if getattr(self, name) < low:
                raise SimulationError(f"{name} must be at least {low}; got {getattr(self, name)}")
        if self.samples < 2:
            raise SimulationError(
                f"a trial of {self.duration:g} s has {self.samples} samples {self.dt:g} s apart; at least 2 are needed"
            )
        if self.dynamics not in DYNAMICS_NAMES:
            raise SimulationError(
                f"dynamics must be one of {', '.join(DYNAMICS_NAMES)}; got {self.dynamics!r}"
            )
        for name in ("human", "robot"):
            if getattr(self, name) not in GOAL_CHOICES:
                raise SimulationError(
                    f"{name} must be one of {', '.join(GOAL_CHOICES)}; got {getattr(self, name)!r}"
                )
        require_range("stay", self.stay, 0.0, 1.0)
        require_range("rationality_spread", self.rationality_spread, 0.0, 5.0)
        # both refuse what cannot be played or tracked
        self.world()
        _ = self.tracker

    @property
    def samples(self) -> int:
        """Samples of a trial."""
        return round(self.duration / self.dt)

    @property
    def tracker(self) -> Tracker:
        """What sees the agents."""
        return Tracker(self.noise, self.dropouts, self.outliers)

    @property
    def logs_motion(self) -> bool:
        """Whether velocities and controls are logged: not where they would give the truth behind noisy positions."""
        return self.noise == 0 and not self.positions_only

    @property
    def control_quantity(self) -> str:
        """What a control is: ``"velocity"`` or ``"acceleration"``."""
        return CONTROL_QUANTITY[Dynamics.named(self.dynamics, self.dt).order or 2]

    @cached_property
    def participant_rationality(self) -> Float[np.ndarray, " participant"]:
        """The rationality of every participant: log-normal about the median `rationality`."""
        drawn = [participant_rng(self.seed, index).standard_normal() for index in range(self.participants)]
        return self.rationality * np.exp(self.rationality_spread * np.array(drawn))

    def world(self) -> ReachingWorld:
        """Return a world of one's own, to be reset."""
        rules = Rules(goals=self.goals, separation=self.separation)
        return ReachingWorld(rules, Dynamics.named(self.dynamics, self.dt))

    def seats(self, participant: int) -> dict[str, NoisilyRationalSeat]:
        """Return the human and the robot of one participant's trials."""
        human: GoalChoice = GOAL_CHOICES[self.human](yields=False)
        if self.stay < 1:
            human = ChangingMind(human, self.stay)
        rationality = float(self.participant_rationality[participant])
        return {
            HUMAN: NoisilyRationalSeat(self._agent(rationality), human),
            ROBOT: NoisilyRationalSeat(
                self._agent(self.robot_rationality), GOAL_CHOICES[self.robot](yields=True)
            ),
        }

    def header(self) -> RecordingHeader:
        """Return what a recording of this study says once; the true parameters are in its configuration."""
        logged = (self.logs_motion,) * 2
        return RecordingHeader(
            agents=AGENTS,
            goals=tuple(str(goal) for goal in range(self.goals)),
            has_velocity=logged if self._has_velocity else None,
            has_control=logged if self.logs_motion else None,
            control_quantity=self.control_quantity,
            title="Simulated reaching: two noisily rational agents among goals",
            source="ppsim record reaching",
            configuration=self.configuration(),
        )

    def configuration(self) -> dict[str, Any]:
        """Return the parameters, with what was drawn for each participant, as JSON can hold them."""
        drawn = {
            self.participant_name(index): {"rationality": value}
            for index, value in enumerate(self.participant_rationality.tolist())
        }
        return {
            "world": "reaching",
            **asdict(self),
            "state_weight": 1.0,
            "rules": asdict(self.world().rules),
            "participant_parameters": drawn,
        }

    def participant_name(self, index: int) -> str:
        """Return the name of a participant, numbered from 1."""
        return f"p{index + 1:0{len(str(self.participants))}d}"

    def trial(self, index: int) -> Trial:
        """Play trial `index` and return what is logged of it."""
        participant, repetition = index % self.participants, index // self.participants
        seed = trial_seed(self.seed, index)
        seats = self.seats(participant)
        played = play(self.world(), seats, seed=seed, samples=self.samples)
        # the last of the streams that a trial's seed makes; those before it are the agents'
        tracker_rng = streams(seed, len(AGENTS) + 1)[-1]
        rules = self.world().rules
        position, observed = self.tracker.track(played.position, rules.extent, tracker_rng)
        unseen = ~observed[..., None]
        name = self.participant_name(participant)
        return Trial(
            trial_id=f"{name}-{repetition}",
            participant=name,
            time=played.time,
            position=position,
            observed=observed.astype(np.int8),
            velocity=np.where(unseen, np.nan, played.velocity) if self._has_velocity else None,
            control=np.where(unseen, np.nan, played.control) if self.logs_motion else None,
            goal_position=played.goals,
            condition=f"robot: {self.robot}",
            round=repetition,
            seed=seed,
            outcome="time over",
            controller={agent: seat.controller for agent, seat in seats.items()},
            instruction={HUMAN: "natural", ROBOT: ""},
            segments=[
                segment
                for which, agent in enumerate(AGENTS)
                for segment in segments_of(played, which, agent, rules.pick_radius)
            ],
            variables=_variables(played, [seat.agent.rationality for seat in seats.values()]),
        )

    @property
    def _has_velocity(self) -> bool:
        # where the control is the velocity there is no other
        return self.logs_motion and self.control_quantity == "acceleration"

    def _agent(self, rationality: float) -> NoisilyRational:
        return _agent(self.dynamics, self.dt, self.control_weight, rationality)


@lru_cache(maxsize=1024)
def _agent(dynamics: str, dt: float, control_weight: float, rationality: float) -> NoisilyRational:
    # its Riccati equation is solved once, and not in each of a participant's trials
    return NoisilyRational.lqr(
        Dynamics.named(dynamics, dt), control_weight=control_weight, rationality=rationality
    )


def _variables(played: Played, rationality: list[float]) -> dict[str, tuple[Any, ...]]:
    return {
        "scored": (("sample",), played.scored.astype(np.int8), {"long_name": "the team scored here"}),
        "collision": (("sample",), played.collided.astype(np.int8), {"long_name": "agents collided here"}),
        "team_score": ((), np.int64(played.score), {"long_name": "points of the team at the end"}),
        "true_rationality": (
            ("agent",),
            np.array(rationality),
            {"long_name": "inverse temperature of the simulated agent"},
        ),
    }
