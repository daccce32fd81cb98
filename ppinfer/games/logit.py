"""Logit quantal response: what players do who choose better plans more often, but not always."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from ppinfer.distributions import Axis, Distribution
from ppinfer.errors import GameError
from ppinfer.games.continuation import LogitSystem, trace
from ppinfer.games.game import Game
from ppinfer.games.mixtures import expected_costs, finite_costs, product_of, whole_plans


@dataclass(frozen=True, eq=False)
class LogitBranch:
    """Logit equilibria of one game on its principal branch, with their certificates. Made by `logit_branch`.

    Parameters
    ----------
    profile : Distribution
        p(plans; rationality): the product of the strategies.
    strategies : tuple of Distribution
        For each player, p(plan; rationality).
    residual : (rationality,) float64
        The certificate: the largest difference, in log probability, of a strategy from the response to the others.
    regret : (rationality, player) float64
        What a player loses in expectation against its best reply, in the unit of the costs: 0 in a Nash equilibrium.
    turns : tuple of float
        Rationalities at which the branch turns round, in the order met on the way. Between a pair of them there are
        several equilibria on it; the one returned is the first that the branch comes to.
    crossings : tuple of float
        Rationalities at which another branch crosses this one, as happens in symmetric games.
    """

    profile: Distribution
    strategies: tuple[Distribution, ...]
    residual: Float[np.ndarray, " rationality"]
    regret: Float[np.ndarray, "rationality player"]
    turns: tuple[float, ...]
    crossings: tuple[float, ...]


def logit_response(
    game: Game, rationality: float | Sequence[float] | Any, *, infinite_as: float | None = None
) -> Distribution:
    """Return the logit quantal response equilibrium: how noisy players play who know how noisy the others are.

    Every player i plays plan a_i with probability proportional to exp(-rationality E[c_i(a_i, others)]), the others
    drawn from their own such strategies. Where there are several equilibria, this is the one on the principal branch,
    which starts at rationality 0, where everybody plays at random; see `logit_branch`.

    Parameters
    ----------
    game : Game
        Of any number of players; batch axes stay.
    rationality : float or sequence of float
        >= 0, one over the unit of the costs. Several make a batch axis ``rationality``.
    infinite_as : float, optional
        What an infinite cost counts as, in the unit of the costs: at least the largest finite one. Needed if there is
        any, because a noisy player runs every risk.

    Returns
    -------
    Distribution
        p(plans; batch, rationality), over the grid of plan axes. Players choose independently, so its marginals are
        their strategies.

    Raises
    ------
    GameError
        If a rationality is negative or infinite, a cost is infinite and has no stand-in, or the branch cannot be
        followed.

    Examples
    --------
    >>> game = Game([[[5.0, 1.0], [2.0, 2.0]], [[5.0, 3.0], [1.0, 3.0]]], ["robot", "human"])
    >>> response = logit_response(game, [0.0, 1.0, 100.0])
    >>> response
    Distribution p(robot_plan, human_plan; rationality): rationality 3, robot_plan 2, human_plan 2
    >>> response.marginal("robot_plan").values.round(3)
    array([[0.5  , 0.5  ],
           [0.086, 0.914],
           [0.   , 1.   ]])
    """
    axis, wanted = _rationalities(rationality)
    finite_costs(game, infinite_as)  # names the cell of the whole batch
    shape = tuple(map(len, game.batch))
    values = np.empty((*shape, len(wanted), *map(len, game.plans)))
    for cell in np.ndindex(shape):
        one = Game(
            game.costs[cell],
            game.players,
            game.plans,
            (),
            None if game.present is None else game.present[cell],
        )
        values[cell] = _solved(one, wanted, infinite_as).profile.log_values
    if axis is None:
        values = values.squeeze(len(shape))
    apart = game.batch if axis is None else (*game.batch, axis)
    return Distribution([*apart, *game.plans], values, batch=[some.name for some in apart])


def logit_branch(
    game: Game, rationalities: Sequence[float] | Any, *, infinite_as: float | None = None
) -> LogitBranch:
    """Follow the principal branch of the logit equilibria of one game, and certify what is found on it.

    1. At rationality 0 everybody plays at random; that is the only equilibrium there.
    2. From it the branch is followed along its arc, by a predictor on the tangent and Newton's method across it, in log
       probabilities (Turocy 2005); so plans of probability exp(-1e6) keep their digits, and turns are no obstacle.
    3. Steps are shortened while the branch bends, and while they change the orientation of the equations: this tells
       a branch that bends away sharply from one that another branch crosses. At a crossing ours goes straight on,
       which keeps the symmetry of a symmetric game.
    4. Where the branch first passes a rationality asked for, it is solved for there.

    The branch may turn and pass a rationality again; **the first passage is returned**, so the answer jumps at the
    rationality of a turn, and is the same whatever other rationalities are asked for.

    Parameters
    ----------
    game : Game
        Without batch axes.
    rationalities : sequence of float
        >= 0, one over the unit of the costs, all different.
    infinite_as : float, optional
        What an infinite cost counts as.

    Raises
    ------
    GameError
        As `logit_response`; and if the game has batch axes.

    Examples
    --------
    >>> game = Game([[[5.0, 1.0], [2.0, 2.0]], [[5.0, 3.0], [1.0, 3.0]]], ["robot", "human"])
    >>> branch = logit_branch(game, [1.0, 10.0, 100.0])
    >>> branch.regret[:, 0].round(6) + 0.0
    array([0.203822, 0.      , 0.      ])
    >>> bool(branch.residual.max() < 1e-9), branch.turns
    (True, ())
    """
    if game.batch:
        names = ", ".join(axis.name for axis in game.batch)
        raise GameError(
            f"branches of a batch of games turn at different places; take one game with restrict({names}=...), or use "
            "logit_response"
        )
    axis, wanted = _rationalities(rationalities)
    if axis is None:
        raise GameError(
            f"logit_branch takes a sequence of rationalities, not {rationalities!r}; write [{rationalities!r}]"
        )
    return _solved(game, wanted, infinite_as, axis)


def _solved(
    game: Game, wanted: list[float], infinite_as: float | None, axis: Axis | None = None
) -> LogitBranch:
    plans = whole_plans(game)
    costs = finite_costs(game, infinite_as)[np.ix_(np.arange(len(game.players)), *plans)]
    branch = trace(costs, wanted)
    system = LogitSystem(costs)
    answers = [branch.answers[rationality] for rationality in wanted]
    residual = np.array([system.residual(log_p, own) for log_p, own in zip(answers, wanted, strict=True)])
    # the expected costs have 16 digits, and the rationality multiplies their rounding
    allowed = 1e-9 + 1e-14 * np.array(wanted) * system.costs.max()
    if (residual > allowed).any():
        worst = int(np.argmax(residual / allowed))
        raise GameError(
            f"at rationality {wanted[worst]} the logit equilibrium is off by {residual[worst]:.1e} in log probability, "
            f"more than {allowed[worst]:.1e}; ask for a lower rationality"
        )
    regret = np.empty((len(wanted), len(game.players)))
    for row, log_p in enumerate(answers):
        p = [np.exp(own) for own in system.split(log_p)]
        for player, expected in enumerate(expected_costs(system.costs, p)):
            regret[row, player] = p[player] @ (expected - expected.min())
    axis = Axis("rationality", wanted) if axis is None else axis
    strategies = []
    for player, (own, some) in enumerate(zip(game.plans, plans, strict=True)):
        log_p = np.full((len(wanted), len(own)), -np.inf)
        log_p[:, some] = [system.split(answer)[player] for answer in answers]
        strategies.append(Distribution([axis, own], log_p, batch=["rationality"]))
    return LogitBranch(
        product_of(strategies),
        tuple(strategies),
        residual,
        regret,
        tuple(branch.turns),
        tuple(branch.crossings),
    )


def _rationalities(rationality: Any) -> tuple[Axis | None, list[float]]:
    """Return the axis of several rationalities, None for a single one; and the numbers."""
    try:
        array = np.asarray(rationality, dtype=np.float64)
    except (TypeError, ValueError):
        raise GameError(
            f"rationality must be a number >= 0 or a sequence of them, not {rationality!r}"
        ) from None
    if array.ndim > 1:
        raise GameError(f"rationality must be a number or one-dimensional, not of shape {array.shape}")
    for value in array.reshape(-1):
        if not 0.0 <= value < np.inf:
            raise GameError(
                f"rationality must be finite and >= 0, not {value}"
                + ("; players who never err are what mixed_equilibria is for" if value == np.inf else "")
            )
    values = [float(value) for value in array.reshape(-1)]
    return (Axis("rationality", values) if array.ndim else None), values
