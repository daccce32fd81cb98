"""Who goes for which goal? A game whose plans are goals, its equilibria, and whom they favour."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.coordination.classes import FavourBy, favoured_classes
from ppinfer.coordination.equilibria import coordination_equilibria
from ppinfer.distributions import Axis, Distribution
from ppinfer.distributions.layout import Kinds
from ppinfer.distributions.logspace import log_of
from ppinfer.errors import ModelError
from ppinfer.games import Game


@dataclass(frozen=True)
class GoalChoiceGame:
    """Two agents each choose a goal; it costs the time to get there, and inf where both choose the same.

    The machinery of the first paper, with goals for plans: the equilibria that agents may coordinate on, the classes of
    those by whom they favour, and p(goals | theta), even over a class. Where the agents are nearest to different goals
    there is one equilibrium; where both are nearest to the same, one for each who may have it.

    It says for either personality which goal a human will choose, so it can be the `reaction` of a
    `ppinfer.goals.yielding.Yielding`, which then is about both papers' hypotheses at once.

    Parameters
    ----------
    speed : float
        m/s, of both agents: what makes a distance a time.
    favour_by : {"cost", "loss"}
        As in `favoured_classes`; by loss every game with a choice tells something of theta.
    agents : tuple of 2 str
        The robot's name and the human's: the labels of theta.

    Raises
    ------
    ModelError
        If the speed is not positive.

    Examples
    --------
    Both are nearest to goal 0. If the human favours the robot, it is the human who makes the detour:

    >>> goals = np.array([[0.0, 0.0], [0.0, 5.0], [9.0, 9.0]])
    >>> choice = GoalChoiceGame().goals_given_theta(goals, np.array([2.0, 0.0]), np.array([-3.0, 0.0]))
    >>> choice.marginal("human_goal").values
    array([[0., 1., 0.],
           [1., 0., 0.]])
    """

    speed: float = 1.0
    favour_by: FavourBy = "loss"
    agents: tuple[str, str] = ("robot", "human")

    def __post_init__(self) -> None:
        object.__setattr__(self, "agents", tuple(self.agents))
        if not 0.0 < self.speed < math.inf:
            raise ModelError(f"speed must be positive and finite (m/s); got {self.speed!r}")

    def game(
        self,
        goals: Float[np.ndarray, "*batch goal space"],
        human_position: Float[np.ndarray, "*batch space"],
        robot_position: Float[np.ndarray, "*batch space"],
        present: Bool[np.ndarray, "*batch goal"] | None = None,
        labels: Any = None,
    ) -> Game:
        """Return the game; leading axes are flattened into one batch axis, ``sample``.

        Parameters
        ----------
        goals : (..., goal, space) float64
            Where the goals are (m).
        human_position, robot_position : (..., space) float64
            Where the agents are (m).
        present : (..., goal) bool, optional
            Goals that exist; default all. One that does not costs inf.
        labels : sequence or int, optional
            Of the goals; default their numbers.

        Examples
        --------
        >>> game = GoalChoiceGame(speed=2.0).game(np.array([[0.0, 0.0], [0.0, 4.0]]), np.zeros(2), np.ones(2))
        >>> game.costs[1]
        array([[inf,  2.],
               [ 0., inf]])
        """
        batch, count = goals.shape[:-2], goals.shape[-2]
        times = np.stack(
            [
                np.linalg.norm(goals - position[..., None, :], axis=-1)
                for position in (robot_position, human_position)
            ],
            axis=-2,
        )
        times = times / self.speed
        if present is not None:
            times = np.where(present[..., None, :], times, np.inf)
        costs = np.empty((*batch, 2, count, count))
        costs[..., 0, :, :] = times[..., 0, :, None]
        costs[..., 1, :, :] = times[..., 1, None, :]
        costs[..., np.arange(count), np.arange(count)] = np.inf
        names = count if labels is None else labels
        axes = [Axis(f"{agent}_goal", names) for agent in self.agents]
        if not batch:
            return Game(costs, self.agents, axes)
        rows = math.prod(batch)
        return Game(costs.reshape(rows, 2, count, count), self.agents, axes, batch=[Axis("sample", rows)])

    def goals_given_theta(
        self,
        goals: Float[np.ndarray, "*batch goal space"],
        human_position: Float[np.ndarray, "*batch space"],
        robot_position: Float[np.ndarray, "*batch space"],
        present: Bool[np.ndarray, "*batch goal"] | None = None,
        labels: Any = None,
    ) -> Distribution:
        """Return p(robot_goal, human_goal | theta), even over the equilibria that favour theta.

        A class without equilibria has those of the other: such a game tells nothing of theta.

        Raises
        ------
        ModelError
            If no goals can be had without a collision: fewer than two are present.
        """
        game = self.game(goals, human_position, robot_position, present, labels)
        log_values = log_of(self._probabilities(game))
        if (log_values == -np.inf).all(axis=(-3, -2, -1)).any():
            raise ModelError("two agents need two goals: there are too few for any equilibrium")
        axes = (*game.batch, Axis("theta", self.agents), *game.plans)
        kinds: Kinds = ("given", "random", "random")
        if game.batch:
            kinds = ("batch", *kinds)
        return Distribution._sound(axes, log_values, kinds)

    def log_reaction(
        self,
        goals: Float[np.ndarray, "*batch goal space"],
        human_position: Float[np.ndarray, "*batch space"],
        robot_position: Float[np.ndarray, "*batch space"],
        present: Bool[np.ndarray, "*batch goal"] | None = None,
    ) -> Float[np.ndarray, "*batch 2 goal goal goal"]:
        """Return log p(human's goal | theta, prior goal, robot's goal) for `Yielding`: the same for all of the latter.

        It is the human's part of an equilibrium that favours theta. With fewer than two goals it keeps its own.

        Examples
        --------
        >>> goals = np.array([[0.0, 0.0], [0.0, 5.0], [9.0, 9.0]])
        >>> reaction = GoalChoiceGame().log_reaction(goals, np.array([2.0, 0.0]), np.array([-3.0, 0.0]))
        >>> reaction.shape, np.exp(reaction[:, 0, 0])
        ((2, 3, 3, 3), array([[0., 1., 0.],
               [1., 0., 0.]]))
        """
        game = self.game(goals, human_position, robot_position, present)
        count = goals.shape[-2]
        chosen = self._probabilities(game).sum(axis=-2).reshape(*goals.shape[:-2], 2, 1, 1, count)
        lone = ~(chosen > 0.0).any(axis=(-4, -1), keepdims=True)
        kept = np.where(lone, np.eye(count)[:, None, :], chosen)
        return log_of(np.broadcast_to(kept, (*goals.shape[:-2], 2, count, count, count)))

    def _probabilities(self, game: Game) -> Float[np.ndarray, "*batch 2 goal goal"]:
        """Return p(goals | theta); zero throughout where there is no equilibrium."""
        among = coordination_equilibria(game).log_values > -np.inf
        costs = np.moveaxis(game.costs, -3, 0)
        classes = np.moveaxis(favoured_classes(costs, among, favour_by=self.favour_by), 0, -3)
        empty = ~classes.any(axis=(-2, -1), keepdims=True)
        members = np.where(empty, among[..., None, :, :], classes)
        probabilities: np.ndarray = members / np.maximum(members.sum(axis=(-2, -1), keepdims=True), 1)
        return probabilities
