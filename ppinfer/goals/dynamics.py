"""Linear dynamics of a point agent, and which of its state's entries are positions and velocities."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.errors import ModelError

DYNAMICS_NAMES = ("single-integrator", "double-integrator")


@dataclass(frozen=True, eq=False)
class Dynamics:
    """Discrete linear dynamics x' = A x + B u with named rooms for position and velocity.

    Parameters
    ----------
    A : (n, n) float64
        State transition over one sample.
    B : (n, m) float64
        Effect of the control over one sample.
    position_index : tuple of int
        Entries of the state that are the position, in the order of the space axis.
    velocity_index : tuple of int
        Entries that are the velocity in the same order; empty where the state has none.
    order : {1, 2}, optional
        1 where the control is the velocity and 2 where it is the acceleration: then a control can be read off a step
        of any duration. None for dynamics of another kind.
    dt : float, optional
        Seconds of one step, where `order` is None and times are to be checked against it.

    Raises
    ------
    ModelError
        Where shapes disagree, an index is out of range, or a value is not finite.

    Notes
    -----
    A goal is a state: its position, and zero everywhere else.

    Examples
    --------
    >>> dynamics = Dynamics.double_integrator(0.1)
    >>> dynamics.A.shape, dynamics.B.shape
    ((4, 4), (4, 2))
    >>> dynamics.goal_states(np.array([[1.0, 2.0]]))
    array([[1., 0., 2., 0.]])
    """

    A: Float[np.ndarray, "_ _"]
    B: Float[np.ndarray, "_ _"]
    position_index: tuple[int, ...]
    velocity_index: tuple[int, ...] = ()
    order: int | None = None
    dt: float | None = None

    def __post_init__(self) -> None:
        A, B = (np.array(matrix, dtype=np.float64) for matrix in (self.A, self.B))
        if A.ndim != 2 or A.shape[0] != A.shape[1] or B.ndim != 2 or B.shape[0] != A.shape[0]:
            raise ModelError(
                f"dynamics need A of shape (n, n) and B of shape (n, m); got {A.shape} and {B.shape}"
            )
        if not (np.isfinite(A).all() and np.isfinite(B).all()):
            raise ModelError("dynamics need finite A and B")
        index = self.position_index + self.velocity_index
        if (
            not self.position_index
            or len(set(index)) != len(index)
            or not all(0 <= i < len(A) for i in index)
        ):
            raise ModelError(
                f"position_index {self.position_index} and velocity_index {self.velocity_index} must name distinct "
                f"entries of a state of {len(A)}, with at least one position"
            )
        if self.velocity_index and len(self.velocity_index) != len(self.position_index):
            raise ModelError("velocity_index must be empty or name one velocity for each position")
        A.setflags(write=False)
        B.setflags(write=False)
        object.__setattr__(self, "A", A)
        object.__setattr__(self, "B", B)

    @classmethod
    def single_integrator(cls, dt: float, *, dimensions: int = 2) -> Dynamics:
        """State [p], control velocity: p' = p + dt u (dt in s)."""
        _check_step(dt)
        eye = np.eye(dimensions)
        return cls(eye, dt * eye, tuple(range(dimensions)), order=1, dt=dt)

    @classmethod
    def double_integrator(cls, dt: float, *, dimensions: int = 2) -> Dynamics:
        """State [px, vx, py, vy], control acceleration held over dt (s): the paper's agent."""
        _check_step(dt)
        eye = np.eye(dimensions)
        A = np.kron(eye, np.array([[1.0, dt], [0.0, 1.0]]))
        B = np.kron(eye, np.array([[0.5 * dt * dt], [dt]]))
        position = tuple(range(0, 2 * dimensions, 2))
        return cls(A, B, position, tuple(i + 1 for i in position), order=2, dt=dt)

    @classmethod
    def named(cls, name: str, dt: float, *, dimensions: int = 2) -> Dynamics:
        """Return the dynamics called `name`, one of `DYNAMICS_NAMES`, cached by its arguments."""
        return _named(name, dt, dimensions)

    @property
    def states(self) -> int:
        """Number of entries of the state, n."""
        return int(self.A.shape[0])

    @property
    def controls(self) -> int:
        """Number of entries of the control, m."""
        return int(self.B.shape[1])

    def goal_states(self, positions: Float[np.ndarray, "*batch space"]) -> Float[np.ndarray, "*batch n"]:
        """Return goals as states: the position, and zero for every other entry."""
        states = np.zeros((*positions.shape[:-1], self.states))
        states[..., list(self.position_index)] = positions
        return states

    def step(
        self, state: Float[np.ndarray, "*#batch n"], control: Float[np.ndarray, "*#batch m"]
    ) -> Float[np.ndarray, "*batch n"]:
        """Return x' = A x + B u."""
        following: np.ndarray = state @ self.A.T + control @ self.B.T
        return following

    def control_between(
        self,
        state: Float[np.ndarray, "*batch n"],
        following: Float[np.ndarray, "*batch n"],
        elapsed: Float[np.ndarray, "*batch"],
    ) -> Float[np.ndarray, "*batch m"]:
        """Return the control that takes each state to the one that followed it `elapsed` seconds later.

        Integrators divide the change of position (or velocity) by the time it took; other dynamics take the
        least-squares solution of B u = x' - A x, which holds for steps of dt.
        """
        if self.order is not None:
            index = list(self.position_index if self.order == 1 else self.velocity_index)
            change: np.ndarray = (following[..., index] - state[..., index]) / elapsed[..., None]
            return change
        control: np.ndarray = (following - state @ self.A.T) @ np.linalg.pinv(self.B).T
        return control

    def usable_step(self, elapsed: Float[np.ndarray, "*batch"]) -> Bool[np.ndarray, "*batch"]:
        """Return where a control can be read off a step of that duration (s): within 1 % of dt, if no `order`."""
        if self.order is not None or self.dt is None:
            return np.ones(elapsed.shape, dtype=bool)
        usable: np.ndarray = np.abs(elapsed - self.dt) <= 0.01 * self.dt
        return usable


def _check_step(dt: float) -> None:
    if not (np.isfinite(dt) and dt > 0):
        raise ModelError(f"the time step dt must be positive and finite (s); got {dt!r}")


@lru_cache(maxsize=64)
def _named(name: str, dt: float, dimensions: int) -> Dynamics:
    if name == "single-integrator":
        return Dynamics.single_integrator(dt, dimensions=dimensions)
    if name == "double-integrator":
        return Dynamics.double_integrator(dt, dimensions=dimensions)
    raise ModelError(f"unknown dynamics {name!r}: expected one of {', '.join(DYNAMICS_NAMES)}")
