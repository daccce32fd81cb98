"""Equilibria of a game of many players, as labels of one sparse profile axis."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from ppinfer.distributions import Axis, Distribution, Factor
from ppinfer.errors import GameError
from ppinfer.games.pairwise.game import PairwiseGame


@dataclass(frozen=True, eq=False)
class PairwiseEquilibria:
    """The equilibria found: one sparse ``profile`` axis, on which the same algebra runs as on a grid of plans.

    Made by `pairwise_equilibria`.

    Parameters
    ----------
    game : PairwiseGame
    profiles : (profile, player) int
        Positions of the players' plans, in the order of the grid.
    costs : (profile, player) float64
        What each profile costs each player, s unless stated otherwise.
    collision_free : bool
        Whether equilibria of infinite cost were left out.

    Examples
    --------
    >>> from ppinfer.games import pairwise_equilibria
    >>> meet = [[True, False], [False, False]]
    >>> game = PairwiseGame([[2.0, 3.0], [2.0, 4.0]], {("robot", "human"): meet}, ["robot", "human"])
    >>> found = pairwise_equilibria(game)
    >>> len(found), found.profiles.tolist(), found.axis
    (2, [[0, 1], [1, 0]], Axis('profile', [1, 2]))

    The norm (3) of the paper, and what it says of the human's plan:

    >>> norm = found.factor(-50 * found.costs.min(axis=1)).normalize("profile")
    >>> (norm * found.plan_of("human")).marginal("human_plan").values
    array([0.5, 0.5])
    """

    game: PairwiseGame
    profiles: Int[np.ndarray, "profile player"]
    costs: Float[np.ndarray, "profile player"]
    collision_free: bool = True

    @classmethod
    def _of(
        cls, game: PairwiseGame, profiles: Int[np.ndarray, "profile player"], collision_free: bool
    ) -> PairwiseEquilibria:
        costs = game.profile_costs(profiles)
        for array in (profiles, costs):
            array.setflags(write=False)
        return cls(game, profiles, costs, collision_free)

    def __len__(self) -> int:
        return len(self.profiles)

    @cached_property
    def axis(self) -> Axis:
        """The sparse axis ``profile``; a label is the profile's position in the grid of all profiles, in C order.

        Raises
        ------
        GameError
            If there is no equilibrium, because an axis has at least one label.
        """
        if not len(self):
            raise GameError(
                f"{self.game!r} has no "
                + ("collision-free equilibrium" if self.collision_free else "pure equilibrium")
                + ", so there is no profile to label; look at len() first"
            )
        # Python's integers, because a large game has more profiles than 64 bits count
        flat = np.zeros(len(self), object)
        for player, size in enumerate(self.game.shape):
            flat = flat * size + self.profiles[:, player]
        return Axis("profile", [int(label) for label in flat])

    def factor(self, log_values: Any = 0.0) -> Factor:
        """Return a factor over the profiles found; by default the indicator of them.

        Parameters
        ----------
        log_values : (profile,) float, or a float
            Natural logarithms.

        Examples
        --------
        >>> from ppinfer.games import pairwise_equilibria
        >>> pairwise_equilibria(PairwiseGame([[2.0, 2.0], [1.0]], {}, ["robot", "human"])).factor().values
        array([1., 1.])
        """
        values = np.array(np.broadcast_to(np.asarray(log_values, np.float64), (len(self.axis),)))
        return Factor([self.axis], values)

    def plan_of(self, player: str) -> Distribution:
        """Return which plan a player has in each profile: a distribution over its plans, given ``profile``.

        Times a distribution over profiles it is their joint; its marginal is the distribution of the player's plan.

        Examples
        --------
        >>> from ppinfer.games import pairwise_equilibria
        >>> found = pairwise_equilibria(PairwiseGame([[2.0, 2.0], [1.0]], {}, ["robot", "human"]))
        >>> found.plan_of("robot").values
        array([[1., 0.],
               [0., 1.]])
        """
        position = self.game.player(player)
        plans = self.game.plans[position]
        has = self.profiles[:, position, None] == np.arange(len(plans))
        return Factor.from_mask([self.axis, plans], has).normalize(plans.name)

    def undominated(self, *, dominance: str = "weak") -> Factor:
        """Return the indicator of the profiles found that no other profile found dominates.

        Parameters
        ----------
        dominance : "weak" or "strict"
            "weak" drops a profile when another costs nobody more and somebody less; "strict" only when another costs
            everybody less.

        Examples
        --------
        >>> from ppinfer.games import pairwise_equilibria
        >>> meet = [[True, False], [False, False]]
        >>> game = PairwiseGame([[2.0, 3.0], [2.0, 4.0]], {(0, 1): meet}, ["robot", "human"])
        >>> pairwise_equilibria(game).undominated().values
        array([1., 1.])
        """
        if dominance not in ("weak", "strict"):
            raise GameError(f"dominance is 'weak' or 'strict', not {dominance!r}")
        axis = self.axis
        # sorted lexicographically, whoever dominates comes first; and who is dominated is dominated by one that is not
        costs, which = np.unique(self.costs, axis=0, return_inverse=True)
        keep, left = np.zeros(len(costs), bool), np.arange(len(costs))
        while len(left):
            first, left = left[0], left[1:]
            keep[first] = True
            best, others = costs[first], costs[left]
            beaten = (best <= others).all(axis=1) if dominance == "weak" else (best < others).all(axis=1)
            left = left[~beaten]
        return Factor.from_mask([axis], keep[which.reshape(-1)])

    def __repr__(self) -> str:
        kind = "collision-free equilibria" if self.collision_free else "equilibria"
        return f"{len(self)} {kind} of {self.game!r}"

    def _repr_html_(self) -> str:
        from html import escape

        most = 50
        head = "".join(f"<th>{escape(name)}</th>" for name in ("profile", *self.game.players))
        rows = []
        for row in range(min(most, len(self))):
            cells = "".join(
                f"<td>{escape(str(axis.labels[plan]))} ({cost:.4g})</td>"
                for axis, plan, cost in zip(self.game.plans, self.profiles[row], self.costs[row], strict=True)
            )
            rows.append(f"<tr><td>{self.axis.labels[row]}</td>{cells}</tr>")
        more = f"<p>... {len(self) - most} more ...</p>" if len(self) > most else ""
        title = escape(repr(self))
        return f"<p>{title}: plan (cost)</p><table><tr>{head}</tr>{''.join(rows)}</table>{more}"
