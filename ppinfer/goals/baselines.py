"""The baselines: the nearest goal, and the goal in the direction of travel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from ppinfer.distributions import Factor
from ppinfer.goals.evidence import GoalEvidence
from ppinfer.goals.model import LARGEST, GoalDesign, GoalModel, require_range
from ppinfer.goals.motion import previous_seen


@dataclass(frozen=True)
class NearestGoal(GoalModel):
    """Whoever is near a goal is taken to want it: p(goal) proportional to exp(-distance / scale).

    Each sample is judged by itself: between samples the goal is drawn anew from the prior. The likelihood of a position
    is the density exp(-d / scale) / (2 pi scale^2) about the goal, in two dimensions.

    Parameters
    ----------
    scale : float
        Distance (m, or the log's unit) over which the odds fall by a factor e.

    Raises
    ------
    ModelError
        Where scale is not positive.

    Examples
    --------
    >>> from ppinfer.goals import infer_goals
    >>> evidence = GoalEvidence(
    ...     time=np.zeros(1), position=np.array([[0.0, 0.0]]), goals=np.array([[[1.0, 0.0], [3.0, 0.0]]]),
    ...     row_size=np.array([1]), goal_labels=("cup", "bowl"),
    ... )
    >>> np.exp(infer_goals(NearestGoal(scale=2.0), evidence).log_posterior).round(3)
    array([[0.731, 0.269]])
    """

    name: ClassVar[str] = "nearest"
    memoryless: ClassVar[bool] = True
    window: ClassVar[int] = 1
    fitted: ClassVar[dict[str, str]] = {"scale": "log"}

    scale: float = 5.0

    def __post_init__(self) -> None:
        require_range("scale", self.scale, 0.0, LARGEST, open_low=True)

    def log_likelihood(self, evidence: GoalEvidence) -> Factor:
        """Return the log density of each position under each goal."""
        goals = evidence.goals[evidence.row_of_sample]
        distance = np.linalg.norm(goals - np.nan_to_num(evidence.position)[:, None], axis=2)
        density = -distance / self.scale - _log_radial_volume(self.scale, evidence.position.shape[1])
        return evidence.likelihood_factor(density)

    def simulate(self, design: GoalDesign, rng: np.random.Generator) -> GoalEvidence:
        """Return positions drawn independently about the goal pursued, with that density."""
        samples, space = int(design.row_size.sum()), design.start.shape[1]
        direction = rng.standard_normal((samples, space))
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        distance = rng.gamma(space, self.scale, size=(samples, 1))
        pursued = np.repeat(design.pursued, design.row_size, axis=0)
        return GoalEvidence(
            time=design.time,
            position=pursued + distance * direction,
            goals=design.goals,
            row_size=design.row_size,
            goal_labels=design.labels,
            time_step=design.dt,
        )


@dataclass(frozen=True)
class Heading(GoalModel):
    """Whoever moves towards a goal is taken to want it: a von Mises density on the direction of the last step.

    log L(goal) = concentration cos(angle) - log(2 pi I0(concentration)), the angle lying between the step that ended at
    this sample and the direction from where it began to the goal. Each sample is judged by itself: between samples the
    goal is drawn anew from the prior. A step of length zero, or one that begins on a goal, has cos = 0.

    Parameters
    ----------
    concentration : float
        kappa >= 0 of the von Mises density.

    Raises
    ------
    ModelError
        Where concentration is negative.

    Examples
    --------
    >>> from ppinfer.goals import infer_goals
    >>> evidence = GoalEvidence(
    ...     time=np.arange(2.0), position=np.array([[0.0, 0.0], [0.1, 0.0]]),
    ...     goals=np.array([[[1.0, 0.0], [-1.0, 0.0]]]), row_size=np.array([2]), goal_labels=("cup", "bowl"),
    ... )
    >>> np.exp(infer_goals(Heading(concentration=1.0), evidence).log_posterior[1]).round(3)
    array([0.881, 0.119])
    """

    name: ClassVar[str] = "heading"
    memoryless: ClassVar[bool] = True
    window: ClassVar[int] = 2
    fitted: ClassVar[dict[str, str]] = {"concentration": "log"}

    concentration: float = 2.0

    def __post_init__(self) -> None:
        require_range("concentration", self.concentration, 0.0, LARGEST)

    def log_likelihood(self, evidence: GoalEvidence) -> Factor:
        """Return the log density of the last step's direction under each goal; zero where there was no step."""
        from scipy.special import i0e

        before = previous_seen(evidence)
        stepped = (before >= 0) & evidence.seen
        origin = np.nan_to_num(evidence.position[np.maximum(before, 0)])
        step = np.where(stepped[:, None], np.nan_to_num(evidence.position) - origin, 0.0)
        towards = evidence.goals[evidence.row_of_sample] - origin[:, None]
        lengths = np.linalg.norm(step, axis=1)[:, None] * np.linalg.norm(towards, axis=2)
        alignment = np.einsum("sx,sgx->sg", step, towards)
        cosine = np.divide(alignment, lengths, out=np.zeros_like(lengths), where=lengths > 0)
        log_volume = math.log(2 * math.pi) + math.log(i0e(self.concentration)) + self.concentration
        return evidence.likelihood_factor(
            np.where(stepped[:, None], self.concentration * cosine - log_volume, 0.0)
        )

    def simulate(self, design: GoalDesign, rng: np.random.Generator) -> GoalEvidence:
        """Return plane motion in steps of 1 % of the way, each turned from the direct way by a von Mises angle."""
        from ppinfer.goals.scans import walk

        position = np.empty((int(design.row_size.sum()), 2))
        turn = rng.vonmises(0.0, self.concentration, size=len(position))
        walk(design.start, design.pursued, design.row_size, 0.01, turn, position)
        return GoalEvidence(
            time=design.time,
            position=position,
            goals=design.goals,
            row_size=design.row_size,
            goal_labels=design.labels,
            time_step=design.dt,
        )


def _log_radial_volume(scale: float, space: int) -> Float[np.ndarray, ""] | float:
    """Return the log integral of exp(-|x| / scale) over a space of that many dimensions."""
    # surface of the unit sphere times the integral of r^(space - 1) exp(-r / scale)
    log_surface = math.log(2) + 0.5 * space * math.log(math.pi) - math.lgamma(space / 2)
    return log_surface + math.lgamma(space) + space * math.log(scale)
