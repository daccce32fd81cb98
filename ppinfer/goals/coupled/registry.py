"""Experts by name, and the parameters of several of them as text."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, cast

from ppinfer.errors import ModelError
from ppinfer.goals.coupled.conditional import Conditional
from ppinfer.goals.coupled.distance import Distance, Lead
from ppinfer.goals.coupled.expert import Expert
from ppinfer.goals.coupled.lqr import LqrMotion
from ppinfer.goals.coupled.motion import Motion
from ppinfer.goals.coupled.partner import Partner
from ppinfer.goals.naming import choices

#: Experts that ``experts=...`` knows; a new one is one small file and a line here.
EXPERTS: dict[str, type[Expert]] = {
    expert.name: expert for expert in (Motion, LqrMotion, Distance, Lead, Partner, Conditional)
}


def named_experts(text: str) -> list[type[Expert]]:
    """Return the experts that a text lists, separated by commas.

    Raises
    ------
    ModelError
        Where a name is unknown (the nearest one is suggested), occurs twice, or none is given.

    Examples
    --------
    >>> [expert.__name__ for expert in named_experts("motion, distance")]
    ['Motion', 'Distance']
    """
    names = [name.strip() for name in text.split(",") if name.strip()]
    if not names:
        raise ModelError(f"experts names none; expected some of {', '.join(EXPERTS)}, separated by commas")
    for name in names:
        if name not in EXPERTS:
            raise ModelError(f"there is no expert {name!r}: expected {choices(name, list(EXPERTS))}")
        if names.count(name) > 1:
            raise ModelError(f"expert {name!r} is named twice")
    return [EXPERTS[name] for name in names]


def expert_parameters(experts: list[type[Expert]]) -> list[str]:
    """Return the names of the experts' parameters, each ``expert.parameter``.

    Examples
    --------
    >>> expert_parameters([Distance, Lead])
    ['distance.weight', 'lead.weight', 'lead.cap']
    """
    return [
        f"{expert.name}.{entry.name}" for expert in experts for entry in dataclasses.fields(cast(Any, expert))
    ]


def make_experts(experts: list[type[Expert]], parameters: Mapping[str, float]) -> tuple[Expert, ...]:
    """Return experts with these parameters, named ``expert.parameter``, and defaults for the others.

    Examples
    --------
    >>> make_experts([Distance], {"distance.weight": 0.5})
    (Distance(weight=0.5),)
    """
    made = []
    for expert in experts:
        prefix = f"{expert.name}."
        own = {
            name.removeprefix(prefix): value for name, value in parameters.items() if name.startswith(prefix)
        }
        made.append(expert(**own))
    return tuple(made)
