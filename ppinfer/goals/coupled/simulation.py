"""The generative twin of goal-coupled: two agents on their way to goals that are not the same."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, Int

from ppinfer.errors import ModelError
from ppinfer.goals.coupled.lqr import LqrMotion
from ppinfer.goals.coupled.motion import Motion
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.model import GoalDesign
from ppinfer.goals.partners import PartnerMotion

if TYPE_CHECKING:
    from ppinfer.goals.coupled.model import GoalCoupled

# of the way to the goal, what is covered by the end of the longest row
SHARE_COVERED = 0.8


def simulate_coupled(model: GoalCoupled, design: GoalDesign, rng: np.random.Generator) -> GoalEvidence:
    """Return plane motion of an agent and a partner, ``robot``, that heads for another goal.

    The agent moves as the model's motion expert says: in steps of equal length, each turned from the direct way by a
    von Mises angle or, for outliers, by any angle; with `LqrMotion` as its noisily rational agent does. The partner
    goes straight to a goal drawn evenly from those that the agent does not pursue (to that one, where there is no
    other).
    Tempering and stay correct how evidence is weighed and have no part in this, nor have the experts that judge the
    instant: they say which goals people take, and the design says which were taken. `draw_goals` draws from them.

    Raises
    ------
    ModelError
        Where the model has no motion expert, or the design is not in the plane.

    Examples
    --------
    >>> from ppinfer.goals.coupled import GoalCoupled
    >>> rng = np.random.default_rng(0)
    >>> evidence = simulate_coupled(GoalCoupled(), GoalDesign.random(rng, rows=3, samples=5), rng)
    >>> evidence.samples, evidence.partners[0].name
    (15, 'robot')
    """
    if design.start.shape[1] != 2:
        raise ModelError("goal-coupled simulates motion in the plane")
    share = SHARE_COVERED / int(design.row_size.max())
    position = _agent(model, design, share, rng)
    rows, count = design.goals.shape[:2]
    away = rng.integers(1, count, size=rows) if count > 1 else np.zeros(rows, dtype=np.int64)
    theirs = design.goals[np.arange(rows), (design.true_goal + away) % count]
    spread = np.abs(design.goals).max(initial=0.0)
    start = rng.uniform(-spread, spread, (rows, 2))
    robot = _walked(start, theirs, design, share, np.zeros(len(position)))
    return GoalEvidence(
        time=design.time,
        position=position,
        goals=design.goals,
        row_size=design.row_size,
        goal_labels=design.labels,
        time_step=design.dt,
        partners=(PartnerMotion("robot", robot),),
        agent="human",
    )


def draw_goals(
    model: GoalCoupled, evidence: GoalEvidence, rng: np.random.Generator
) -> Int[np.ndarray, " sample"]:
    """Return a goal for every sample, drawn from the posterior there: data that the product of experts describes.

    A product of experts says which goals go with what is seen, and not what is seen; so this is the twin that fitted
    parameters are recovered from.

    Examples
    --------
    >>> from ppinfer.goals.coupled import GoalCoupled
    >>> rng = np.random.default_rng(0)
    >>> evidence = simulate_coupled(GoalCoupled(), GoalDesign.random(rng, rows=3, samples=5), rng)
    >>> draw_goals(GoalCoupled(), evidence, rng).shape
    (15,)
    """
    from ppinfer.goals.belief import infer_goals

    probability = np.exp(infer_goals(model, evidence).log_posterior)
    drawn = rng.random(len(probability))[:, None] >= probability.cumsum(axis=1)
    goals: np.ndarray = np.minimum(drawn.sum(axis=1), probability.shape[1] - 1)
    return goals


def _agent(
    model: GoalCoupled, design: GoalDesign, share: float, rng: np.random.Generator
) -> Float[np.ndarray, "sample 2"]:
    for expert in model.experts:
        if isinstance(expert, LqrMotion):
            position: np.ndarray = expert.likelihood.simulate(design, rng).position
            return position
        if isinstance(expert, Motion):
            speed = share * np.linalg.norm(design.pursued - design.start, axis=1) / design.dt
            kappa = np.repeat(expert.concentration * speed / (speed + expert.half_speed), design.row_size)
            turn: np.ndarray = rng.vonmises(0.0, kappa)
            anywhere = rng.random(len(turn)) < expert.outliers
            turn[anywhere] = rng.uniform(-np.pi, np.pi, int(anywhere.sum()))
            return _walked(design.start, design.pursued, design, share, np.asarray(turn))
    raise ModelError("goal-coupled simulates with a motion expert (motion or lqr), and this model has none")


def _walked(
    start: Float[np.ndarray, "row 2"],
    goal: Float[np.ndarray, "row 2"],
    design: GoalDesign,
    share: float,
    turn: Float[np.ndarray, " sample"],
) -> Float[np.ndarray, "sample 2"]:
    from ppinfer.goals.scans import walk

    position: np.ndarray = np.empty((len(turn), 2))
    walk(start, goal, design.row_size, share, turn, position)
    return position
