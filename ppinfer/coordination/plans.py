"""The candidate plans of one agent, each piecewise linear between timed waypoints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from ppinfer.distributions import Axis, row_starts
from ppinfer.errors import ModelError


@dataclass(frozen=True, eq=False, init=False)
class PlanSet:
    """What one agent might do from now on: some plans that reach its goal, and one that does not move.

    A plan is piecewise linear between its waypoints, and stays at the last one when it has ended.

    Parameters
    ----------
    agent : str
        Whose plans they are.
    row_size : (plan,) int64
        Waypoints of each plan, at least 1.
    time : (waypoint,) float64
        Seconds from now; 0 at the first waypoint of every plan and increasing within it.
    position : (waypoint, joint) float64
        Joint angles, rad (or whatever coordinates the plans are in).
    static : int, optional
        Which plan does not move: it costs 1 s more than the longest of the others. None: there is none.
    committed : int, optional
        Which plan is the rest of the one that the agent is executing. None: it begins anew.

    Raises
    ------
    ModelError
        If the arrays do not fit each other, or the times of a plan do not begin at 0 and increase.

    Examples
    --------
    >>> plans = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> plans.cost
    array([2., 3.])
    >>> plans.positions([0.0, 1.0, 5.0])[0].ravel()
    array([0. , 0.5, 1. ])
    """

    agent: str
    row_size: Int[np.ndarray, " plan"]
    time: Float[np.ndarray, " waypoint"]
    position: Float[np.ndarray, "waypoint joint"]
    static: int | None = None
    committed: int | None = None

    def __init__(
        self,
        agent: str,
        row_size: Any,
        time: Any,
        position: Any,
        static: int | None = None,
        committed: int | None = None,
    ) -> None:
        row_size = np.asarray(row_size, np.int64)
        time = np.asarray(time, np.float64)
        position = np.asarray(position, np.float64)
        # frozen for everybody else
        vars(self).update(
            agent=agent, row_size=row_size, time=time, position=position, static=static, committed=committed
        )
        if row_size.ndim != 1 or not row_size.size or row_size.min() < 1:
            raise ModelError(
                f"plans of {self.agent!r}: every plan has at least one waypoint; got row_size {row_size}"
            )
        if time.shape != (row_size.sum(),) or position.shape[:1] != time.shape or position.ndim != 2:
            raise ModelError(
                f"plans of {self.agent!r}: row_size sums to {row_size.sum()} waypoints; got times of shape "
                f"{time.shape} and positions of shape {position.shape}"
            )
        first = self.starts
        within = np.ones(len(time), bool)
        within[first] = False
        if (time[first] != 0.0).any() or not (np.diff(time, prepend=-1.0)[within] > 0.0).all():
            raise ModelError(f"plans of {self.agent!r}: times begin at 0 and increase within each plan")
        if not np.isfinite(position).all() or not np.isfinite(time).all():
            raise ModelError(f"plans of {self.agent!r}: times and positions must be finite")
        for name in ("static", "committed"):
            index = getattr(self, name)
            if index is not None and not 0 <= index < len(row_size):
                raise ModelError(
                    f"plans of {self.agent!r}: {name} is {index}; there are {len(row_size)} plans"
                )

    def __len__(self) -> int:
        return len(self.row_size)

    @property
    def axis(self) -> Axis:
        """The axis of these plans in a game: named for the agent, labelled by their numbers."""
        return Axis(f"{self.agent}_plan", len(self))

    @cached_property
    def starts(self) -> Int[np.ndarray, " plan"]:
        """The first waypoint of each plan."""
        starts: np.ndarray = row_starts(self.row_size)
        return starts

    @cached_property
    def duration(self) -> Float[np.ndarray, " plan"]:
        """Seconds until each plan has ended; 0 for one that does not move."""
        duration: np.ndarray = self.time[self.starts + self.row_size - 1]
        return duration

    @cached_property
    def cost(self) -> Float[np.ndarray, " plan"]:
        """Seconds that each plan costs if nothing is in its way: its duration; for the static plan, waiting."""
        cost = self.duration.copy()
        if self.static is not None:
            others = np.delete(cost, self.static)
            # finite, so that waiting is a reply
            cost[self.static] = 1.0 + (others.max() if others.size else 0.0)
        return cost

    def positions(self, times: Any) -> Float[np.ndarray, "plan time joint"]:
        """Return where each plan is at some times, s from now."""
        return self._sampled(times)[0]

    def velocities(self, times: Any) -> Float[np.ndarray, "plan time joint"]:
        """Return how fast each plan has been moving just before some times, rad/s; 0 at its start and after its end."""
        return self._sampled(times)[1]

    def _sampled(
        self, times: Any
    ) -> tuple[Float[np.ndarray, "plan time joint"], Float[np.ndarray, "plan time joint"]]:
        from ppinfer.coordination.scans import sample_plans

        when = np.atleast_1d(np.asarray(times, np.float64))
        every = np.broadcast_to(when, (len(self), len(when)))
        return sample_plans(self.starts, self.row_size, self.time, self.position, every)

    def restrict(self, chosen: Sequence[int] | Int[np.ndarray, " chosen"]) -> PlanSet:
        """Return some of the plans, in the order asked for; what waiting costs is counted among those.

        Examples
        --------
        >>> plans = PlanSet("robot", [2, 2, 1], [0.0, 2.0, 0.0, 9.0, 0.0], np.zeros((5, 1)), static=2)
        >>> plans.restrict([0, 2]).cost
        array([2., 3.])
        """
        index = np.array(chosen, np.int64)
        sizes = np.take(self.row_size, index)
        waypoint = np.repeat(self.starts[index] - row_starts(sizes), sizes) + np.arange(int(sizes.sum()))

        def place(old: int | None) -> int | None:
            if old is None or old not in index:
                return None
            return int(np.flatnonzero(index == old)[0])

        return PlanSet(
            self.agent,
            sizes,
            self.time[waypoint],
            self.position[waypoint],
            static=place(self.static),
            committed=place(self.committed),
        )

    @classmethod
    def holding(cls, agent: str, position: Any) -> PlanSet:
        """Return the plans of one who has nothing left to do: to stay where it is.

        Examples
        --------
        >>> PlanSet.holding("human", [0.1, 0.2]).duration
        array([0.])
        """
        return cls(
            agent, np.array([1]), np.zeros(1), np.asarray(position, np.float64).reshape(1, -1), static=0
        )
