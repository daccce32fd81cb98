"""How everybody stands to the goals at each sample: what most experts look at."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, Int

if TYPE_CHECKING:
    from ppinfer.goals.evidence import GoalEvidence


@dataclass(frozen=True, eq=False)
class Geometry:
    """Distances, directions and speeds at every sample, from that sample and earlier ones of its row.

    Where somebody is not seen, they are where they were last seen in the row. Lengths are in the log's unit of position
    and speeds in that unit per second, whatever the time step.

    Parameters
    ----------
    position : (sample, space) float64
        Where the agent was last seen; 0 where it has not been.
    known : (sample,) bool
        Whether the agent has been seen in the row so far.
    stepped : (sample,) bool
        Whether it is seen now and was before, so that there is a step to judge.
    distance : (sample, goal) float64
        From the agent to each goal.
    speed : (sample,) float64
        Of the last step, 0 without one.
    cosine : (sample, goal) float64
        Of the angle between the last step and the direction from where it began to each goal; 0 without a step, and for
        one of length zero or from a goal.
    partner_known : (partner, sample) bool
        Whether each partner has been seen in the row so far.
    partner_distance : (partner, sample, goal) float64
        From each partner to each goal.
    partner_closing : (partner, sample, goal) float64
        The speed at which each partner comes nearer to each goal: the component of its velocity (as logged, or the last
        difference of positions) towards it.
    goals : (row, goal, space) float64
        Positions of the goals; 0 where absent.
    present : (row, goal) bool
        Goals that exist.
    row : (sample,) int64
        Row of each sample.

    Examples
    --------
    >>> from ppinfer.goals import GoalEvidence
    >>> evidence = GoalEvidence(
    ...     time=np.arange(2.0), position=np.array([[0.0, 0.0], [0.0, 2.0]]),
    ...     goals=np.array([[[0.0, 4.0], [3.0, 0.0]]]), row_size=np.array([2]), goal_labels=("cup", "bowl"),
    ... )
    >>> evidence.geometry.distance[0], evidence.geometry.speed, evidence.geometry.cosine[1]
    (array([4., 3.]), array([0., 2.]), array([1., 0.]))
    """

    position: Float[np.ndarray, "sample space"]
    known: Bool[np.ndarray, " sample"]
    stepped: Bool[np.ndarray, " sample"]
    distance: Float[np.ndarray, "sample goal"]
    speed: Float[np.ndarray, " sample"]
    cosine: Float[np.ndarray, "sample goal"]
    partner_known: Bool[np.ndarray, "partner sample"]
    partner_distance: Float[np.ndarray, "partner sample goal"]
    partner_closing: Float[np.ndarray, "partner sample goal"]
    goals: Float[np.ndarray, "row goal space"]
    present: Bool[np.ndarray, "row goal"]
    row: Int[np.ndarray, " sample"]

    @classmethod
    def of(cls, evidence: GoalEvidence) -> Geometry:
        """Return the geometry of evidence, all samples in one compiled pass per agent."""
        from ppinfer.goals.coupled.scans import agent_geometry, partner_geometry

        goals = np.where(evidence.goal_present[..., None], evidence.goals, 0.0)
        samples, count, partners = evidence.samples, goals.shape[1], len(evidence.partners)
        position = np.empty_like(evidence.position)
        known, stepped = np.empty((2, samples), dtype=bool)
        distance, cosine = np.empty((2, samples, count))
        speed = np.empty(samples)
        agent_geometry(
            evidence.time, evidence.position, evidence.seen, evidence.row_size, goals,
            position, known, stepped, distance, speed, cosine,
        )  # fmt: skip
        partner_known = np.empty((partners, samples), dtype=bool)
        partner_distance, partner_closing = np.empty((2, partners, samples, count))
        for index, partner in enumerate(evidence.partners):
            partner.check_velocity()
            logged = partner.velocity is not None
            partner_geometry(
                evidence.time,
                partner.position,
                partner.position if partner.velocity is None else partner.velocity,
                logged,
                partner.seen,
                evidence.row_size,
                goals,
                partner_known[index],
                partner_distance[index],
                partner_closing[index],
            )
        return cls(
            position, known, stepped, distance, speed, cosine, partner_known, partner_distance, partner_closing,
            goals, evidence.goal_present, evidence.row_of_sample,
        )  # fmt: skip

    @property
    def present_at(self) -> Bool[np.ndarray, "sample goal"]:
        """Whether each goal exists at each sample."""
        there: np.ndarray = self.present[self.row]
        return there
