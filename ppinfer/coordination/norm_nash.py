"""The policy that keeps to a norm and expects the others to (13)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

from ppinfer.coordination.choice import decide_by, hold
from ppinfer.coordination.equilibria import coordination_equilibria
from ppinfer.coordination.norms import MinNorm, Norm, among_mask
from ppinfer.coordination.policy import Decision, Policy
from ppinfer.coordination.situation import Situation


@dataclass(frozen=True)
class NormNash(Policy):
    """Play the equilibrium that is most probable under a norm (13).

    Ties go to the lowest own cost, then the lowest own plan, then the others' lowest plans. Without any equilibrium it
    holds.

    Parameters
    ----------
    norm : Norm
        By default the paper's, `MinNorm`.
    dominance : {"weak", "strict"}
        Which equilibria count; see `coordination_equilibria`.
    samples, commits
        As of every `Policy`. With `commits` it considers the rest of the plan that it is executing, so that it need
        not change its mind whenever new plans are sampled.

    Examples
    --------
    >>> from ppinfer.coordination import NormNash, PlanSet, Situation
    >>> robot = PlanSet("robot", [2, 1], [0.0, 2.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> human = PlanSet("human", [2, 1], [0.0, 4.0, 0.0], [[0.0], [1.0], [0.0]], static=1)
    >>> situation = Situation.from_contacts([robot, human], [[1.5, np.inf], [np.inf, np.inf]])
    >>> decision = NormNash().decide(situation, "human")
    >>> decision.plan, decision.profile
    (1, (0, 1))
    """

    name: ClassVar[str] = "norm"
    norm: Norm = field(default_factory=MinNorm)
    dominance: Literal["weak", "strict"] = "weak"
    samples: int = 7
    commits: bool = False

    def decide(self, situation: Situation, ego: str, memory: Any = None) -> Decision:
        """Return the part of `ego` in the norm's choice; nothing is remembered."""
        player = situation.player(ego)
        equilibria = coordination_equilibria(situation.game, self.dominance)
        if not among_mask(situation.game, equilibria).any():
            return hold(situation, player)
        return decide_by(situation, self.norm.probabilities(situation.game, equilibria), player)


@dataclass(frozen=True)
class CommittedNormNash(NormNash):
    """`NormNash` that considers the rest of its unfinished plan."""

    name: ClassVar[str] = "norm-committed"
    commits: bool = True
