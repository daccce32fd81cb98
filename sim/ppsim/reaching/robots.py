"""Robots of the reaching game: each watches both agents, chooses a goal with a chooser of ppinfer, and moves by LQR."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ppinfer.errors import PPInferError
from ppinfer.goals.choice import (
    CHOOSERS,
    Courtesy,
    ExpectedCost,
    GoalChooser,
    GoalDecision,
    GoalSituation,
    Influence,
    JointChoice,
    NearestGoal,
    ReactToGoal,
    Switching,
    TrajectoryDecision,
    point_agent,
)
from ppinfer.goals.choice.joint import VELOCITY_VARIANCE
from ppinfer.goals.conditional import GoalConditional, SoftmaxConditional, overall_post
from ppinfer.goals.prediction import BehaviourPredictor
from ppinfer.goals.rationality import SWITCHING_RATIONALITIES
from ppinfer.goals.reacted import ReactedConditional
from ppsim.errors import SimulationError
from ppsim.naming import checked_names, made_by_name
from ppsim.reaching.keeping_clear import KeepClear
from ppsim.reaching.movement import Movement
from ppsim.reaching.world import Observation

#: All robots by name.
ROBOTS = tuple(CHOOSERS)
#: Those that choose a goal, and move towards it by LQR; "joint" chooses a trajectory with it, and takes its time.
GOAL_ROBOTS = tuple(name for name in CHOOSERS if name != JointChoice.name)

#: Which robots keep clear of the human.
KEEP_CLEAR = ("proactive", "all", "none")

#: What robots take the human's reaction for.
REACTIONS: dict[str, type[GoalConditional]] = {
    conditional.name: conditional for conditional in (ReactedConditional, SoftmaxConditional)
}

#: Steps of both agents' states that a chooser of one's own is shown.
HISTORY = 20


@dataclass(frozen=True, eq=False)
class Thought:
    """What a robot thought at one sample.

    Parameters
    ----------
    belief : (goal,) float64
        log b_R(theta_prior): the human's goal.
    mental_model : (goal,) float64
        log b_H(theta_R): what the human takes the robot's goal to be, as the robot thinks.
    post : (goal,) float64
        log b_post(theta_post | theta_R) for the goal that the robot chose; where it waits, averaged over its mental
        model.
    """

    belief: Float[np.ndarray, " goal"]
    mental_model: Float[np.ndarray, " goal"]
    post: Float[np.ndarray, " goal"]


class RobotSeat:
    """Sits a goal chooser in the game.

    1. Both beliefs, over the human's goal and over what the human takes the robot's to be, are updated with what the
       agents did; they start anew whenever goals do.
    2. The chooser chooses a goal, or to wait.
    3. The robot moves by the best control towards it; where it waits, it brakes. One that keeps clear swerves on the
       way where it has to. Of a decision for a trajectory the first control is carried out as it is.

    Parameters
    ----------
    chooser : GoalChooser
        Who chooses.
    movement : Movement, optional
        How it moves, and how rational it takes the human to be.
    name : str, optional
        What the log calls it; default: the chooser's name.
    keep_clear : KeepClear, optional
        How it keeps clear of the human; default: not at all.

    Attributes
    ----------
    goal : int
        The goal that the latest action was for; -1 where it waits.
    decision : GoalDecision or None
        The latest.
    thoughts : list of Thought
        One for each sample of the game.

    Examples
    --------
    >>> from ppinfer.goals.choice import ExpectedCost
    >>> from ppsim.reaching import ReachingWorld, Rules
    >>> seat = RobotSeat(ExpectedCost())
    >>> seat.reset(np.random.default_rng(0))
    >>> seen = ReachingWorld(Rules(), seat.movement.dynamics).reset(1)["robot"]
    >>> seat.act(seen).shape, seat.goal, len(seat.thoughts)
    ((2,), 1, 1)
    """

    def __init__(
        self,
        chooser: GoalChooser,
        movement: Movement | None = None,
        *,
        name: str | None = None,
        keep_clear: KeepClear | None = None,
    ) -> None:
        self.chooser = chooser
        self.movement = movement or Movement()
        self.name = name or chooser.name
        self.keep_clear = keep_clear

    @property
    def controller(self) -> str:
        """What the log calls it."""
        return self.name

    @property
    def shows_history(self) -> bool:
        """Whether situations hold both agents' last states: for choosers of one's own, which may look back."""
        return self.name not in ROBOTS

    def reset(self, rng: np.random.Generator) -> None:
        """Begin a game without a goal."""
        # a chooser that draws takes its chance from the trial's
        self._chooser = self.chooser.with_generator(rng)
        self._drawn = -1
        self._predictor: BehaviourPredictor | None = None
        self.goal = -1
        self.decision: GoalDecision | None = None
        self.thoughts: list[Thought] = []

    def act(self, observation: Observation) -> Float[np.ndarray, " 2"]:
        """Watch both agents, choose a goal, and move towards it."""
        if self._predictor is None:
            self._predictor = BehaviourPredictor(
                self.movement.model,
                self.movement.model,
                dt=self.movement.dt,
                labels=[str(goal) for goal in range(len(observation.goals))],
                rationalities=SWITCHING_RATIONALITIES if self.chooser.needs_rationality else None,
                history=HISTORY if self.shows_history else 0,
            )
        previous = self.goal if self.goal >= 0 else None
        if observation.drawn != self._drawn:
            self._predictor.restart(observation.goals, keep_history=True)
            self._drawn, previous = observation.drawn, None
        own = observation.agent
        (other,) = (agent for agent in observation.position if agent != own)
        situation = self._predictor.observe(
            observation.time,
            observation.position[other],
            observation.velocity[other],
            observation.position[own],
            observation.velocity[own],
            previous,
        )
        self.decision = decision = self._choose(situation)
        self.goal = -1 if decision.goal is None else decision.goal
        thought = self._thought(situation, decision)
        self.thoughts.append(thought)
        if isinstance(decision, TrajectoryDecision):
            return decision.control
        target = observation.position[own] if decision.goal is None else observation.goals[decision.goal]
        if self.keep_clear is not None:
            target = self.keep_clear.target(
                observation.position[own],
                observation.velocity[own],
                target,
                observation.position[other],
                observation.velocity[other],
                observation.goals,
                # whatever it would do without a reaction, or with one
                np.exp(np.maximum(thought.belief, thought.post)),
            )
        return self.movement.control(observation.state, target)

    def _choose(self, situation: GoalSituation) -> GoalDecision:
        """Return what the chooser decides; one that fails is named, since it may be anybody's."""
        try:
            decision: object = self._chooser.choose(situation)
        except PPInferError as error:
            raise SimulationError(f"robot {self.name!r}: {error}") from error
        except Exception as error:
            raise SimulationError(f"robot {self.name!r}: raised {type(error).__name__}: {error}") from error
        if not isinstance(decision, GoalDecision):
            raise SimulationError(
                f"robot {self.name!r}: returned a {type(decision).__name__}; expected a GoalDecision"
            )
        if decision.goal is not None and not 0 <= decision.goal < len(situation.goals):
            raise SimulationError(
                f"robot {self.name!r}: decided on goal {decision.goal!r}; there are {len(situation.goals)}"
            )
        # the least of them is no choice then, whatever was taken for it
        unknown = np.isnan(decision.score)
        if unknown.any():
            raise SimulationError(
                f"robot {self.name!r}: its score of goal {int(np.argmax(unknown))} is no number; expected one for each "
                "goal, inf where it is ruled out"
            )
        return decision

    @staticmethod
    def _thought(situation: GoalSituation, decision: GoalDecision) -> Thought:
        if decision.goal is None:
            post = overall_post(decision.post, situation.mental_model).log_values
        else:
            post = decision.post.log_values[decision.goal]
        return Thought(situation.belief.log_values, situation.mental_model.log_values, post)


