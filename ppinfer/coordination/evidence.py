"""A history of play as one agent saw it: its replans in order, with the games of equal size together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from ppinfer.coordination.history import PlayHistory
from ppinfer.distributions import Axis, Factor
from ppinfer.errors import ModelError
from ppinfer.games import Game


@dataclass(frozen=True, eq=False)
class PlayEvidence:
    """The replans of one agent in a history, and the motion of everybody between them.

    Parameters
    ----------
    history : PlayHistory
        All trials.
    ego : str
        Whose view it is. Trials without a replan of this agent's are left out.

    Raises
    ------
    ModelError
        If there is no such agent, or it never replanned.
    """

    history: PlayHistory
    ego: str

    def __post_init__(self) -> None:
        if self.ego not in self.history.agents:
            raise ModelError(f"there is no agent {self.ego!r}; there are {', '.join(self.history.agents)}")
        if not len(self.replans):
            raise ModelError(
                f"no replan in this history is {self.ego!r}'s, so there is nothing that it inferred"
            )

    @property
    def player(self) -> int:
        """Which of the agents it is."""
        return self.history.agents.index(self.ego)

    @cached_property
    def replans(self) -> Int[np.ndarray, " replan"]:
        """The places of its replans in the history; everything below is in this order."""
        return np.flatnonzero(self.history.replan_agent == self.ego)

    @cached_property
    def replan_axis(self) -> Axis:
        """The axis of its replans, labelled by their places in the history."""
        places = self.replans
        step = int(places[1] - places[0]) if len(places) > 1 else 1
        evenly = range(int(places[0]), int(places[0]) + step * len(places), step)
        # a range is not walked label by label
        return Axis("replan", evenly if np.array_equal(places, evenly) else places)

    @cached_property
    def row_size(self) -> Int[np.ndarray, " trial"]:
        """Its replans in each trial in which it has any."""
        trial = self.history.trial_of_replan[self.replans]
        size = np.bincount(trial, minlength=len(self.history.row_size))
        return size[size > 0].astype(np.int64)

    @cached_property
    def first(self) -> Int[np.ndarray, " replan"]:
        """The first replan of the same trial, for each of its replans."""
        return np.repeat(np.cumsum(self.row_size) - self.row_size, self.row_size)

    @cached_property
    def sample(self) -> Int[np.ndarray, " replan"]:
        """The sample, counted over all trials, at which each replan was made."""
        history = self.history
        sample: np.ndarray = (
            history.row_start[history.trial_of_replan[self.replans]] + history.replan_sample[self.replans]
        )
        return sample

    def likelihood_factor(self, theta: Axis, log_values: Float[np.ndarray, "replan theta"]) -> Factor:
        """Return the log likelihoods of every replan under every theta as a Factor over (replan, theta)."""
        return Factor([self.replan_axis, theta], log_values)

    def by_size(
        self, rows: Int[np.ndarray, " chosen"]
    ) -> Iterator[tuple[Int[np.ndarray, " together"], tuple[int, ...]]]:
        """Yield the places, among some of its replans, of those whose games are equally large, and how large."""
        if not len(rows):
            return
        sizes, which = np.unique(self.history.plan_row_size[self.replans[rows]], axis=0, return_inverse=True)
        for group, size in enumerate(sizes):
            yield np.flatnonzero(which.ravel() == group), tuple(int(one) for one in size)

    def game(self, rows: Int[np.ndarray, " replan"], size: tuple[int, ...]) -> Game:
        """Return the games of some of its replans, all of one size, along a batch axis ``replan``."""
        history = self.history
        start = history.profile_start[self.replans[rows]]
        costs = history.cost[start[:, None] + np.arange(int(np.prod(size)))]
        agents = history.agents
        return Game(
            costs.transpose(0, 2, 1).reshape(len(rows), len(agents), *size),
            agents,
            [Axis(f"{agent}_plan", k) for agent, k in zip(agents, size, strict=True)],
            [Axis("replan", len(rows))],
        )
