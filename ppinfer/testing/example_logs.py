"""Small study logs whose truth is known, for examples and tests."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ppinfer.goals import GoalDesign, GoalLQR, GoalModel


def example_log(
    *,
    participants: int = 3,
    trials: int = 4,
    goals: int = 3,
    samples: int = 20,
    model: GoalModel | None = None,
    positions_only: bool = False,
    seed: int = 0,
) -> xr.Dataset:
    """Return a study log simulated by a goal model: one agent (and the partners it has there), one segment a trial.

    Parameters
    ----------
    participants, trials : int
        How many people, and trials of each.
    goals, samples : int
        How many goals, and samples a trial (at 10 Hz).
    model : GoalModel, optional
        Who moves; default a `GoalLQR`.
    positions_only : bool
        Leave out velocities and controls.
    seed : int
        Of the simulation.

    Examples
    --------
    >>> log = example_log(participants=2, trials=3)
    >>> log.sizes["trial"], log.sizes["segment"]
    (6, 6)
    """
    from ppinfer.studies import build_log

    rng = np.random.default_rng(seed)
    rows = participants * trials
    design = GoalDesign.random(rng, rows=rows, goals=goals, samples=samples)
    evidence = (model or GoalLQR(control_weight=5.0, rationality=0.02)).simulate(design, rng)
    logged = {}
    for name in ("velocity", "control"):
        values = getattr(evidence, name)
        # a model of several agents logs positions only
        if values is not None and not positions_only and not evidence.partners:
            logged[name] = values[:, None]
    return build_log(
        agents=["human", *(partner.name for partner in evidence.partners)],
        goals=list(design.labels),
        row_size=design.row_size,
        time=evidence.time,
        position=np.stack([evidence.position, *(partner.position for partner in evidence.partners)], axis=1),
        goal_position=design.goals,
        participant=[f"p{row // trials}" for row in range(rows)],
        segment_trial=np.arange(rows),
        segment_agent=["human"] * rows,
        segment_start=np.zeros(rows, dtype=np.int64),
        segment_stop=design.row_size,
        true_goal=[design.labels[goal] for goal in design.true_goal],
        title="simulated by ppinfer.testing.example_log",
        control_quantity={1: "velocity", 2: "acceleration", None: "other"}[evidence.control_order],
        **logged,
    )
