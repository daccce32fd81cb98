"""Many games of the reaching study side by side, as one array program; the seats play the same game one by one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from ppsim.reaching.humans import HUMANS, StubbornHuman, WaitingHuman
from ppsim.reaching.movement import Movement

# what counts as the same belief, as in `humans`
_EVEN = 1e-9
KINDS = tuple(HUMANS)
_WAITING, _STUBBORN = KINDS.index(WaitingHuman.name), KINDS.index(StubbornHuman.name)


@dataclass(frozen=True, eq=False)
class ManyGames:
    """Where many games are: both agents' states, the goals, and what each human believes.

    Parameters
    ----------
    human, robot : (game, 4) float64
        States (m, m/s).
    goals : (game, goal, 2) float64
        Where the goals are (m); 0 where there is none.
    present : (game, goal) bool
        Which there are.
    log_belief : (game, goal) float64
        Each human's belief over the robot's goal, -inf for goals that are not there.
    kind : (game,) int
        Which simulated human it is, an index of `KINDS`.
    fresh : (game,) bool
        Whether the human has yet to look at the robot since goals were new: then the belief is even.
    robot_control : (game, 2) float64
        What the robot did last (m/s^2), from the state before.
    robot_before : (game, 4) float64
        That state.
    """

    human: Float[np.ndarray, "game 4"]
    robot: Float[np.ndarray, "game 4"]
    goals: Float[np.ndarray, "game goal 2"]
    present: Bool[np.ndarray, "game goal"]
    log_belief: Float[np.ndarray, "game goal"]
    kind: Int[np.ndarray, " game"]
    fresh: Bool[np.ndarray, " game"]
    robot_control: Float[np.ndarray, "game 2"]
    robot_before: Float[np.ndarray, "game 4"]

    @classmethod
    def start(
        cls,
        human: Float[np.ndarray, "game 4"],
        robot: Float[np.ndarray, "game 4"],
        goals: Float[np.ndarray, "game goal 2"],
        present: Bool[np.ndarray, "game goal"],
        kind: Int[np.ndarray, " game"],
    ) -> ManyGames:
        """Return games that begin.

        Examples
        --------
        >>> games = ManyGames.start(
        ...     np.zeros((1, 4)), np.ones((1, 4)), np.eye(2)[None], np.ones((1, 2), bool), np.array([2])
        ... )
        >>> np.exp(games.log_belief)
        array([[0.5, 0.5]])
        """
        count = len(human)
        return cls(
            human, robot, goals, present, even(present), kind,
            np.ones(count, dtype=bool), np.zeros((count, 2)), robot.copy(),
        )  # fmt: skip

    def take(self, which: Int[np.ndarray, " taken"]) -> ManyGames:
        """Return some of the games, any of them as often as it is named."""
        return ManyGames(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    def with_goals(self, which: int, goals: Float[np.ndarray, "goal 2"]) -> ManyGames:
        """Return the games with new goals in one of them, of which its human knows nothing yet."""
        new, belief, fresh = self.goals.copy(), self.log_belief.copy(), self.fresh.copy()
        new[which, self.present[which]] = goals
        belief[which] = even(self.present[which : which + 1])[0]
        fresh[which] = True
        return replace(self, goals=new, log_belief=belief, fresh=fresh)

    def distance(self, state: Float[np.ndarray, "game 4"]) -> Float[np.ndarray, "game goal"]:
        """Return the distances from an agent to the goals (m), inf to those that are not there."""
        away = self.goals - state[:, None, [0, 2]]
        return np.where(self.present, np.sqrt((away * away).sum(axis=-1)), np.inf)


@dataclass(frozen=True)
class GameRules:
    """How many games move on.

    Parameters
    ----------
    movement : Movement
        Of both agents, and how rational humans take the robot to be.
    noise : float
        Standard deviation of the disturbance of the human's velocity, per dimension and step (m/s).

    Examples
    --------
    >>> rules = GameRules(Movement())
    >>> games = ManyGames.start(
    ...     np.zeros((1, 4)), np.ones((1, 4)), 3 * np.eye(2)[None], np.ones((1, 2), bool), np.array([2])
    ... )
    >>> moved = rules.step(games, np.array([1]), np.zeros((1, 2)))
    >>> moved.human[0, 1] > 0
    np.True_
    """

    movement: Movement
    noise: float = 0.0

    def step(
        self,
        games: ManyGames,
        robot_goal: Int[np.ndarray, " game"],
        disturbance: Float[np.ndarray, "game 2"],
    ) -> ManyGames:
        """Return the games one time step later; robots go for `robot_goal`, -1 for one that brakes.

        1. Humans update their beliefs (27) with what their robot did last, and choose.
        2. Both agents move by the best control, the human's disturbed by standard normal draws.
        """
        dynamics, (K, goal_gain, _) = self.movement.dynamics, self._gains
        log_belief = self._believed(games)
        choice = choose(games, log_belief)
        dt = self.movement.dt

        def pulled(state: Float[np.ndarray, "game 4"], goal: Int[np.ndarray, " game"]) -> np.ndarray:
            place = games.goals[np.arange(len(goal)), np.maximum(goal, 0)]
            place = np.where((goal < 0)[:, None], state[:, [0, 2]], place)
            control: np.ndarray = dynamics.goal_states(place) @ goal_gain.T - state @ K.T
            return control

        human_control = pulled(games.human, choice) + (self.noise / dt) * disturbance
        robot_control = pulled(games.robot, robot_goal)
        return replace(
            games,
            human=dynamics.step(games.human, human_control),
            robot=dynamics.step(games.robot, robot_control),
            log_belief=log_belief,
            fresh=np.zeros_like(games.fresh),
            robot_control=robot_control,
            robot_before=games.robot,
        )

    def _believed(self, games: ManyGames) -> Float[np.ndarray, "game goal"]:
        K, goal_gain, S = self._gains
        goal = self.movement.dynamics.goal_states(games.goals)
        off = (games.robot_control + games.robot_before @ K.T)[:, None] - goal @ goal_gain.T
        evidence = -self.movement.rationality * np.einsum("bgm,mk,bgk->bg", off, S, off)
        log_belief = games.log_belief + np.where(games.fresh[:, None], 0.0, evidence)
        log_belief -= log_belief.max(axis=1, keepdims=True)
        normalised: np.ndarray = log_belief - np.log(np.exp(log_belief).sum(axis=1, keepdims=True))
        return normalised

    @cached_property
    def _gains(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        agent = self.movement.agent
        return agent.K, agent.goal_gain, agent.S


def choose(games: ManyGames, log_belief: Float[np.ndarray, "game goal"]) -> Int[np.ndarray, " game"]:
    """Return the goal that each human goes for, -1 where it stands: the rules of `humans`, for all at once.

    Examples
    --------
    >>> games = ManyGames.start(
    ...     np.zeros((3, 4)), np.ones((3, 4)), np.array([[[1.0, 0.0], [2.0, 0.0]]] * 3), np.ones((3, 2), bool),
    ...     np.array([KINDS.index(name) for name in ("waiting", "moving", "stubborn")]),
    ... )
    >>> choose(games, np.log(np.array([[0.7, 0.3]] * 3)))
    array([-1,  1,  0])
    """
    belief = np.exp(log_belief)
    distance = games.distance(games.human)
    index = np.arange(len(belief))
    own, predicted = distance.argmin(axis=1), belief.argmax(axis=1)
    others = distance.copy()
    others[index, predicted] = np.inf
    other = np.where(games.present.sum(axis=1) > 1, others.argmin(axis=1), predicted)
    most = belief[index, predicted]
    least = np.where(games.present, belief, np.inf).min(axis=1)
    free = belief[index, own] < most - _EVEN
    waiting = np.where(most >= WaitingHuman.threshold, other, np.where(free, own, -1))
    moving = np.where(most - least <= _EVEN, own, other)
    yielding = np.where(games.kind == _WAITING, waiting, moving)
    return np.where(games.kind == _STUBBORN, own, yielding)


def even(present: Bool[np.ndarray, "game goal"]) -> Float[np.ndarray, "game goal"]:
    """Return log probabilities that are even over the goals present.

    Examples
    --------
    >>> np.exp(even(np.array([[True, True, False]])))
    array([[0.5, 0.5, 0. ]])
    """
    with np.errstate(divide="ignore"):
        log_even: np.ndarray = np.log(present / present.sum(axis=1, keepdims=True))
    return log_even
