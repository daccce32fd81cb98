"""What the human takes the robot's goal to be: the same inference, turned round (22)-(27)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Axis, Distribution
from ppinfer.goals.belief import Mode, infer_goals
from ppinfer.goals.lqr import GoalLQR
from ppinfer.goals.online import OnlineGoalBelief

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ppinfer.goals.evidence import GoalEvidence
    from ppinfer.goals.model import GoalModel

HUMAN_RATIONALITY = 3e-4
"""beta_H, 1/cost: how rational the human takes the robot to be."""


def paper_agent(rationality: float = HUMAN_RATIONALITY, *, stay: float = 1.0) -> GoalLQR:
    """Return the paper's agent: a double integrator with Q = 10 I and R = I.

    Parameters
    ----------
    rationality : float
        beta, 1/cost; by default beta_H, how rational the human takes the robot to be.
    stay : float
        Probability per sample that the goal stays what it is.

    Raises
    ------
    ModelError
        Where a parameter is out of its range.

    Examples
    --------
    >>> paper_agent().rationality
    0.0003
    """
    return GoalLQR(
        "double-integrator", control_weight=1.0, state_weight=10.0, rationality=rationality, stay=stay
    )


class MentalModel:
    """b_H(theta_R), the robot's model of the human's belief about the robot's goal, updated as the robot moves.

    The human is taken to see what the robot does and to infer its goal as the robot infers theirs: an
    `OnlineGoalBelief` about the robot, over ``robot_goal``.

    Parameters
    ----------
    model : GoalModel, optional
        How the human takes the robot to act; default `paper_agent`.
    dt : float
        Nominal seconds between observations.
    labels : sequence of str
        Names of the goals.

    Examples
    --------
    >>> mind = MentalModel(dt=0.1, labels=["cup", "bowl"])
    >>> _ = mind.restart(np.array([[5.0, 0.0], [0.0, 5.0]]))
    >>> for step in range(6):
    ...     seen = mind.observe(0.1 * step, np.array([0.05 * step**2, 0.0]), velocity=np.array([1.0 * step, 0.0]))
    >>> seen.random, seen.mode()["robot_goal"]
    (('robot_goal',), 'cup')
    """

    def __init__(self, model: GoalModel | None = None, *, dt: float, labels: Sequence[str]) -> None:
        self._belief = OnlineGoalBelief(paper_agent() if model is None else model, dt=dt, labels=labels)
        self._axes = (Axis("robot_goal", labels),)

    def restart(
        self,
        goals: Float[np.ndarray, "goal space"],
        *,
        present: Bool[np.ndarray, " goal"] | None = None,
        prior: Any = None,
        carry: bool = False,
    ) -> Distribution:
        """Begin with these goals, as `OnlineGoalBelief.restart`.

        Raises
        ------
        LogError
            Where the goals do not match the labels or are not finite.
        """
        return self._seen(self._belief.restart(goals, present=present, prior=prior, carry=carry))

    def observe(
        self,
        time: float,
        position: Float[np.ndarray, " space"] | None,
        *,
        velocity: Float[np.ndarray, " space"] | None = None,
        control: Float[np.ndarray, " control"] | None = None,
        control_order: int | None = 2,
    ) -> Distribution:
        """Return b_H after one more step of the robot, as `OnlineGoalBelief.observe`.

        Raises
        ------
        LogError
            Where no goals are known, time does not increase, or a value is not finite.
        ImpossibleEvidenceError
            Where every goal is ruled out.
        """
        return self._seen(
            self._belief.observe(
                time, position, velocity=velocity, control=control, control_order=control_order
            )
        )

    def _seen(self, belief: Distribution) -> Distribution:
        return Distribution._sound(self._axes, belief.log_values, ("random",))


def infer_mental_model(
    evidence: GoalEvidence, model: GoalModel | None = None, *, mode: Mode = "filter", prior: Any = None
) -> Distribution:
    """Return b_H(robot_goal) at every sample of a log.

    Parameters
    ----------
    evidence : GoalEvidence
        The robot's motion.
    model : GoalModel, optional
        How the human takes the robot to act; default `paper_agent`.
    mode, prior
        As `infer_goals` takes them.

    Returns
    -------
    Distribution
        Random in ``robot_goal``, one for each ``sample``.

    Raises
    ------
    ImpossibleEvidenceError, ModelError
        As `infer_goals`.

    Examples
    --------
    >>> from ppinfer.goals import GoalDesign
    >>> rng = np.random.default_rng(0)
    >>> robot = paper_agent(0.01).simulate(GoalDesign.random(rng, rows=2, samples=10), rng)
    >>> infer_mental_model(robot)
    Distribution p(robot_goal; sample): sample 20, robot_goal 3
    """
    belief = infer_goals(paper_agent() if model is None else model, evidence, mode=mode, prior=prior)
    return belief.distribution.rename(goal="robot_goal")
