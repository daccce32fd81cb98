"""A policy that asks, before it executes a plan, how probable it is to stay clear of the other arm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

import numpy as np
from jaxtyping import Float

from ppinfer.coordination import Decision, Policy, Situation
from ppinfer.coordination.personality_model import PersonalityModel
from ppinfer.distributions import Distribution, Factor
from ppsim.arms.clearance import believed_plans, plan_clearance
from ppsim.arms.geometry import ARMS, Arm
from ppsim.errors import SimulationError

Ground = Literal["clear", "clear instead", "clearest"]
"""Why a plan is executed: it was wanted and is clear enough; the best that is; or none is, and it comes nearest."""


@dataclass(frozen=True, eq=False)
class CarefulDecision(Decision):
    """A decision together with what it was checked against.

    Parameters
    ----------
    wanted : int
        The plan that the policy itself decided on.
    clear : (plan,) float64
        The probability that each own plan stays clear; NaN for all but the wanted one where that was clear enough.
    ground : {"clear", "clear instead", "clearest"}
        Why the plan is executed.
    """

    wanted: int = -1
    clear: Float[np.ndarray, " plan"] = field(default_factory=lambda: np.zeros(0))
    ground: Ground = "clear"


@dataclass(frozen=True)
class Careful(Policy):
    """Execute what another policy decides on if it stays clear with probability at least 1 - eps; else what does.

    1. The policy decides. Its posterior over the other's plans is the decision's `predictive` distribution, or else
       what its belief over theta makes of them (`believed_plans`).
    2. P(clear) of the wanted plan over the horizon, from the arms' capsules. If it is at least 1 - eps, so be it.
    3. Else P(clear) of all own plans. Of those that are clear enough the one to which the policy's own distribution
       gives most, then the cheapest; if there is none, the clearest, then the one that keeps the largest distance.

    Parameters
    ----------
    policy : Policy
        That holds a belief over theta, or predicts plans; of two arms.
    eps : float
        How improbable a contact has to be.
    margin : float
        m between the arms' surfaces.
    horizon : float
        Seconds to look ahead; by default until the next replan. Longer ones make it wait for what may yet change.
    arms : mapping from agent to Arm
        Who has which arm.

    Raises
    ------
    SimulationError
        If a parameter is out of its range; when it decides, if the policy holds no belief.

    Examples
    --------
    >>> from ppinfer.coordination import BayesNash, PlanSet
    >>> reaches = PlanSet("robot", [2, 1], [0.0, 4.0, 0.0], [[1.0, 0.0], [0.0, 0.0], [1.0, 0.0]], static=1)
    >>> stays = PlanSet("human", [2, 1], [0.0, 4.0, 0.0], [[0.0, 0.0], [1.2, 0.0], [0.0, 0.0]], static=1)
    >>> contacts = [[np.inf, 2.0], [np.inf, np.inf]]
    >>> decision = Careful(BayesNash()).decide(Situation.from_contacts([reaches, stays], contacts), "robot")
    >>> decision.wanted, decision.plan, decision.ground
    (0, 0, 'clear')
    """

    name: ClassVar[str] = "careful"
    policy: Policy
    eps: float = 0.05
    margin: float = 0.0
    horizon: float = 0.8
    arms: Mapping[str, Arm] = field(default_factory=lambda: ARMS)
    samples: int = field(init=False)
    commits: bool = field(init=False)

    def __post_init__(self) -> None:
        if not 0.0 <= self.eps < 1.0 or not np.isfinite(self.margin) or not 0.1 <= self.horizon < np.inf:
            raise SimulationError(
                f"eps must lie in [0, 1), the margin be finite and the horizon at least .1 s; got {self.eps!r}, "
                f"{self.margin!r} m and {self.horizon!r} s"
            )
        object.__setattr__(self, "samples", self.policy.samples)
        object.__setattr__(self, "commits", self.policy.commits)

    def belief_model(self) -> PersonalityModel | None:
        """Return the policy's."""
        return self.policy.belief_model()

    def decide(self, situation: Situation, ego: str, memory: Any = None) -> CarefulDecision:
        """Return what the policy decides on, or what stays clear in its place."""
        wanted = self.policy.decide(situation, ego, memory)
        own = situation.plans[situation.player(ego)]
        expected = self._expected(situation, ego, wanted)
        clear = np.full(len(own), np.nan)
        first = plan_clearance(
            situation,
            ego,
            expected,
            arms=self.arms,
            margin=self.margin,
            horizon=self.horizon,
            plans=[wanted.plan],
        )
        clear[wanted.plan] = first.clear[0]
        if first.is_clear(self.eps)[0]:
            return self._decision(
                wanted, wanted.plan, wanted.distribution, wanted.profile, expected, clear, "clear"
            )
        found = plan_clearance(
            situation, ego, expected, arms=self.arms, margin=self.margin, horizon=self.horizon
        )
        enough = found.is_clear(self.eps)
        preference = _own_marginal(wanted.distribution, own.axis.name)
        ground: Ground
        if enough.any():
            ground = "clear instead"
            order = np.lexsort((own.cost, -preference, ~enough))
        else:
            ground = "clearest"
            nearest = found.distance[0].min(axis=1)
            order = np.lexsort((own.cost, -nearest, -found.clear.round(9)))
        plan = int(order[0])
        chosen = np.arange(len(own)) == plan
        point = Factor.from_mask([own.axis], chosen).normalize(own.axis.name)
        return self._decision(wanted, plan, point, None, expected, found.clear, ground)

    def _expected(self, situation: Situation, ego: str, decision: Decision) -> Distribution:
        if decision.predictive is not None:
            return decision.predictive
        if decision.belief is None:
            raise SimulationError(
                f"policy {self.policy.name!r} holds no belief, so there is no posterior over the other's plans"
            )
        return believed_plans(situation, ego, decision.belief)

    def _decision(
        self,
        wanted: Decision,
        plan: int,
        distribution: Distribution,
        profile: tuple[int, ...] | None,
        expected: Distribution,
        clear: Float[np.ndarray, " plan"],
        ground: Ground,
    ) -> CarefulDecision:
        return CarefulDecision(
            plan, distribution, profile, wanted.belief, expected, wanted.memory, wanted.plan, clear, ground
        )


def _own_marginal(distribution: Distribution, axis: str) -> Float[np.ndarray, " plan"]:
    values: np.ndarray = distribution.marginal(axis).values
    return values