def make_robot(
    name: str,
    movement: Movement | None = None,
    *,
    reactive_threshold: float = 0.8,
    reaction: str = "reacted",
    keep_clear: str = "proactive",
) -> RobotSeat:
    """Return the seat of a robot.

    Parameters
    ----------
    name : str
        One of `ROBOTS`, or ``module:attribute``: a GoalChooser, or something that makes one when it is called.
    movement : Movement, optional
        How it moves.
    reactive_threshold : float
        How sure the reactive robot wants to be.
    reaction : {"reacted", "softmax"}
        How "influence" (also within "switching") and "expected-cost" think that the human reacts to their goal: as in
        `SoftmaxConditional`, or that only as long as the human does not know it (`ReactedConditional`). "courtesy"
        takes the former anyway, "joint" the latter.
    keep_clear : {"proactive", "all", "none"}
        Who keeps clear of the human: those that predict a reaction (all but the naive and the reactive robot), all, or
        none.

    Raises
    ------
    SimulationError
        Where there is no such robot, or it is no GoalChooser.
    ModelError
        Where the threshold is no probability.

    Examples
    --------
    >>> make_robot("influence").keep_clear is None, make_robot("naive").keep_clear is None
    (False, True)
    >>> make_robot("reactive", reactive_threshold=0.5).chooser
    ReactToGoal(threshold=0.5)
    """
    checked_names("robots", [name], ROBOTS, own=True)
    if keep_clear not in KEEP_CLEAR:
        raise SimulationError(f"keep_clear must be one of {', '.join(KEEP_CLEAR)}; got {keep_clear!r}")
    if reaction not in REACTIONS:
        raise SimulationError(f"reaction must be one of {', '.join(REACTIONS)}; got {reaction!r}")
    movement = movement or Movement()
    chooser = _chooser(name, movement, reactive_threshold, REACTIONS[reaction]())
    predicts = not isinstance(chooser, NearestGoal | ReactToGoal)
    keeps = keep_clear == "all" or (keep_clear == "proactive" and predicts)
    return RobotSeat(chooser, movement, name=name, keep_clear=KeepClear(movement) if keeps else None)


def _chooser(
    name: str, movement: Movement, reactive_threshold: float, reaction: GoalConditional
) -> GoalChooser:
    # where the human does not react any more, nothing keeps courtesy from the human's own goal: it has no penalty
    influence, courtesy = Influence(conditional=reaction), Courtesy()
    known: tuple[GoalChooser, ...] = (
        NearestGoal(),
        ReactToGoal(threshold=reactive_threshold),
        influence,
        courtesy,
        Switching(unsure=influence, resolute=courtesy),
        ExpectedCost(conditional=reaction),
    )
    for chooser in known:
        if chooser.name == name:
            return chooser
    if name == JointChoice.name:
        weights = {"state_weight": movement.state_weight, "control_weight": movement.control_weight}
        return JointChoice(
            robot=point_agent(movement.dt, **weights),
            human=point_agent(movement.dt, **weights, velocity_variance=VELOCITY_VARIANCE),
            dt=movement.dt,
        )
    if name in CHOOSERS:
        return CHOOSERS[name]()
    return made_by_name(name, GoalChooser, what="robot")  # type: ignore[type-abstract]
