"""How everybody stands to the goals now: the geometry of one observation after another."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Bool, Float

from ppinfer.errors import LogError
from ppinfer.goals.coupled.geometry import Geometry
from ppinfer.goals.model import Observation


class OnlineGeometry:
    """The geometry of each instant, from the observations of a row so far.

    Examples
    --------
    >>> tracker = OnlineGeometry()
    >>> tracker.restart(np.array([[3.0, 4.0]]), np.array([True]))
    >>> tracker.step(Observation(0.0, np.zeros(2))).distance
    array([[5.]])
    """

    def restart(self, goals: Float[np.ndarray, "goal space"], present: Bool[np.ndarray, " goal"]) -> None:
        """Begin a row with these goals."""
        self._goals = np.where(present[:, None], goals, 0.0)
        self._present = present[None].copy()
        self._agent = _Track()
        self._partners: list[_Track] | None = None

    def step(self, observation: Observation) -> Geometry:
        """Return the geometry now, one sample of it."""
        goals = self._goals
        count, space = goals.shape
        before = self._agent.position
        step, elapsed = self._agent.see(observation)
        speed, cosine = 0.0, np.zeros(count)
        if step is not None and before is not None:
            length = math.sqrt(float(step @ step))
            speed = length / elapsed
            towards = goals - before
            lengths = length * np.sqrt((towards * towards).sum(axis=1))
            np.divide(towards @ step, lengths, out=cosine, where=lengths > 0)
            np.clip(cosine, -1.0, 1.0, out=cosine)
        if self._partners is None:
            self._partners = [_Track() for _ in observation.partners]
        if len(self._partners) != len(observation.partners):
            raise LogError(
                f"the row began with {len(self._partners)} partners, and {len(observation.partners)} are given at time "
                f"{observation.time!r}; pass position=None for one that is not seen"
            )
        known = np.zeros((len(self._partners), 1), dtype=bool)
        distance, closing = np.zeros((2, len(self._partners), 1, count))
        for index, (track, partner) in enumerate(zip(self._partners, observation.partners, strict=True)):
            track.see(partner, time=observation.time)
            if track.position is None:
                continue
            away = goals - track.position
            length = np.sqrt((away * away).sum(axis=1))
            known[index] = True
            distance[index, 0] = length
            np.divide(away @ track.velocity, length, out=closing[index, 0], where=length > 0)
        position = self._agent.position
        there = np.zeros(space) if position is None else position
        off = goals - there
        return Geometry(
            position=there[None],
            known=np.array([position is not None]),
            stepped=np.array([step is not None]),
            distance=np.sqrt((off * off).sum(axis=1))[None] if position is not None else np.zeros((1, count)),
            speed=np.array([speed]),
            cosine=cosine[None],
            partner_known=known,
            partner_distance=distance,
            partner_closing=closing,
            goals=goals[None],
            present=self._present,
            row=np.zeros(1, dtype=np.int64),
        )


class _Track:
    """Where somebody was last seen, when, and how fast they were."""

    def __init__(self) -> None:
        self.position: Float[np.ndarray, " space"] | None = None
        self.velocity: Float[np.ndarray, " space"] = np.zeros(0)
        self._time = math.nan

    def see(
        self, observation: Observation, time: float | None = None
    ) -> tuple[Float[np.ndarray, " space"] | None, float]:
        """Take in an observation; return the step that led here, if there was one, and how long it took in s."""
        if observation.position is None:
            return None, math.nan
        now = observation.time if time is None else time
        position = np.asarray(observation.position, dtype=np.float64)
        step = None if self.position is None else position - self.position
        elapsed = now - self._time
        if observation.velocity is not None:
            self.velocity = np.asarray(observation.velocity, dtype=np.float64)
        else:
            self.velocity = np.zeros_like(position) if step is None else step / elapsed
        self.position, self._time = position, now
        return step, elapsed
