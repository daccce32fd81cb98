"""The belief over goal and personality at control rate: two observations in, one joint distribution out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Axis, Distribution, Factor
from ppinfer.errors import LogError
from ppinfer.goals.model import Observation
from ppinfer.goals.online import OnlineGoalBelief
from ppinfer.goals.priors import log_priors
from ppinfer.goals.yielding.model import Yielding


class OnlineYielding:
    """p(goal, theta) of one human, updated as both agents move; equal at every step to `Yielding.infer`.

    Parameters
    ----------
    model : Yielding
        What is assumed of both agents.
    dt : float
        Nominal seconds between observations.
    labels : sequence of str
        Names of the goals.
    prior : (theta,) array or Distribution, optional
        p(theta) before anything was seen: even by default, or what is known from elsewhere.

    Examples
    --------
    Both head for the cup, and the human does not give it up:

    >>> from ppinfer.goals import Observation
    >>> belief = OnlineYielding(Yielding(), dt=0.1, labels=["cup", "bowl"])
    >>> _ = belief.restart(np.array([[4.0, 0.0], [0.0, 4.0]]))
    >>> for t in np.arange(20) * 0.1:
    ...     human = Observation(t, np.array([t, 0.2]), np.array([1.0, 0.0]), np.array([0.1, 0.0]))
    ...     robot = Observation(t, np.array([t, -3.0 + 0.8 * t]), np.array([1.0, 0.8]), np.array([0.1, 0.1]))
    ...     joint = belief.observe(human, robot)
    >>> joint.mode()["goal"], joint.marginal("theta").prob(theta="human") > 0.5
    ('cup', True)
    """

    def __init__(self, model: Yielding, *, dt: float, labels: Sequence[str], prior: Any = None) -> None:
        self.model = model
        self._goal = Axis("goal", labels)
        self._likelihood = model.motion.online(dt)
        self._mental_model = OnlineGoalBelief(model.robot_motion, dt=dt, labels=labels)
        self._theta = model.theta_prior(prior)
        self._belief: Distribution | None = None

    @property
    def belief(self) -> Distribution:
        """p(goal, theta) given all that was seen.

        Raises
        ------
        LogError
            Where no row was begun.
        """
        if self._belief is None:
            raise LogError("no goals yet: call restart(goals) before the first observation")
        return self._belief

    def restart(
        self,
        goals: Float[np.ndarray, "goal space"],
        *,
        present: Bool[np.ndarray, " goal"] | None = None,
        goal_prior: Any = None,
    ) -> Distribution:
        """Begin a row: new goals, from their prior; what is known of theta is kept.

        Parameters
        ----------
        goals : (goal, space) float64
            Positions of the goals (m).
        present : (goal,) bool, optional
            Goals that exist; default all.
        goal_prior : (goal,) array of float, optional
            Probabilities to start from; default even over those present.
        """
        self._mental = self._mental_model.restart(goals, present=present).rename(goal="robot_goal")
        there = np.ones(len(goals), bool) if present is None else np.asarray(present, bool)
        theta = self._theta if self._belief is None else self._belief.marginal("theta")
        log_goal = log_priors(there[None], goal_prior, name_row=lambda _: "the new row")[0]
        known = Distribution._sound((self._goal,), log_goal, ("random",)) * theta
        assert isinstance(known, Distribution)
        self._belief, self._fresh = known, True
        self._goals, self._present = np.asarray(goals, np.float64), there
        self._human, self._robot = np.zeros(goals.shape[1]), np.zeros(goals.shape[1])
        self._likelihood.restart(self._goals, there)
        return known

    def observe(self, human: Observation, robot: Observation) -> Distribution:
        """Return the belief after both were seen once more, at the same time; a position of None is a dropout.

        Raises
        ------
        LogError
            Where no row was begun, or what was seen makes no sense.
        ImpossibleEvidenceError
            Where nothing is possible any more.
        """
        belief = self.belief
        self._human = self._human if human.position is None else human.position
        self._robot = self._robot if robot.position is None else robot.position
        if not self._fresh:
            belief = belief.predict(
                self.model.transition(self._goals, self._human, self._robot, self._mental, self._present)
            )
        seen = Factor((self._goal,), self._likelihood.step(human))
        self._belief, self._fresh = belief.update(seen), False
        self._mental = self._mental_model.observe(
            robot.time,
            robot.position,
            velocity=robot.velocity,
            control=robot.control,
            control_order=robot.control_order,
        ).rename(goal="robot_goal")
        return self._belief

    def update(self, likelihood: Factor) -> Distribution:
        """Return the belief after evidence from elsewhere: a factor over ``goal``, ``theta`` or both."""
        self._belief = self.belief.update(likelihood)
        return self._belief
