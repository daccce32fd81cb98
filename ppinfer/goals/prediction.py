"""What the robot knows at every control step: the belief half of Algorithm 1."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Distribution
from ppinfer.errors import LogError, ModelError
from ppinfer.goals.choice.chooser import GoalSituation
from ppinfer.goals.dynamics import Dynamics
from ppinfer.goals.lqr import GoalLQR
from ppinfer.goals.mental_model import MentalModel, paper_agent
from ppinfer.goals.model import GoalModel, Observation
from ppinfer.goals.online import OnlineGoalBelief
from ppinfer.goals.rationality import GoalAndRationality
from ppinfer.goals.rationality_online import OnlineGoalAndRationality


class BehaviourPredictor:
    """Keeps b_R(theta_prior) and b_H(theta_R) as both agents move, and hands a chooser all that is known.

    At every step it (1) updates the belief over the human's goal with the human's motion, (2) updates the mental model,
    what the human takes the robot's goal to be, with the robot's, and (3) returns the `GoalSituation`, in which a
    `GoalChooser` predicts the human's reaction to each goal of the robot and decides.

    Parameters
    ----------
    human_model : GoalModel or GoalAndRationality, optional
        How the human acts; default `paper_agent`. With a `GoalAndRationality` situations carry the joint belief, and
        the belief over goals is its marginal.
    robot_model : GoalModel, optional
        How the human takes the robot to act; default `paper_agent`.
    dt : float
        Nominal seconds between steps.
    labels : sequence of str
        Names of the goals.
    rationalities : sequence of float, optional
        What the human's rationality may be, each as probable at first: short for a `GoalAndRationality` of a `GoalLQR`.
    dynamics : Dynamics, optional
        What the states in a situation are made of, for both agents; default double integrators in the plane.
    history : int
        How many steps of both agents' states, the present one included, situations carry; 0 for none.

    Raises
    ------
    ModelError
        Where history is negative, or rationalities are given for a model that has none.

    Examples
    --------
    >>> from ppinfer.goals.choice import ExpectedCost
    >>> predictor = BehaviourPredictor(dt=0.1, labels=["cup", "bowl"])
    >>> predictor.restart(np.array([[3.0, 0.0], [-5.0, 0.0]]))
    >>> robot, chooser, goal = np.array([2.0, -4.0]), ExpectedCost(), None
    >>> for step in range(10):  # the human makes for the cup
    ...     human, velocity = np.array([0.1 * step, 0.0]), np.array([1.0, 0.0])
    ...     situation = predictor.observe(0.1 * step, human, velocity, robot, np.zeros(2), goal)
    ...     goal = chooser.choose(situation).goal
    >>> situation.belief.mode(), situation.labels[goal]
    ({'goal': 'cup'}, 'cup')
    """

    def __init__(
        self,
        human_model: GoalModel | GoalAndRationality | None = None,
        robot_model: GoalModel | None = None,
        *,
        dt: float,
        labels: Sequence[str],
        rationalities: Sequence[float] | None = None,
        dynamics: Dynamics | None = None,
        history: int = 0,
    ) -> None:
        if history < 0:
            raise ModelError(f"history must be a number of steps, 0 or more; got {history!r}")
        model = paper_agent() if human_model is None else human_model
        if rationalities is not None:
            if not isinstance(model, GoalLQR):
                raise ModelError(f"rationalities can be told apart under a GoalLQR only; got {model!r}")
            model = GoalAndRationality(model, tuple(rationalities))
        self._human: OnlineGoalBelief | OnlineGoalAndRationality
        self._looks_at_robot = False
        if isinstance(model, GoalAndRationality):
            self._human = OnlineGoalAndRationality(model, dt=dt, labels=labels)
        else:
            self._human = OnlineGoalBelief(model, dt=dt, labels=labels)
            self._looks_at_robot = model.needs_partner
        self._mind = MentalModel(robot_model, dt=dt, labels=labels)
        self._states = tuple(
            _AgentState(Dynamics.double_integrator(dt) if dynamics is None else dynamics, history)
            for _ in range(2)
        )
        self._goals: Float[np.ndarray, "goal space"] | None = None
        self._present: Bool[np.ndarray, " goal"] | None = None

    def restart(
        self,
        goals: Float[np.ndarray, "goal space"],
        *,
        present: Bool[np.ndarray, " goal"] | None = None,
        prior: Any = None,
        carry: bool = False,
        keep_history: bool = False,
    ) -> None:
        """Begin with these goals.

        Parameters
        ----------
        goals : (goal, space) float64
            Positions of the goals (m), one for each label.
        present : (goal,) bool, optional
            Goals that exist; default all.
        prior : (goal,) array of float, optional
            Probabilities of the human's goals to start from; default even over the goals present.
        carry : bool
            Keep what was believed of each goal, or with a `GoalAndRationality` what was believed of the human's
            rationality (their goals are as in the prior then).
        keep_history : bool
            Whether the agents go on from where they were: goals are new, but not the trial.

        Raises
        ------
        LogError
            Where the goals do not match the labels or are not finite.
        """
        if isinstance(self._human, OnlineGoalAndRationality):
            self._human.restart(goals, present=present, prior=prior, carry_rationality=carry)
        else:
            self._human.restart(goals, present=present, prior=prior, carry=carry)
        self._mind.restart(goals, present=present, carry=carry)
        self._goals = np.array(goals, dtype=np.float64)
        self._goals.setflags(write=False)
        self._present = None
        if present is not None and not np.all(present):
            self._present = np.array(present, dtype=bool)
        if not keep_history:
            for state in self._states:
                state.forget()

    def observe(
        self,
        time: float,
        human_position: Float[np.ndarray, " space"] | None,
        human_velocity: Float[np.ndarray, " space"] | None,
        robot_position: Float[np.ndarray, " space"],
        robot_velocity: Float[np.ndarray, " space"] | None,
        previous: int | None,
        human_control: Float[np.ndarray, " m"] | None = None,
        robot_control: Float[np.ndarray, " m"] | None = None,
    ) -> GoalSituation:
        """Return the situation after one more step of both agents.

        Parameters
        ----------
        time : float
            Seconds, later than the last step.
        human_position, robot_position : (space,) float64
            Where they are (m). The human's is None where the tracker lost them: the belief waits, and the situation
            holds their last state.
        human_velocity, robot_velocity : (space,) float64 or None
            Their velocities (m/s); None where unknown: differences of positions are taken.
        previous : int or None
            The robot's goal until now.
        human_control, robot_control : (m,) float64, optional
            What they do from now on, where it is known; else it is read off the change of the velocity, one step later.

        Raises
        ------
        LogError
            Where no goals are known, time does not increase, a value is not finite, or the human was never seen.
        ImpossibleEvidenceError
            Where every goal is ruled out.
        """
        if self._goals is None:
            raise LogError("no goals yet: call restart(goals) before the first step")
        joint: Distribution | None = None
        if isinstance(self._human, OnlineGoalAndRationality):
            joint = self._human.observe(time, human_position, velocity=human_velocity, control=human_control)
            belief = joint.marginal("goal")
        elif self._looks_at_robot:
            partner = Observation(time, robot_position, robot_velocity, robot_control)
            belief = self._human.observe(
                time, human_position, velocity=human_velocity, control=human_control, partners=(partner,)
            )
        else:
            belief = self._human.observe(time, human_position, velocity=human_velocity, control=human_control)
        mind = self._mind.observe(time, robot_position, velocity=robot_velocity, control=robot_control)
        human, robot = self._states
        human.step(time, human_position, human_velocity)
        robot.step(time, robot_position, robot_velocity)
        return GoalSituation(
            goals=self._goals,
            human=human.state,
            robot=robot.state,
            human_position=human.position,
            robot_position=robot.position,
            belief=belief,
            mental_model=mind,
            rationality_belief=joint,
            previous=previous,
            present=self._present,
            human_history=human.past(),
            robot_history=robot.past(),
        )


class _AgentState:
    """The state of one agent, from positions and velocities, and the last few of them."""

    def __init__(self, dynamics: Dynamics, history: int) -> None:
        self._size = dynamics.states
        self._position_index = list(dynamics.position_index)
        self._velocity_index = list(dynamics.velocity_index)
        self._recent: deque[Float[np.ndarray, " n"]] | None = deque(maxlen=history) if history else None
        self.forget()

    def forget(self) -> None:
        """Begin anew."""
        self.state = np.zeros(self._size)
        self.position: Float[np.ndarray, " space"] = np.zeros(0)
        self._last_time: float | None = None
        if self._recent is not None:
            self._recent.clear()

    def step(
        self,
        time: float,
        position: Float[np.ndarray, " space"] | None,
        velocity: Float[np.ndarray, " space"] | None,
    ) -> None:
        """Take in where the agent is; None repeats the last state."""
        if position is not None:
            state = np.zeros(self._size)
            state[self._position_index] = position
            if self._velocity_index:
                if velocity is not None:
                    state[self._velocity_index] = velocity
                elif self._last_time == time:
                    # goals were drawn anew at this instant, which is looked at once more
                    state[self._velocity_index] = self.state[self._velocity_index]
                elif self._last_time is not None:
                    state[self._velocity_index] = (position - self.position) / (time - self._last_time)
            self.state, self.position, self._last_time = state, position, time
        elif self._last_time is None:
            raise LogError("the human was not seen yet; wait for the first position before the first step")
        if self._recent is not None:
            self._recent.append(self.state)

    def past(self) -> Float[np.ndarray, "step n"] | None:
        """Return the last states, the present one last; None where none are kept."""
        return None if self._recent is None else np.array(self._recent)
