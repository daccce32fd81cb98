"""The principal branch of logit equilibria, followed from rationality 0 by predictor and corrector along its arc."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import combinations, pairwise

import numpy as np
from jaxtyping import Float

from ppinfer.errors import GameError
from ppinfer.games.mixtures import expected_costs

FIRST_STEP = 0.0137  # no round number, so that no step ends on a bifurcation of a game of round costs
LEAST_STEP = 1e-6
LARGEST_CORRECTION = 0.1
LEAST_COSINE = 0.9
MOST_STEPS = 20_000


@dataclass
class Branch:
    """What was met on the way: the answers at the rationalities asked for, and where the branch turned.

    ``turns`` are the rationalities where the branch turns round; ``crossings`` those where another branch crosses it.
    """

    answers: dict[float, Float[np.ndarray, " plan"]] = field(default_factory=dict)
    turns: list[float] = field(default_factory=list)
    crossings: list[float] = field(default_factory=list)
    steps: int = 0


@dataclass(frozen=True, eq=False)
class _Point:
    """A point x = (log probabilities of all plans, rationality), the branch's direction there, and its orientation."""

    x: np.ndarray
    tangent: np.ndarray
    sign: float


class LogitSystem:
    """The equations of logit equilibrium: log p_i = log softmax(-rationality * expected costs of i's plans).

    Parameters
    ----------
    costs : (player, *plans) float64
        Finite. Costs count from the cheapest reply to each profile of the others, which changes no reply and loses no
        digits to a common offset.
    """

    def __init__(self, costs: Float[np.ndarray, "..."]) -> None:
        self.sizes = costs.shape[1:]
        self.costs = np.stack([own - own.min(axis=player, keepdims=True) for player, own in enumerate(costs)])
        self.cuts = np.cumsum(self.sizes)[:-1]

    def split(self, values: Float[np.ndarray, " plan"]) -> list[Float[np.ndarray, "_"]]:
        """Cut an array over all players' plans into the players'."""
        return np.split(values, self.cuts)

    def response(self, log_p: Float[np.ndarray, " plan"], rationality: float) -> Float[np.ndarray, " plan"]:
        """Return the log probabilities with which players answer."""
        expected = expected_costs(self.costs, [np.exp(own) for own in self.split(log_p)])
        return np.concatenate([_log_softmax(-rationality * own) for own in expected])

    def linearised(
        self, log_p: Float[np.ndarray, " plan"], rationality: float
    ) -> tuple[Float[np.ndarray, " plan"], Float[np.ndarray, "plan unknown"]]:
        """Return log p - response, and its derivatives in log p and (last) in the rationality."""
        p = [np.exp(own) for own in self.split(log_p)]
        starts = [0, *self.cuts.tolist(), len(log_p)]
        spans = [slice(start, stop) for start, stop in pairwise(starts)]
        # slope[i, j]: how the expected cost of i's plans changes with the probability of j's
        slope = np.zeros((len(log_p), len(log_p)))
        for one, other in combinations(range(len(p)), 2):
            for player in (one, other):
                own = self.costs[player]
                # from the last player on, so that the dimensions left keep their places
                for third in range(len(p) - 1, -1, -1):
                    if third not in (one, other):
                        own = np.tensordot(own, p[third], axes=(third, 0))
                if player == one:
                    slope[spans[one], spans[other]] = own
                else:
                    slope[spans[other], spans[one]] = own.T
        residual, derivative = np.empty(len(log_p)), np.empty((len(log_p), len(log_p) + 1))
        probability = np.concatenate(p)
        for player, span in enumerate(spans):
            if len(p) == 1:
                expected = self.costs[0]
            else:
                another = spans[player - 1]
                expected = slope[span, another] @ probability[another]
            answer = _log_softmax(-rationality * expected)
            residual[span] = log_p[span] - answer
            q = np.exp(answer)
            change = slope[span] * probability
            derivative[span, :-1] = rationality * (change - q @ change)
            derivative[span, -1] = expected - q @ expected
        derivative[:, :-1] += np.eye(len(log_p))
        return residual, derivative

    def residual(self, log_p: Float[np.ndarray, " plan"], rationality: float) -> float:
        """Return the largest difference of a log probability from the response: the certificate."""
        return float(np.abs(log_p - self.response(log_p, rationality)).max())


