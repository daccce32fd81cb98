"""Who moves a point agent: a noisily rational LQR agent with a policy for its goals."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from ppinfer.goals import NoisilyRational
from ppsim.reaching.goal_choice import GoalChoice
from ppsim.reaching.world import Observation


class NoisilyRationalSeat:
    """Draws actions from u | x, theta ~ N(-K (x - theta), (2 beta S)^-1), eq. (22), towards a goal of its choice.

    Parameters
    ----------
    agent : NoisilyRational
        Its dynamics, cost weights and rationality; the dynamics are those of the world.
    choice : GoalChoice
        Which goal it goes for.

    Attributes
    ----------
    goal : int
        The goal that the latest action was for.

    Examples
    --------
    >>> from ppinfer.goals import Dynamics
    >>> from ppsim.reaching import NearestGoal, ReachingWorld, Rules
    >>> dynamics = Dynamics.double_integrator(0.1)
    >>> seat = NoisilyRationalSeat(NoisilyRational.lqr(dynamics, rationality=10.0), NearestGoal())
    >>> seat.reset(np.random.default_rng(0))
    >>> seen = ReachingWorld(Rules(), dynamics).reset(1)["human"]
    >>> seat.act(seen).shape, seat.goal
    ((2,), 0)
    """

    def __init__(self, agent: NoisilyRational, choice: GoalChoice) -> None:
        self.agent = agent
        self.choice = choice
        self._spread = np.linalg.cholesky(agent.control_covariance)

    @property
    def controller(self) -> str:
        """What the log calls it."""
        return f"lqr {self.choice.name}"

    def reset(self, rng: np.random.Generator) -> None:
        """Begin a trial without a goal."""
        self._rng = rng
        self._drawn = -1
        self.goal = -1

    def act(self, observation: Observation) -> Float[np.ndarray, " m"]:
        """Choose a goal, and an action towards it."""
        current = self.goal if observation.drawn == self._drawn else None
        self._drawn = observation.drawn
        self.goal = self.choice.choose(observation, current, self._rng)
        target = self.agent.dynamics.goal_states(observation.goals[self.goal])
        noise = self._spread @ self._rng.standard_normal(self.agent.dynamics.controls)
        action: np.ndarray = self.agent.mean_control(observation.state, target) + noise
        return action
