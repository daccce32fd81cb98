"""Motion read as evidence at control rate: one replan after another, with a small state."""

from __future__ import annotations

import numpy as np

from ppinfer.coordination.equilibria import coordination_equilibria
from ppinfer.coordination.personality_model import PersonalityModel, PersonalityState
from ppinfer.coordination.reading import Anchor, Reading
from ppinfer.coordination.situation import Situation


def observe_anchored(
    model: PersonalityModel,
    reading: Reading,
    situation: Situation,
    ego: str,
    state: PersonalityState | None,
    *,
    uninformed_at_first: bool = False,
) -> PersonalityState:
    """Return what is believed at a replan, from the motion since the last one and the plans of the anchor."""
    equilibria = coordination_equilibria(situation.game, model.dominance).log_values > -np.inf
    classes = model.favoured(situation.game.costs, equilibria)
    anchor: Anchor | None = None if state is None else state.memory
    log_belief = model._moved(situation, state)
    if anchor is not None and situation.motion is not None:
        anchor, seen = anchor.after(situation.motion, reading)
    else:
        seen = False
    fresh = None
    if anchor is None or reading.reanchor:
        watched = reading.watched(len(situation.plans), situation.player(ego))
        squared = tuple(
            np.zeros(len(own)) if agent in watched else None for agent, own in enumerate(situation.plans)
        )
        fresh = Anchor(situation.plans, classes, equilibria, squared)
    compared = anchor if anchor is not None else fresh
    if compared is not None and (seen or not reading.reanchor):
        squared_rows = [None if far is None else far[None] for far in compared.squared]
        log_belief = (
            log_belief
            + reading.log_likelihood(
                squared_rows,
                compared.classes[:, None],
                compared.equilibria[None],
                np.zeros(1, np.bool_),
            )[0]
        )
    return model._state_among(
        situation,
        log_belief,
        equilibria,
        fresh if fresh is not None else anchor,
        classes=classes,
        uninformed=uninformed_at_first and state is None,
    )
