"""Who moves how: agents under linear feedback, and what others may be heading for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from ppinfer.errors import SafetyError


@dataclass(frozen=True, eq=False)
class LinearAgent:
    """An agent x' = A x + B u + w, w ~ N(0, W), that pursues a target state by u = -K (x - target).

    Parameters
    ----------
    A : (n, n) float64
        State transition over one step.
    B : (n, m) float64
        Effect of the control over one step.
    gain : (m, n) float64
        K, stabilising.
    position_index : tuple of int
        Entries of the state that are the position.
    noise : (n, n) float64, optional
        W, covariance of the disturbance per step; default none.
    control_limit : float, optional
        Largest norm of the control; default none.

    Raises
    ------
    SafetyError
        Where shapes disagree, a value is not finite, W is no covariance, or the limit is not positive.

    Examples
    --------
    >>> agent = LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1))
    >>> agent.closed_loop
    array([[0.9, 0. ],
           [0. , 0.9]])
    """

    A: Float[np.ndarray, "_ _"]
    B: Float[np.ndarray, "_ _"]
    gain: Float[np.ndarray, "_ _"]
    position_index: tuple[int, ...]
    noise: Float[np.ndarray, "_ _"] | None = None
    control_limit: float | None = None

    def __post_init__(self) -> None:
        for name in ("A", "B", "gain", "noise"):
            value = getattr(self, name)
            if value is not None:
                value = np.array(value, dtype=np.float64, order="C")
                value.setflags(write=False)
                object.__setattr__(self, name, value)
        n, m = self.B.shape if self.B.ndim == 2 else (0, 0)
        for name, shape in (("A", (n, n)), ("B", (n, m)), ("gain", (m, n)), ("noise", (n, n))):
            value = getattr(self, name)
            if value is not None and (value.shape != shape or not np.isfinite(value).all()):
                raise SafetyError(f"{name} must be finite and of shape {shape}; got shape {value.shape}")
        if not self.position_index or not all(0 <= index < n for index in self.position_index):
            raise SafetyError(f"position_index {self.position_index} does not fit a state of {n} entries")
        if self.noise is not None and (
            not np.allclose(self.noise, self.noise.T) or np.linalg.eigvalsh(self.noise)[0] < -1e-12
        ):
            raise SafetyError("noise must be a covariance: symmetric and positive semi-definite")
        if self.control_limit is not None and not self.control_limit > 0:
            raise SafetyError(f"control_limit must be positive; got {self.control_limit!r}")

    @property
    def closed_loop(self) -> Float[np.ndarray, "n n"]:
        """A - B K."""
        loop: np.ndarray = self.A - self.B @ self.gain
        return loop

    @cached_property
    def noise_root(self) -> Float[np.ndarray, "n n"]:
        """L with L L' = W; zero without noise."""
        if self.noise is None:
            return np.zeros_like(self.A)
        values, vectors = np.linalg.eigh(self.noise)
        root: np.ndarray = vectors * np.sqrt(np.maximum(values, 0.0))
        return root

    def position(self, state: Float[np.ndarray, "*batch n"]) -> Float[np.ndarray, "*batch space"]:
        """Return the position in each state."""
        return state[..., list(self.position_index)]


@dataclass(frozen=True, eq=False)
class Mover:
    """Another agent: where it is, and where it may be heading with which probability.

    Parameters
    ----------
    agent : LinearAgent
        How it moves; nothing here assumes that it avoids anybody.
    state : (n,) float64
        Now.
    targets : (mode, n) float64
        The states it may pursue.
    probability : (mode,) float64
        Of each of them; sums to one.

    Raises
    ------
    SafetyError
        Where shapes disagree, values are not finite, or the probabilities are no distribution.

    Examples
    --------
    >>> agent = LinearAgent(np.eye(2), 0.1 * np.eye(2), np.eye(2), (0, 1))
    >>> mover = Mover(agent, np.zeros(2), np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([0.7, 0.3]))
    >>> mover.modes
    2
    """

    agent: LinearAgent
    state: Float[np.ndarray, " _"]
    targets: Float[np.ndarray, "_ _"]
    probability: Float[np.ndarray, " _"]

    def __post_init__(self) -> None:
        n = len(self.agent.A)
        for name in ("state", "targets", "probability"):
            object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name), dtype=np.float64))
        modes = len(self.probability)
        for name, shape in (("state", (n,)), ("targets", (modes, n)), ("probability", (modes,))):
            value = getattr(self, name)
            if value.shape != shape or not np.isfinite(value).all():
                raise SafetyError(f"{name} must be finite and of shape {shape}; got shape {value.shape}")
        if modes == 0 or self.probability.min() < 0 or abs(self.probability.sum() - 1.0) > 1e-9:
            raise SafetyError(
                f"probability must be a distribution over {modes} targets; got {self.probability.tolist()}"
            )

    @property
    def modes(self) -> int:
        """How many targets there are."""
        return len(self.probability)