def trace(costs: Float[np.ndarray, "..."], rationalities: Sequence[float]) -> Branch:
    """Follow the principal branch until it has passed every rationality asked for.

    Parameters
    ----------
    costs : (player, *plans) float64
        Finite.
    rationalities : sequence of float
        One over the unit of the costs, >= 0.

    Returns
    -------
    Branch
        Its answers are normalised log probabilities of all players' plans, where the branch passes each rationality
        for the first time.
    """
    # in units of the largest regret, steps mean the same in every game
    system = LogitSystem(costs)
    unit = float(system.costs.max()) or 1.0
    system.costs /= unit
    branch = Branch()
    start = np.concatenate([np.full(size, -np.log(size)) for size in system.sizes])
    wanted = sorted({float(rationality) * unit for rationality in rationalities})
    found: dict[float, np.ndarray] = {}
    if wanted and wanted[0] == 0.0:
        found[wanted.pop(0)] = start
    x = np.append(start, 0.0)
    ahead = np.append(np.zeros(len(start)), 1.0)
    point = _oriented(system, x, ahead)
    step = FIRST_STEP
    while wanted:
        branch.steps += 1
        if branch.steps > MOST_STEPS:
            raise GameError(
                f"the branch of logit equilibria was followed for {MOST_STEPS} steps, to rationality "
                f"{point.x[-1] / unit:.6g}, short of {wanted[-1] / unit:.6g}; ask for a lower rationality"
            )
        least = LEAST_STEP * (1.0 + point.x[-1])
        new, correction = _stepped(system, point, step)
        crossed = new is not None and new.sign != point.sign
        if new is None or correction > LARGEST_CORRECTION or new.tangent @ point.tangent < LEAST_COSINE:
            # (the branch is smooth: a step short enough is accepted)
            if step < 1e-6 * least:
                raise GameError(
                    f"the branch of logit equilibria was lost at rationality {point.x[-1] / unit:.6g}; costs of very "
                    "different size spoil the digits"
                )
            step *= 0.4
            continue
        if crossed and step > least:
            # orientation is kept along a branch: either another branch crosses here, or ours bends away between
            # the two points and the corrector landed on another. Only short steps tell
            step *= 0.4
            continue
        if crossed:
            branch.crossings.append(float(new.x[-1]) / unit)
        pieces = [(point, 0.0, step)]
        if point.tangent[-1] * new.tangent[-1] < 0.0 and not crossed:
            turn = _turning(system, point, step)
            branch.turns.append(float(_at(system, point, turn).x[-1]) / unit)
            pieces = [(point, 0.0, turn), (point, turn, step)]
        for origin, low, high in pieces:
            end = _at(system, origin, high) if high < step else new
            while wanted and wanted[0] <= end.x[-1]:
                found[wanted[0]] = _passing(system, origin, low, high, wanted[0])
                wanted.pop(0)
        point = new
        step *= 2.0 if correction < 0.2 * LARGEST_CORRECTION else 1.0
    branch.answers = {float(rationality): found[float(rationality) * unit] for rationality in rationalities}
    return branch


def _oriented(system: LogitSystem, x: np.ndarray, ahead: np.ndarray) -> _Point:
    """Return the branch's direction at x, the one that goes ahead, and the sign that is kept along a branch."""
    _, derivative = system.linearised(x[:-1], float(x[-1]))
    bordered = np.vstack([derivative, ahead])
    tangent = np.linalg.solve(bordered, np.append(np.zeros(len(x) - 1), 1.0))
    sign, _ = np.linalg.slogdet(bordered)
    return _Point(x, tangent / np.linalg.norm(tangent), float(sign))


def _stepped(system: LogitSystem, point: _Point, step: float) -> tuple[_Point | None, float]:
    """Predict along the tangent, correct across it; return the new point, None if it was lost, and the correction."""
    predicted = point.x + step * point.tangent
    x = predicted.copy()
    for _ in range(8):
        residual, derivative = system.linearised(x[:-1], float(x[-1]))
        try:
            change = np.linalg.solve(np.vstack([derivative, point.tangent]), np.append(-residual, 0.0))
        except np.linalg.LinAlgError:
            return None, np.inf
        x += change
        moved = float(np.abs(change).max())
        # a log probability far above 0 belongs to no branch, and its exponential would overflow
        if not moved < 10.0 or x[:-1].max() > 5.0:
            return None, np.inf
        if moved < 1e-8 * (1.0 + 1e-5 * abs(x[-1])):
            break
    else:
        return None, np.inf
    try:
        return _oriented(system, x, point.tangent), float(np.abs(x - predicted).max())
    except np.linalg.LinAlgError:
        return None, np.inf


def _at(system: LogitSystem, point: _Point, step: float) -> _Point:
    """Return a point between two that were accepted."""
    new, _ = _stepped(system, point, step)
    if new is None:
        raise GameError(
            "the branch of logit equilibria was lost between two of its points; shift the rationality a little"
        )
    return new


def _turning(system: LogitSystem, point: _Point, step: float) -> float:
    """Return how far on from a point the branch turns round."""
    return _root(lambda h: float(_at(system, point, h).tangent[-1]), 0.0, step)


def _passing(
    system: LogitSystem, point: _Point, low: float, high: float, rationality: float
) -> Float[np.ndarray, " plan"]:
    """Return the normalised log probabilities where the branch passes a rationality between two steps."""
    step = _root(lambda h: float(_at(system, point, h).x[-1]) - rationality, low, high)
    log_p = _at(system, point, step).x[:-1]
    best, least = log_p, np.inf
    for _ in range(4):
        log_p = np.concatenate([_log_softmax(own) for own in system.split(log_p)])
        left = system.residual(log_p, rationality)
        if not left < least:
            break
        best, least = log_p, left
        residual, derivative = system.linearised(log_p, rationality)
        try:
            change = np.linalg.solve(derivative[:, :-1], -residual)
        except np.linalg.LinAlgError:  # at a turn
            break
        if not np.abs(change).max() < 1e-3:
            break
        log_p = log_p + change
    return best


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function that changes its sign between two arguments is zero."""
    from scipy.optimize import brentq

    function = cache(function)  # each call is a corrector of its own
    at_low, at_high = function(low), function(high)
    if at_low * at_high >= 0.0:  # rounding at an end
        return low if abs(at_low) < abs(at_high) else high
    return float(brentq(function, low, high, xtol=1e-14 * (1.0 + high), rtol=1e-14))


def _log_softmax(values: Float[np.ndarray, " plan"]) -> Float[np.ndarray, " plan"]:
    centred = values - values.max()
    return np.asarray(centred - np.log(np.exp(centred).sum()))
