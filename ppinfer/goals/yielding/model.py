"""One belief over the human's goal and its personality: who yields leaves a goal that the robot wants."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Axis, Distribution, forward_filter
from ppinfer.distributions.logspace import log_of
from ppinfer.errors import ModelError
from ppinfer.goals.belief import infer_goals
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.lqr import GoalLQR
from ppinfer.goals.mental_model import paper_agent
from ppinfer.goals.model import GoalModel, require_range
from ppinfer.goals.priors import log_priors
from ppinfer.goals.switching import row_transitions
from ppinfer.goals.yielding.evidence import EncounterEvidence
from ppinfer.goals.yielding.reaction import GoalReaction, SoftmaxReaction


def _game_motion() -> GoalLQR:
    # the agent of the reaching game, Q = 10 I and R = I; its controls may stray by 10 m/s^2
    return paper_agent(0.005, stay=0.995)


@dataclass(frozen=True)
class Yielding:
    """p(goal, theta | motion): where the human is heading, and whom it favours where both want the same goal.

    theta is a personality as in the first paper, labelled by agents: who favours the robot yields, who favours itself
    does not. goal is the human's goal of the second paper. They are two axes of one state:

    1. Before each sample but the first of a row the human thinks again with probability `reconsiders`. Then its goal
       moves by the reaction of its personality to the robot's goal, averaged over what it takes that goal to be,

           p(goal' | goal, theta) = (1 - rho) stay(goal' | goal) + rho sum_R b_H(R) p(goal' | goal, R, theta),

       with b_H the mental model: the same inference turned round, from the robot's motion until the sample before.
    2. The sample's motion is evidence about the goal alone: the likelihood of `motion`.
    3. A row with new goals begins from their prior; theta is carried over, until there is another human.

    All it takes of the algebra is `Distribution.predict` and `update`, so anything else that is known of theta or of
    goals is one more factor: the posterior of `ppinfer.coordination.Personality` as a prior over theta, say.

    Parameters
    ----------
    motion : GoalModel
        The likelihood of the human's motion; its ``stay`` is the probability per sample that the goal of one who does
        not think of the robot stays what it is.
    robot_motion : GoalModel
        How the human reads the robot's motion.
    reaction : GoalReaction
        What a human does about the robot's goal, for either theta.
    reconsiders : float
        rho, in [0, 1], per sample; at 10 samples a second .05 is once in two seconds on average.
    agents : tuple of 2 str
        The robot's name and the human's: the labels of theta.

    Raises
    ------
    ModelError
        If rho is no probability, names are the same, or a model judges each sample by itself.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> from ppinfer.goals.yielding import Encounter, simulate_encounters
    >>> model = Yielding()
    >>> encounter = Encounter.random(rng, encounters=2, rows=2, samples=30)
    >>> evidence, pursued = simulate_encounters(model, encounter, rng)
    >>> model.infer(evidence)
    Distribution p(goal, theta; sample): sample 120, goal 3, theta 2
    """

    name: ClassVar[str] = "yielding"

    motion: GoalModel = field(default_factory=_game_motion)
    robot_motion: GoalModel = field(default_factory=_game_motion)
    reaction: GoalReaction = field(default_factory=SoftmaxReaction)
    reconsiders: float = 0.05
    agents: tuple[str, str] = ("robot", "human")

    def __post_init__(self) -> None:
        require_range("reconsiders", self.reconsiders, 0.0, 1.0)
        object.__setattr__(self, "agents", tuple(self.agents))
        if len(set(self.agents)) != 2:
            raise ModelError(f"agents must be two names, the robot's and the human's; got {self.agents}")
        for model in (self.motion, self.robot_motion):
            if model.memoryless:
                raise ModelError(
                    f"{model.name!r} judges each sample by itself, so its evidence cannot be gathered; use a "
                    "likelihood of motion such as GoalLQR"
                )

    @property
    def theta(self) -> Axis:
        """Whom the human favours where both want the same goal."""
        return Axis("theta", self.agents)

    def transition(
        self,
        goals: Float[np.ndarray, "goal space"],
        human_position: Float[np.ndarray, " space"],
        robot_position: Float[np.ndarray, " space"],
        mental_model: Distribution,
        present: Bool[np.ndarray, " goal"] | None = None,
    ) -> Distribution:
        """Return p(next_goal | goal, theta) for one instant.

        Parameters
        ----------
        goals : (goal, space) float64
            Where the goals are (m).
        human_position, robot_position : (space,) float64
            Where the agents are at the sample that is moved to (m).
        mental_model : Distribution
            b_H over ``robot_goal``, from the samples before.
        present : (goal,) bool, optional
            Goals that exist; default all.

        Examples
        --------
        >>> goal = Axis("goal", ["cup", "bowl"])
        >>> sure = Distribution.from_probabilities([goal.rename("robot_goal")], [1.0, 0.0])
        >>> goals = np.array([[1.0, 0.0], [0.0, 2.0]])
        >>> moved = Yielding().transition(goals, np.zeros(2), np.ones(2), sure)
        >>> moved.restrict(goal="cup").values.round(3)
        array([[0.957, 0.995],
               [0.043, 0.005]])
        """
        goal = mental_model.axes[0].rename("goal")
        log_values = self.log_transitions(
            goals, human_position, robot_position, np.exp(mental_model.log_values), present
        )
        axes = (self.theta, goal, goal.rename("next_goal"))
        laid = Distribution._sound(axes, log_values, ("given", "given", "random"))
        return laid.align("next_goal", "goal", "theta")

    def infer(
        self, evidence: EncounterEvidence, *, prior: Any = None, goal_prior: Any = None
    ) -> Distribution:
        """Return the belief at each sample given the samples so far, all in one array program.

        Parameters
        ----------
        evidence : EncounterEvidence
            The motion of both.
        prior : (theta,) array or Distribution, optional
            p(theta) of each human, the robot first; default even.
        goal_prior : (goal,) or (row, goal) array of float, optional
            Probabilities of the goals at the start of each row; default even over those present.

        Returns
        -------
        Distribution
            Random in ``goal`` and ``theta``, batch ``sample``; its marginals are the belief over either.

        Raises
        ------
        ImpossibleEvidenceError
            Where nothing is possible; the message names row and sample.
        ModelError
            Where a prior is no distribution.
        """
        human, robot = evidence.human, evidence.robot
        row, start = human.row_of_sample, human.row_start
        log_theta = self.theta_prior(prior).log_values
        log_goal = log_priors(human.goal_present, goal_prior, name_row=human.row_name)
        mental = np.exp(infer_goals(self.robot_motion, robot).log_posterior)
        # known before a sample is what was seen until the one before; the first of a row needs no transition
        before = np.maximum(np.arange(human.samples) - 1, 0)
        moves = self.log_transitions(
            human.goals[row], _last_seen(human), _last_seen(robot), mental[before], human.goal_present[row]
        )
        moves[start] = log_goal[:, None, None, :]
        goals = moves.shape[-1]
        # a state is (goal, theta); theta stays what it is
        whole = np.full((human.samples, goals, 2, goals, 2), -np.inf)
        for theta in range(2):
            whole[:, :, theta, :, theta] = moves[:, theta]
        states = 2 * goals
        likelihood = np.repeat(self.motion.log_likelihood(human).log_values, 2, axis=1)
        continues = np.ones(human.samples, dtype=bool)
        continues[start[evidence.first]] = False
        log_posterior = forward_filter(
            likelihood,
            np.ones(human.samples, dtype=np.int64),
            (log_goal[row][:, :, None] + log_theta).reshape(-1, states),
            whole.reshape(-1, states, states),
            np.arange(human.samples),
            continues,
            describe=human.describe_sample,
        )
        axes = (human.sample_axis, human.goal_axis, self.theta)
        shape = tuple(len(axis) for axis in axes)
        return Distribution._sound(axes, log_posterior.reshape(shape), ("batch", "random", "random"))

    def theta_prior(self, prior: Any = None) -> Distribution:
        """Return p(theta) as a distribution with this model's labels; even by default.

        Raises
        ------
        AxisError, FactorError
            Where the prior has other labels, or does not sum to one.

        Examples
        --------
        >>> Yielding().theta_prior([0.2, 0.8]).prob(theta="human")
        0.8
        """
        if prior is None:
            return Distribution.uniform(self.theta)
        if isinstance(prior, Distribution):
            return prior.align(self.theta)
        return Distribution.from_probabilities([self.theta], prior)

    def log_transitions(
        self,
        goals: Float[np.ndarray, "*batch goal space"],
        human_position: Float[np.ndarray, "*batch space"],
        robot_position: Float[np.ndarray, "*batch space"],
        mental_model: Float[np.ndarray, "*batch goal"],
        present: Bool[np.ndarray, "*batch goal"] | None = None,
    ) -> Float[np.ndarray, "*batch 2 goal goal"]:
        """Return log p(goal' | theta, goal), with axes in that order, for many instants at once.

        Parameters
        ----------
        goals, human_position, robot_position, present
            As `transition` takes them, with any leading axes.
        mental_model : (..., goal) float64
            Probabilities b_H.

        Examples
        --------
        >>> goals = np.array([[1.0, 0.0], [0.0, 2.0]])
        >>> moved = Yielding().log_transitions(goals, np.zeros(2), np.ones(2), np.array([1.0, 0.0]))
        >>> np.exp(moved[0]).round(3)
        array([[0.957, 0.043],
               [0.006, 0.994]])
        """
        batch, count = goals.shape[:-2], goals.shape[-2]
        there = np.ones((*batch, count), bool) if present is None else present
        flat = there.reshape(-1, count)
        log_even = log_priors(flat, None)
        log_stay, which = row_transitions(log_even, flat, self.motion.stay, memoryless=False)
        stay = np.exp(log_stay)[which].reshape(*batch, 1, count, count)
        reaction = np.exp(
            self.reaction.log_reaction(goals, human_position, robot_position, None if there.all() else there)
        )
        moved = np.einsum("...tjri,...r->...tji", reaction, mental_model)
        moved = self.reconsiders * moved + (1.0 - self.reconsiders) * stay
        return log_of(moved / moved.sum(axis=-1, keepdims=True))


def _last_seen(evidence: GoalEvidence) -> Float[np.ndarray, "sample space"]:
    """Return where an agent was seen last in each row; the origin before it was."""
    if evidence.seen.all():
        return evidence.position
    start = evidence.row_start[evidence.row_of_sample]
    index = np.maximum.accumulate(np.where(evidence.seen, np.arange(evidence.samples), start))
    return np.where(evidence.seen[index][:, None], evidence.position[index], 0.0)
