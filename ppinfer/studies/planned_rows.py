"""Where the replans, plans, waypoints and profiles of each trial lie in the flat arrays of a log."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from jaxtyping import Int


@dataclass(frozen=True, eq=False)
class PlannedRows:
    """Edges of the ragged dimensions of planned worlds: where each begins, and where the last one ends.

    Parameters
    ----------
    replan : (trial + 1,) int64
        In ``replan``, of each trial.
    plan, profile : (replan + 1,) int64
        In ``plan`` and ``profile``, of each replan.
    waypoint : (plan + 1,) int64
        In ``waypoint``, of each plan.

    Examples
    --------
    >>> rows = PlannedRows.of(np.array([1, 1]), np.array([[2, 1], [2, 2]]), np.array([3, 1, 1, 2, 2, 1, 1]))
    >>> rows.trials("plan").tolist(), rows.trials("waypoint").tolist(), rows.trials("profile").tolist()
    ([0, 3, 7], [0, 5, 11], [0, 2, 6])
    """

    replan: Int[np.ndarray, " trial_edge"]
    plan: Int[np.ndarray, " replan_edge"]
    profile: Int[np.ndarray, " replan_edge"]
    waypoint: Int[np.ndarray, " plan_edge"]

    @classmethod
    def of(
        cls,
        replan_row_size: Int[np.ndarray, " trial"],
        plan_row_size: Int[np.ndarray, "replan agent"],
        waypoint_row_size: Int[np.ndarray, " plan"],
    ) -> PlannedRows:
        """Return the edges that row sizes make."""
        return cls(
            replan=_edges(replan_row_size),
            plan=_edges(plan_row_size.sum(axis=1)),
            profile=_edges(cells(plan_row_size)),
            waypoint=_edges(waypoint_row_size),
        )

    @classmethod
    def of_log(cls, log: xr.Dataset) -> PlannedRows:
        """Return the edges of a log that has replans."""
        return cls.of(
            *(
                log.variables[name].values
                for name in ("replan_row_size", "plan_row_size", "waypoint_row_size")
            )
        )

    def trials(self, dim: str) -> Int[np.ndarray, " trial_edge"]:
        """Return where each trial begins along ``replan``, ``plan``, ``waypoint`` or ``profile``."""
        if dim == "replan":
            return self.replan
        edges: np.ndarray = self.profile[self.replan] if dim == "profile" else self.plan[self.replan]
        if dim == "waypoint":
            edges = self.waypoint[edges]
        return edges

    @property
    def sizes(self) -> dict[str, int]:
        """How long each dimension is by these row sizes."""
        return {dim: int(self.trials(dim)[-1]) for dim in ("replan", "plan", "waypoint", "profile")}


def cells(plan_row_size: Int[np.ndarray, "replan agent"]) -> Int[np.ndarray, " replan"]:
    """Return how many profiles the grid of each replan has; an agent that has left counts as one.

    Examples
    --------
    >>> cells(np.array([[8, 8], [8, 0]])).tolist()
    [64, 8]
    """
    counted: np.ndarray = np.maximum(plan_row_size, 1).prod(axis=1)
    return counted


def _edges(row_size: Int[np.ndarray, " row"]) -> Int[np.ndarray, " edge"]:
    return np.concatenate([[0], np.cumsum(row_size)])
