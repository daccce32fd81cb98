"""Mixed equilibria of games of two players, each with its certificate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.distributions import Axis, Distribution
from ppinfer.errors import GameError
from ppinfer.games.game import Game
from ppinfer.games.mixtures import expected_costs, finite_costs, product_of, whole_plans

SAME = 1e-7
"""Equilibria none of whose probabilities differ by more than this are one."""

TIED = 1e-10
"""Replies whose gains, between 1 and 2, differ by less than this are equally good."""


@dataclass(frozen=True, eq=False)
class MixedEquilibria:
    """The mixed equilibria of a game of two players, pure ones included. Made by `mixed_equilibria`.

    Parameters
    ----------
    profile : Distribution
        p(plans; equilibrium): random in both plan axes, with a batch axis ``equilibrium``.
    strategies : tuple of Distribution
        For each player, p(plan; equilibrium).
    costs : (equilibrium, player) float64
        What each player expects to pay, in the unit of the game's costs.
    regret : (equilibrium, player) float64
        The certificate: how much a player could gain by deviating alone, in the unit of the game's costs.
    tolerance : float
        The largest regret accepted, as a fraction of the largest regret that any profile of the game gives the player.
    rejected : int
        How many further candidates there were whose regret is larger: they are not among these.
    degenerate : bool
        Whether some strategy has more best replies than plans that it plays with positive probability. Then
        equilibria may come in continua, and those here are their extreme points: where two of these agree in one
        player's strategy, mixtures of the other's are equilibria as well.
    """

    profile: Distribution
    strategies: tuple[Distribution, ...]
    costs: Float[np.ndarray, "equilibrium player"]
    regret: Float[np.ndarray, "equilibrium player"]
    tolerance: float
    rejected: int
    degenerate: bool

    def __len__(self) -> int:
        return len(self.regret)

    @property
    def axis(self) -> Axis:
        """The axis ``equilibrium``."""
        return self.profile.axis("equilibrium")

    def __repr__(self) -> str:
        notes = [f"largest regret {self.regret.max():.1e}"]
        notes += [f"{self.rejected} candidates rejected"] * bool(self.rejected)
        notes += ["degenerate: there may be others between these"] * self.degenerate
        return f"{len(self)} mixed equilibria ({', '.join(notes)}): {self.profile!r}"


def mixed_equilibria(
    game: Game, *, infinite_as: float | None = None, tolerance: float = 1e-9
) -> MixedEquilibria:
    """Find the mixed equilibria of a game of two players by enumerating the vertices of its best-reply polytopes.

    1. Costs become gains between 1 and 2, which leaves best replies what they are and the polytopes bounded.
    2. nashpy builds the polytopes {y >= 0: A y <= 1} and {x >= 0: B^T x <= 1} and their vertices; a vertex is
       labelled with the plans that it does not play and those that are best replies to it.
    3. A pair of vertices is a candidate when every plan of both players is a label. nashpy finds labels within 1e-5,
       so it may propose a pair that is none, but overlooks none.
    4. A candidate is an equilibrium when its regret, taken from the costs themselves, is within the tolerance.

    In a game that is not degenerate these are all equilibria, pure and mixed, an odd number of them. In a degenerate
    one they are the extreme points of the set of equilibria; see `MixedEquilibria`.

    Parameters
    ----------
    game : Game
        Of two players, without batch axes.
    infinite_as : float, optional
        What an infinite cost counts as, in the unit of the costs: at least the largest finite one. Needed if there is
        any, because every mixed strategy would run the risk.
    tolerance : float
        The largest regret of an equilibrium, as a fraction of the largest regret of any profile for that player.

    Raises
    ------
    GameError
        If there are not two players, there are batch axes, a cost is infinite and has no stand-in, or no candidate
        is within the tolerance.

    See Also
    --------
    logit_response : noisy players, any number of them.

    Examples
    --------
    Two arms each prefer to go first; meeting costs both 5 s.

    >>> game = Game([[[5.0, 1.0], [2.0, 2.0]], [[5.0, 2.0], [1.0, 2.0]]], ["robot", "human"])
    >>> found = mixed_equilibria(game)
    >>> found.strategies[0].values.round(6)
    array([[1.  , 0.  ],
           [0.25, 0.75],
           [0.  , 1.  ]])
    >>> float(found.regret.max()) < 1e-12
    True
    >>> found.profile
    Distribution p(robot_plan, human_plan; equilibrium): equilibrium 3, robot_plan 2, human_plan 2
    """
    if len(game.players) != 2:
        raise GameError(
            f"mixed equilibria are found for two players; this game has {len(game.players)} "
            f"({', '.join(game.players)}). logit_response at a high rationality takes any number"
        )
    if game.batch:
        names = ", ".join(axis.name for axis in game.batch)
        raise GameError(
            f"games of a batch have different numbers of mixed equilibria; take one of them: restrict({names}=...)"
        )
    if not 0.0 <= tolerance < 1.0:
        raise GameError(
            f"tolerance is a fraction of the regrets in the game, 0 <= tolerance < 1; got {tolerance}"
        )
    plans = whole_plans(game)
    costs = finite_costs(game, infinite_as)[np.ix_(np.arange(len(game.players)), *plans)]
    # regret of each profile: subtracting what depends on the others' plan only changes no best reply
    regrets = [own - own.min(axis=player, keepdims=True) for player, own in enumerate(costs)]
    spread = np.array([own.max() or 1.0 for own in regrets])
    gains = [2.0 - own / most for own, most in zip(regrets, spread, strict=True)]

    mine, my_labels, my_excess = _vertices(gains[1].T)
    yours, your_labels, your_excess = _vertices(gains[0])
    # the labels of the first polytope are plans of (second, first) player: put them in the players' order
    my_labels = np.roll(my_labels, costs.shape[1], axis=1)
    first, second = np.nonzero(~(~my_labels[:, None] & ~your_labels[None]).any(axis=2))

    x, y = mine[first], yours[second]
    paid, regret = _certify(costs, x, y)
    sound = (regret <= tolerance * spread).all(axis=1)
    if not sound.any():
        best = (regret / spread).max(axis=1).min(initial=np.inf)
        raise GameError(
            f"none of {len(x)} candidates for a mixed equilibrium of {game!r} is within {tolerance:.1e}; "
            f"the best is at {best:.1e}. Costs of very different size spoil the digits: raise tolerance, or scale them"
        )
    kept = _distinct(x, y, np.where(sound, regret.max(axis=1), np.inf))
    axis = Axis("equilibrium", len(kept))
    strategies = []
    for own, axis_of_plans, some in zip((x, y), game.plans, plans, strict=True):
        probabilities = np.zeros((len(kept), len(axis_of_plans)))
        probabilities[:, some] = own[kept]
        strategies.append(
            Distribution.from_probabilities([axis, axis_of_plans], probabilities, batch=["equilibrium"])
        )
    return MixedEquilibria(
        product_of(strategies),
        tuple(strategies),
        paid[kept],
        regret[kept],
        tolerance,
        int(np.count_nonzero(~sound)),
        my_excess or your_excess,
    )


def _vertices(
    gains: Float[np.ndarray, "reply plan"],
) -> tuple[Float[np.ndarray, "vertex plan"], Bool[np.ndarray, "vertex label"], bool]:
    """Return the vertices of {x >= 0: gains x <= 1} but the origin, as probabilities, and their labels.

    A label is a reply that is best, or (after these) a plan that is not played. Last, whether a vertex has more best
    replies than plans played, which makes the game degenerate.
    """
    from nashpy.polytope import build_halfspaces, non_trivial_vertices

    replies, plans = gains.shape
    if plans == 1:  # an interval, which Qhull does not take
        best = gains[:, 0] == gains.max()
        return np.ones((1, 1)), np.append(best, False)[None], bool(best.sum() > 1)
    # nashpy's own vertex_enumeration builds the second polytope anew for every vertex of the first
    found = list(non_trivial_vertices(build_halfspaces(gains)))
    labels = np.zeros((len(found), replies + plans), bool)
    for row, (_, own) in zip(labels, found, strict=True):
        row[list(own)] = True
    points = np.array([vertex for vertex, _ in found])
    # exact zeros where a plan is not played
    points = np.where(labels[:, replies:], 0.0, points)
    # labels are loose, and would call near ties degenerate
    tied = (np.abs(points @ gains.T - 1.0) < TIED).sum(axis=1)
    excess = bool((tied > (points > 0.0).sum(axis=1)).any())
    return points / points.sum(axis=1, keepdims=True), labels, excess


def _certify(
    costs: Float[np.ndarray, "player plan other_plan"],
    x: Float[np.ndarray, "candidate plan"],
    y: Float[np.ndarray, "candidate other_plan"],
) -> tuple[Float[np.ndarray, "candidate player"], Float[np.ndarray, "candidate player"]]:
    """Return what candidates cost both players, and the regret of each."""
    paid, regret = np.empty((len(x), 2)), np.empty((len(x), 2))
    for row, both in enumerate(zip(x, y, strict=True)):
        for player, expected in enumerate(expected_costs(costs, both)):
            paid[row, player] = expected @ both[player]
            # the mean of what each plan played loses, so that nothing cancels
            regret[row, player] = (expected - expected.min()) @ both[player]
    return paid, regret


def _distinct(
    x: Float[np.ndarray, "candidate plan"],
    y: Float[np.ndarray, "candidate other_plan"],
    score: Float[np.ndarray, " candidate"],
) -> list[int]:
    """Return the candidates of finite score, of those that are the same the one of least score, in a fixed order."""
    both = np.hstack([x, y])
    kept: list[int] = []
    for candidate in np.argsort(score, kind="stable"):
        if not np.isfinite(score[candidate]):
            break
        if not kept or np.abs(both[kept] - both[candidate]).max(axis=1).min() > SAME:
            kept.append(int(candidate))
    # those that play the first plans come first; rounded, so that the last digit decides nothing
    return sorted(kept, key=lambda candidate: tuple((-both[candidate]).round(6)))
