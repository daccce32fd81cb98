"""What a policy is: it looks at a situation and decides, and says which distribution led it there."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from ppinfer.coordination.situation import Situation
from ppinfer.distributions import Distribution

if TYPE_CHECKING:
    from ppinfer.coordination.personality_model import PersonalityModel


@dataclass(frozen=True, eq=False)
class Decision:
    """What an agent does until the next replan, and why.

    Parameters
    ----------
    plan : int
        Number of the agent's own plan.
    distribution : Distribution
        The whole distribution that led to it: over the profiles of the game (its plan axes), or over the agent's own
        plans where it never thought of profiles.
    profile : tuple of int, optional
        The equilibrium whose part the plan is, one plan for every agent; None where there is none.
    belief : Distribution, optional
        Over ``theta``: whom the other agent's equilibria favour.
    predictive : Distribution, optional
        Over the other agent's plans.
    memory : object
        What the policy wants to know at its next replan; hand it back to `Policy.decide`.
    """

    plan: int
    distribution: Distribution
    profile: tuple[int, ...] | None = None
    belief: Distribution | None = None
    predictive: Distribution | None = None
    memory: Any = field(default=None, repr=False)


class Policy(ABC):
    """How an agent chooses among its plans; subclasses are small frozen dataclasses of parameters.

    `decide` is a pure function of its arguments: whatever a policy learns in a trial travels in `Decision.memory`.

    Attributes
    ----------
    name : str
        What commands and logs call it.
    samples : int
        How many plans it wants sampled for each agent, besides the static one.
    commits : bool
        Whether the rest of the plan that it is executing takes the place of the first of its sampled plans.

    Examples
    --------
    A policy of one's own: never move.

    >>> from dataclasses import dataclass
    >>> import numpy as np
    >>> from ppinfer.coordination import Decision, PlanSet, Policy, Situation
    >>> from ppinfer.distributions import Factor
    >>> @dataclass(frozen=True)
    ... class Stay(Policy):
    ...     def decide(self, situation, ego, memory=None):
    ...         own = situation.plans[situation.player(ego)]
    ...         still = np.arange(len(own)) == own.static
    ...         return Decision(own.static, Factor.from_mask([own.axis], still).normalize(own.axis.name))
    >>> plans = [PlanSet.holding("robot", [0.0]), PlanSet.holding("human", [1.0])]
    >>> Stay().decide(Situation.from_contacts(plans, [[np.inf]]), "robot").plan
    0
    """

    name: ClassVar[str] = "custom"
    samples: int = 7
    commits: bool = False

    @abstractmethod
    def decide(self, situation: Situation, ego: str, memory: Any = None) -> Decision:
        """Return what `ego` does in a situation; `memory` is that of its last decision in the trial, or None."""

    def belief_model(self) -> PersonalityModel | None:
        """Return the model behind `Decision.belief`, which a log keeps so that beliefs can be inferred again."""
        return None
