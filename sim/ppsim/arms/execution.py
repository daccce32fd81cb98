"""How plans are made, judged and carried out in a trial of two arms."""

from __future__ import annotations

from dataclasses import dataclass

from ppsim.arms.planners import check_planner
from ppsim.arms.world import STEP
from ppsim.errors import SimulationError

#: An arm grasps, and has arrived, within this, m.
NEAR = 0.01
#: Both agents look at the same plans, or each samples its own.
PLAN_SETS = ("shared", "independent")


@dataclass(frozen=True)
class Execution:
    """How plans are made, judged and carried out.

    Parameters
    ----------
    replan_every : float
        Seconds between replans.
    collision_stride : float
        Seconds between the instants at which the table of profiles is checked for collisions; the paper's is 0.8 s.
    clearance : float
        Metres within which arms count as in contact, for policies that weigh risk.
    timeout : float
        Seconds after which a trial ends unfinished.
    stops_in_a_row : int
        After so many safety stops in a row a seeded coin sends one arm home.
    retreat : float
        For so many seconds.
    planner : str
        Name of OMPL's planner.
    """

    replan_every: float = 0.8
    collision_stride: float = 0.1
    clearance: float = 0.01
    timeout: float = 120.0
    stops_in_a_row: int = 5
    retreat: float = 2.4
    planner: str = "RRT"

    def __post_init__(self) -> None:
        for name in ("replan_every", "collision_stride", "timeout", "retreat"):
            value = getattr(self, name)
            if not (0.0 < value < 1e6) or abs(value / STEP - round(value / STEP)) > 1e-6:
                raise SimulationError(f"{name} must be a positive multiple of {STEP} s; got {value!r}")
        if not 0.0 <= self.clearance < 1.0:
            raise SimulationError(f"clearance must lie in [0, 1) m; got {self.clearance!r}")
        if self.stops_in_a_row < 1:
            raise SimulationError(f"stops_in_a_row must be at least 1; got {self.stops_in_a_row!r}")
        check_planner(self.planner)
