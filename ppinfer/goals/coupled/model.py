"""goal-coupled: a product of small experts on what one agent does and what it sees the others do."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ppinfer.distributions import Factor
from ppinfer.errors import ModelError
from ppinfer.goals.coupled.distance import Distance, Lead
from ppinfer.goals.coupled.expert import Expert
from ppinfer.goals.coupled.motion import Motion
from ppinfer.goals.coupled.online import OnlineCoupled
from ppinfer.goals.coupled.partner import Partner
from ppinfer.goals.coupled.registry import expert_parameters, make_experts, named_experts
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.model import Assessment, GoalDesign, GoalModel, OnlineLikelihood, require_range


@dataclass(frozen=True)
class GoalCoupled(GoalModel):
    """A product of experts: gathered motion, times how everybody stands to the goals now.

    The experts that gather (the motion) make a belief that forgets,

        b_t  is proportional to  L_t (stay b_(t-1) + (1 - stay) prior),

    and the posterior at a sample is that belief times the experts that judge the instant (distances, where the partner
    is heading), normalised. These are not fed back into b. Without an expert that gathers, b is the prior.

    Parameters
    ----------
    experts : tuple of Expert
        The factors, each kind at most once.
    stay : float
        Probability per sample that the belief is kept; else the goal is drawn anew from the prior, the last goal
        included (in other models it moves to one of the others).

    Raises
    ------
    ModelError
        Where there is no expert, one occurs twice, or a parameter is out of its range.

    Notes
    -----
    The defaults are fitted to samples 0.1 s apart and lengths in the unit of the reaching study, in which a person's
    hand moves at a few units a second. Speeds are per second, so they hold for any time step; ``stay`` and a motion
    expert's tempering are per sample: `at_time_step` converts them.

    Examples
    --------
    >>> model = GoalCoupled().without("partner")
    >>> [expert.name for expert in model.experts]
    ['motion', 'distance', 'lead']
    """

    name: ClassVar[str] = "goal-coupled"
    redraws: ClassVar[bool] = True
    search: ClassVar[str] = "gradient"
    # round numbers, and not the defaults, which have seen everybody: a fit that leaves people out must not begin there
    starts: ClassVar[dict[str, float]] = {
        "stay": 0.8,
        "motion.concentration": 10.0,
        "motion.half_speed": 2.0,
        "motion.outliers": 0.05,
        "motion.tempering": 0.3,
        "distance.weight": 0.3,
        "lead.weight": 0.2,
        "lead.cap": 4.0,
        "partner.distance": 0.4,
        "partner.closing": 0.5,
        "lqr.control_weight": 5.0,
        "lqr.rationality": 0.005,
        "lqr.evidence_floor": 0.02,
        "conditional.human_weight": 0.3,
        "conditional.robot_weight": 0.3,
        "conditional.stay_weight": 0.1,
        "conditional.distance": 0.4,
        "conditional.closing": 0.5,
    }

    experts: tuple[Expert, ...] = (Motion(), Distance(), Lead(), Partner())
    stay: float = 0.77

    def __post_init__(self) -> None:
        require_range("stay", self.stay, 0.0, 1.0)
        names = [expert.name for expert in self.experts]
        if not names or len(set(names)) < len(names):
            raise ModelError(
                f"goal-coupled takes some experts, each kind once; got {', '.join(names) or 'none'}"
            )

    @property
    def needs_partner(self) -> bool:
        """Whether any expert looks at other agents."""
        return any(expert.needs_partner for expert in self.experts)

    @property
    def parameter_scales(self) -> dict[str, str]:
        """Names and scales of what `fit_goals` may fit: the experts' parameters, and ``stay`` where any gathers."""
        gathers = any(expert.gathers for expert in self.experts)
        own = {"stay": "logit"} if gathers else {}
        return own | {
            f"{expert.name}.{name}": scale for expert in self.experts for name, scale in expert.fitted.items()
        }

    @classmethod
    def parameter_types(cls, given: Mapping[str, Any]) -> dict[str, type]:
        """Return the parameters by name: ``experts``, ``stay``, and those of the experts, ``expert.parameter``."""
        experts = named_experts(str(given["experts"])) if "experts" in given else _default_kinds()
        return {"experts": str, "stay": float} | dict.fromkeys(expert_parameters(experts), float)

    @classmethod
    def from_parameters(cls, parameters: Mapping[str, Any]) -> GoalCoupled:
        """Return the model with these parameters, e.g. ``{"experts": "motion,distance", "distance.weight": 0.3}``."""
        kinds = named_experts(str(parameters["experts"])) if "experts" in parameters else _default_kinds()
        defaults = {
            f"{expert.name}.{name}": value
            for expert in cls().experts
            for name, value in expert.parameters.items()
        }
        stay = {"stay": float(parameters["stay"])} if "stay" in parameters else {}
        return cls(experts=make_experts(kinds, {**defaults, **parameters}), **stay)

    @property
    def parameters(self) -> dict[str, str | int | float]:
        """The experts' names, ``stay``, and the experts' parameters."""
        own: dict[str, str | int | float] = {
            "experts": ",".join(expert.name for expert in self.experts),
            "stay": self.stay,
        }
        return own | {
            f"{expert.name}.{name}": value
            for expert in self.experts
            for name, value in expert.parameters.items()
        }

    def with_parameters(self, **changed: Any) -> GoalCoupled:
        """Return the model with some parameters changed, named as in `parameters`; experts keep their kinds.

        Examples
        --------
        >>> GoalCoupled().with_parameters(**{"distance.weight": 0.5}).experts[1]
        Distance(weight=0.5)
        """
        experts = []
        for expert in self.experts:
            prefix = f"{expert.name}."
            own = {
                name.removeprefix(prefix): value for name, value in changed.items() if name.startswith(prefix)
            }
            experts.append(dataclasses.replace(expert, **own) if own else expert)  # type: ignore[type-var]
        return GoalCoupled(tuple(experts), changed.get("stay", self.stay))

    def without(self, *names: str) -> GoalCoupled:
        """Return the model without some experts.

        Examples
        --------
        >>> GoalCoupled().without("lead", "partner").needs_partner
        False
        """
        return dataclasses.replace(
            self, experts=tuple(expert for expert in self.experts if expert.name not in names)
        )

    def at_time_step(self, dt: float, *, fitted_at: float = 0.1) -> GoalCoupled:
        """Return the model for samples `dt` seconds apart that was fitted to samples `fitted_at` seconds apart.

        The belief forgets as much in a second, and a second of motion tells as much: stay^(dt / fitted_at), and
        tempering times dt / fitted_at. Experts without a tempering are left as they are.

        Examples
        --------
        >>> round(GoalCoupled(stay=0.81).at_time_step(0.05).stay, 3)
        0.9
        """
        ratio = dt / fitted_at
        tempering = {
            name: value * ratio
            for name, value in self.parameters.items()
            if name.endswith(".tempering") and not isinstance(value, str)
        }
        return self.with_parameters(stay=self.stay**ratio, **tempering)

    def log_likelihood(self, evidence: GoalEvidence) -> Factor:
        """Return the product of the experts that gather; zeros where there is none."""
        return self._product(evidence, gathered=True) or evidence.likelihood_factor(
            np.zeros((evidence.samples, len(evidence.goal_labels)))
        )

    def assess(self, evidence: GoalEvidence) -> Assessment:
        """Return both products, of the experts that gather and of those that judge the instant."""
        names = ", ".join(partner.name for partner in evidence.partners) if self.needs_partner else ""
        source = "differences of positions" + (f"; partner: {names}" if names else "")
        return Assessment(
            self.log_likelihood(evidence), source, instant=self._product(evidence, gathered=False)
        )

    def online(self, dt: float) -> OnlineLikelihood:
        """Return the same product for one observation at a time."""
        return OnlineCoupled(self.experts, dt)

    def simulate(self, design: GoalDesign, rng: np.random.Generator) -> GoalEvidence:
        """Return motion towards the goal pursued and away from the partner's; see `simulate_coupled`."""
        from ppinfer.goals.coupled.simulation import simulate_coupled

        return simulate_coupled(self, design, rng)

    def _product(self, evidence: GoalEvidence, *, gathered: bool) -> Factor | None:
        factors: Iterable[Factor] = (
            expert.log_factor(evidence) for expert in self.experts if expert.gathers == gathered
        )
        product: Factor | None = None
        for factor in factors:
            product = factor if product is None else product * factor
        return product


def _default_kinds() -> list[type[Expert]]:
    return [type(expert) for expert in GoalCoupled().experts]
