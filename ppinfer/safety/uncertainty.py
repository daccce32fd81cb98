"""How uncertain another agent's position becomes, and how far from its nominal motion is far enough."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Literal

import numpy as np
from jaxtyping import Float

from ppinfer.errors import SafetyError
from ppinfer.safety.motion import LinearAgent

Growth = Literal["sqrt", "closed-loop"]
Coverage = Literal["sigma", "instant", "union"]


def uncertainty_growth(
    agent: LinearAgent, horizon: int, *, growth: Growth = "sqrt", sigma: float = 0.1
) -> Float[np.ndarray, " instant"]:
    """Return the standard deviation of an agent's position about its nominal motion, at t = 0..H.

    Parameters
    ----------
    agent : LinearAgent
        Who moves.
    horizon : int
        H, steps.
    growth : {"sqrt", "closed-loop"}
        "sqrt", as printed: sigma sqrt(t), t in steps, whatever the agent does. "closed-loop": what its own noise W
        amounts to under its feedback, Sigma+ = (A - B K) Sigma (A - B K)' + W from Sigma = 0; of the positions'
        covariance the largest standard deviation in any direction.
    sigma : float
        Standard deviation after one step, for "sqrt" (m).

    Raises
    ------
    SafetyError
        Where a value is out of its range, or the growth is unknown.

    Examples
    --------
    >>> agent = LinearAgent(np.eye(1), 0.1 * np.eye(1), 5.0 * np.eye(1), (0,), noise=np.array([[0.03]]))
    >>> uncertainty_growth(agent, 4)
    array([0.        , 0.1       , 0.14142136, 0.17320508, 0.2       ])
    >>> uncertainty_growth(agent, 4, growth="closed-loop").round(3)
    array([0.   , 0.173, 0.194, 0.198, 0.2  ])
    """
    if horizon < 1 or not 0.0 <= sigma < math.inf:
        raise SafetyError(f"horizon must be at least 1 and sigma not negative; got {horizon!r} and {sigma!r}")
    if growth == "sqrt":
        spread: np.ndarray = sigma * np.sqrt(np.arange(horizon + 1.0))
        return spread
    if growth == "closed-loop":
        return _closed_loop_spread(agent, horizon)
    raise SafetyError(f"unknown growth {growth!r}: expected 'sqrt' or 'closed-loop'")


def coverage_factor(coverage: Coverage, *, eps: float, horizon: int, space: int = 2) -> float:
    """Return kappa: within kappa standard deviations lies as much of a Gaussian as is to be covered.

    Parameters
    ----------
    coverage : {"sigma", "instant", "union"}
        "sigma": 1, as printed, which in two dimensions covers 39 % at one instant. "instant": 1 - eps at each
        instant by itself. "union": 1 - eps / H at each instant, so 1 - eps over the whole horizon.
    eps : float
        What may be left out, for one mode.
    horizon : int
        H, steps.
    space : int
        Dimensions.

    Raises
    ------
    SafetyError
        Where a value is out of its range, or the coverage is unknown.

    Examples
    --------
    >>> [round(coverage_factor(one, eps=0.05, horizon=20), 3) for one in ("instant", "union")]
    [2.448, 3.462]
    """
    if not 0.0 < eps < 1.0 or horizon < 1 or space < 1:
        raise SafetyError(
            f"eps must lie in (0, 1), horizon and space be at least 1; got {eps!r}, {horizon!r}, {space!r}"
        )
    if coverage == "sigma":
        return 1.0
    if coverage not in ("instant", "union"):
        raise SafetyError(f"unknown coverage {coverage!r}: expected 'sigma', 'instant' or 'union'")
    from scipy.special import gammaincinv

    # the squared length of a standard Gaussian vector is chi-squared: in two dimensions this is sqrt(-2 ln eps)
    left_out = eps / horizon if coverage == "union" else eps
    return float(np.sqrt(2.0 * gammaincinv(space / 2.0, 1.0 - left_out)))


@lru_cache(maxsize=64)
def _closed_loop_spread(agent: LinearAgent, horizon: int) -> Float[np.ndarray, " instant"]:
    loop, index = agent.closed_loop, np.ix_(agent.position_index, agent.position_index)
    noise = np.zeros_like(loop) if agent.noise is None else agent.noise
    covariance, spread = np.zeros_like(loop), np.zeros(horizon + 1)
    for t in range(1, horizon + 1):
        covariance = loop @ covariance @ loop.T + noise
        spread[t] = np.sqrt(max(float(np.linalg.eigvalsh(covariance[index])[-1]), 0.0))
    spread.setflags(write=False)
    return spread
